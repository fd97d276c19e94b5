"""Outcomes of grasps at a step against those at 0.5 ms.

Random trials: shipped strategies of both hands, their closing times drawn from 0.05 to 0.8 s with
wide chokes, their objects displaced. And the marker, which rolls, under RBO Hand 1.

Random trials that are finished are kept in out/bench/sim-outcomes.jsonl, so that a stopped run
goes on.

python -m bench.sim.outcomes --help
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from scipy.stats import binomtest

from bench import kept
from bench.row import at_least, at_most, stated
from bench.sim.verdicts import SOURCES
from grasp_strategies import in_process_scene
from grasp_strategies.strategy import Strategy
from pneuflex_sim.world import Diverged
from softhand_model.pneumatics.parameters import load_pneumatics
from softhand_trials.trials import Placement, StartedScene, TrialSettings, run_trial

KEPT = Path("out/bench/sim-outcomes.jsonl")
REFERENCE = 0.0005  # [s] step
TRIALS, SEEDS = 200, 40  # random trials, seeds of the marker; the command takes fewer
PART = 10  # of them are run among the other groups
AGREEING_TARGET = 0.95
CLOSING = (0.05, 0.8)  # [s]
SHIFT = 0.020  # [m] largest displacement of the object
WIDE = 0.004  # [m] chokes and tubes: air keeps up with its command
CASES = (
    TrialSettings("surface_constrained", "cylinder"),
    TrialSettings("rbo_hand_2_ball", "ball"),
    TrialSettings("rbo_hand_1_surface", "tube", model="rbo_hand_1", segments=10),
    TrialSettings("rbo_hand_1_surface", "cylinder", model="rbo_hand_1", segments=10),
)
MARKER = TrialSettings(
    "rbo_hand_1_surface", "marker", model="rbo_hand_1", segments=10, offset=0.020
)


def faster(strategy: Strategy, closing: float) -> Strategy:
    """A strategy whose air follows ramps of this duration [s]."""
    phases = tuple(
        replace(phase, air_ramp=closing) if phase.air_ramp > 0.0 else phase
        for phase in strategy.phases
    )
    return replace(strategy, phases=phases)


def random_outcome(seed: int, step: float) -> str:
    """Outcome of the random trial of a seed at a step [s], or `diverged`."""
    draw = np.random.default_rng(seed)
    settings = replace(CASES[int(draw.integers(len(CASES)))], step=step)
    offset = tuple(draw.uniform(-SHIFT, SHIFT, 2).tolist())
    placement = Placement(offset, mass_scale=float(draw.uniform(0.5, 2.0)))
    closing = float(np.exp(draw.uniform(*np.log(CLOSING))))
    box = load_pneumatics()
    choke = replace(box.choke, inlet_diameter=WIDE, outlet_diameter=WIDE)
    wide = replace(box, choke=choke, line=replace(box.line, diameter=WIDE))
    with mock.patch.object(in_process_scene, "load_pneumatics", lambda: wide):
        started = StartedScene(settings)
        started.strategy = faster(started.strategy, closing)
        try:
            return started.run(placement).outcome
        except Diverged:
            return "diverged"


def marker_outcomes(step: float, seeds: int) -> list[str]:
    """Outcomes of the marker's trials at a step [s]."""
    return [run_trial(seed, replace(MARKER, step=step)).result.outcome for seed in range(seeds)]


def within(successes: int, reference: int, count: int) -> bool:
    """Whether a rate lies in the 95 % interval of another of as many trials (Wilson)."""
    interval = binomtest(reference, count).proportion_ci(0.95, "wilson")
    return bool(interval.low <= successes / count <= interval.high)


def random_rows(step: float, trials: int) -> list[dict[str, Any]]:
    """Rows of random trials at a step [s]."""
    once, pairs = kept.Once(KEPT, SOURCES), []
    for seed in range(trials):
        ours, fine = (
            once(f"{seed}, {at} s", lambda seed=seed, at=at: random_outcome(seed, at))
            for at in (step, REFERENCE)
        )
        pairs.append((ours, fine))
        print(f"  random {seed}: {' / '.join(pairs[-1])}", file=sys.stderr, flush=True)
    agreeing = sum(ours == reference for ours, reference in pairs) / trials
    diverged = sum("diverged" in pair for pair in pairs)
    held = sum(reference == "gripped" for _, reference in pairs)
    name = f"random grasps, {1e3 * step:g} ms"
    return [
        at_most(f"{name}: diverged", diverged, f"of {trials}", 0),
        at_least(f"{name}: outcome as at 0.5 ms", agreeing, f"of {trials}", AGREEING_TARGET),
        stated(f"{name}: gripped at 0.5 ms", held, f"of {trials}"),
    ]


def marker_rows(step: float, seeds: int) -> list[dict[str, Any]]:
    """Rows of the marker at a step [s]."""
    ours, reference = marker_outcomes(step, seeds), marker_outcomes(REFERENCE, seeds)
    counts = ours.count("gripped"), reference.count("gripped")
    agreeing = sum(a == b for a, b in zip(ours, reference, strict=True)) / seeds
    name = f"marker, {1e3 * step:g} ms"
    return [
        stated(f"{name}: gripped", counts[0], f"of {seeds}"),
        stated(f"{name}: gripped at 0.5 ms", counts[1], f"of {seeds}"),
        at_least(f"{name}: rate in the interval of that at 0.5 ms", within(*counts, seeds), "", 1),
        stated(f"{name}: outcome as at 0.5 ms", agreeing, f"of {seeds}"),
    ]


def rows(small: bool) -> list[dict[str, Any]]:
    """A part of the trials, at the default step; the command runs more."""
    count, step = 2 if small else PART, TrialSettings().step
    return [*random_rows(step, count), *marker_rows(step, count)]


def main(arguments: Sequence[str] | None = None) -> None:
    """Run trials, and print the rows."""
    parser = argparse.ArgumentParser(
        prog="bench.sim.outcomes", description="Compare outcomes of grasps with those at 0.5 ms."
    )
    parser.add_argument("--trials", type=int, default=TRIALS, help="random grasps (%(default)s)")
    parser.add_argument("--seeds", type=int, default=SEEDS, help="of the marker (%(default)s)")
    usual = [TrialSettings().step]
    parser.add_argument("--steps", type=float, nargs="+", default=usual, help="[s] (%(default)s)")
    given = parser.parse_args(arguments)
    for step in given.steps:
        found = random_rows(step, given.trials) if given.trials else []
        for row in found + (marker_rows(step, given.seeds) if given.seeds else []):
            print(f"{row['name']:60s} {row['value']:.4g} {row['unit']} {row['target'] or ''}")


if __name__ == "__main__":
    main()
