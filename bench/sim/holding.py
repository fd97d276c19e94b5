"""Where a hand must hold at coarse steps: grasps, clashes and blows, none of which may diverge.

Grasps are those of both hands at table, edge and wall, and a stored one of the Feix taxonomy.
`random_trials`, `friction` (jammed fingertips) and `outcomes` (fast closings) have more.
"""

from __future__ import annotations

import itertools
import sys
import warnings
from dataclasses import replace
from typing import Any

import numpy as np

from bench.row import at_least, at_most
from bench.sim.random_trials import PALM_DOWN, masses_at
from pneuflex_sim.simulation import Simulation, SimulationConfig
from pneuflex_sim.world import Diverged
from softhand_trials.trials import TrialSettings, run_trial

STEPS = (0.0005, 0.001, 0.002, 0.005)  # [s]
SEGMENTS = (5, 10, 15)
SEEDS = range(3)
HAND_1: dict[str, Any] = {"model": "rbo_hand_1", "segments": 10}
DEFAULTS = (  # a cylinder where it lies well: each seed must be gripped
    TrialSettings("surface_constrained", "cylinder"),
    TrialSettings("rbo_hand_1_surface", "cylinder", **HAND_1),
)
OTHERS = (  # none may diverge
    TrialSettings("rbo_hand_1_edge", "rod", "edge", **HAND_1),
    TrialSettings("rbo_hand_2_slide_to_wall", "thin_cylinder", "wall"),
    TrialSettings("rbo_hand_2_ball", "ball"),
    TrialSettings("feix/01", "cylinder_80", "held", segments=6, finger_contact=True),
    TrialSettings("rbo_hand_1_surface", "marker", offset=0.02, **HAND_1),
)
FALL = (0.05, -0.02)  # [m] heights to which the wrist is commanded from the air, below the table
PRESSURE = 100e3  # [Pa]
RAMP = 0.05  # [s]
STILL, STRAIGHT = 0.3, 0.15  # [rad/s] of joints, [rad] of tips, when a clash has ended


def _ramp(simulation: Simulation, pressure: float, duration: float) -> None:
    """Bring all channels to a gauge pressure [Pa], and wait until a duration [s] has passed."""
    masses = masses_at(simulation, np.full(len(simulation.channels), pressure))
    begin, start = simulation.time, simulation.air_masses()
    while simulation.time < begin + duration:
        share = min(1.0, (simulation.time - begin) / RAMP)
        simulation.set_air_masses(start + share * (masses - start))
        simulation.step()


def clash(step: float, segments: int, pressure: float = PRESSURE) -> str:
    """Thumb and fingers that clash in free air and are vented; empty, or why it failed."""
    simulation = Simulation(SimulationConfig(step=step, segments=segments))
    try:
        for duration, level in ((0.05, pressure), (0.3, pressure), (0.05, 0.0), (2.5, 0.0)):
            _ramp(simulation, level, duration)
        fastest = float(abs(simulation.bodies.v).max())
        bent = max(abs(angle) for angle in simulation.tip_angles().values())
        return "" if fastest < STILL and bent < STRAIGHT else f"{fastest:.2f} rad/s, {bent:.2f} rad"
    except Diverged as error:
        return str(error)
    finally:
        simulation.close()


def blow(step: float, segments: int, height: float, model: str | None) -> str:
    """A bent hand that is driven into the table and inflated there; empty, or why it failed."""
    hand = "rbo_hand_2" if model is None else model
    simulation = Simulation(
        SimulationConfig(hand=hand, model=model, step=step, segments=segments, object="marker")
    )
    try:
        _ramp(simulation, 0.3 * PRESSURE, 0.5)
        simulation.command_wrist(np.array([-0.057, -0.015, height]), PALM_DOWN)
        for level in (0.3, 1.0, 0.0, 1.0, 0.3):
            _ramp(simulation, level * PRESSURE, 0.4)
        return ""
    except Diverged as error:
        return str(error)
    finally:
        simulation.close()


def grasp(settings: TrialSettings, seed: int) -> str:
    """Outcome of a trial, or why it diverged."""
    try:
        return run_trial(seed, settings).result.outcome
    except Diverged as error:
        return str(error)


def _told(name: str, found: dict[str, str]) -> None:
    for case, text in found.items():
        print(f"  {name}, {case}: {text}", file=sys.stderr, flush=True)


def default_rows(small: bool) -> list[dict[str, Any]]:
    """Default grasps of both hands."""
    rows = []
    for step in STEPS[-1:] if small else STEPS:
        found = {
            f"{settings.strategy}, {segments} segments, seed {seed}": grasp(
                replace(settings, step=step, segments=segments), seed
            )
            for settings, segments, seed in itertools.product(DEFAULTS, SEGMENTS, SEEDS)
        }
        name = f"default grasps, {1e3 * step:g} ms"
        _told(name, {case: text for case, text in found.items() if text != "gripped"})
        held = sum(text == "gripped" for text in found.values())
        rows.append(at_least(f"{name}: gripped", held, f"of {len(found)}", len(found)))
    return rows


def other_rows(small: bool) -> list[dict[str, Any]]:
    """Grasps at edge and wall, of ball and marker, and one that is held out."""
    rows = []
    for step in STEPS[-1:] if small else STEPS[1:]:
        settings = [replace(case, step=step) for case in OTHERS]
        found = {
            f"{case.strategy}, {case.object}, seed {seed}": grasp(case, seed)
            for case, seed in itertools.product(settings, SEEDS)
        }
        name = f"other grasps, {1e3 * step:g} ms"
        _told(name, found)
        diverged = sum("diverged" in text for text in found.values())
        rows.append(at_most(f"{name}: diverged", diverged, f"of {len(found)}", 0))
    return rows


def violent_rows(small: bool) -> list[dict[str, Any]]:
    """Clashes and blows."""
    rows = []
    for step in STEPS[-1:] if small else STEPS[1:]:
        counts = SEGMENTS if step >= 0.002 else SEGMENTS[:1]
        clashes = {
            f"{segments} segments, {1e-3 * pressure:g} kPa": clash(step, segments, pressure)
            for segments, pressure in itertools.product((*counts, 8), (0.6 * PRESSURE, PRESSURE))
        }
        blows = {
            f"{model}, {segments} segments, {height:g} m": blow(step, segments, height, model)
            for segments, height, model in itertools.product(counts, FALL, (None, "rbo_hand_1"))
        }
        for kind, found in (("clashes", clashes), ("blows", blows)):
            name = f"{kind}, {1e3 * step:g} ms"
            failed = {case: text for case, text in found.items() if text}
            _told(name, failed)
            rows.append(at_most(f"{name}: failed", len(failed), f"of {len(found)}", 0))
    return rows


def rows(small: bool) -> list[dict[str, Any]]:
    """All rows; at 5 ms alone when it is small."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of joints at their stops: meant here
        return [*violent_rows(small), *default_rows(small), *other_rows(small)]
