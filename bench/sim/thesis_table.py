"""Table 5.2 re-made: simulated seconds per CPU second of a grasp, 1 to 50 ms, by the settings of
the solver; the thesis' numbers (SOFA on another machine: an order of magnitude only) beside them.
`python -m bench.sim.thesis_table` prints it, with MuJoCo.

A contact counts as missed when its pair of links first touches deeper in one another than DEEP: a
step before they did not touch. What passes through within one step leaves no such trace: it shows
in the outcome. A grasp whose simulation diverged has no figures but that.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from bench.row import at_least, at_most, stated
from bench.sim.mujoco_hand import MUJOCO
from bench.sim.mujoco_hand import grasp as mujoco_grasp
from bench.sim.timing import StepTimes, timed_steps
from grasp_strategies.judging.judge import GraspResult
from pneuflex_sim.bullet import pybullet
from pneuflex_sim.simulation import Simulation
from softhand_trials.trials import TrialSettings, run_trial

STEPS = (0.001, 0.002, 0.005, 0.010, 0.020, 0.050)
ACTUATORS = 6
THESIS = {
    ("fast", 5): (0.06, 0.13, 0.28, 0.45, 0.89, 1.92),
    ("default", 5): (0.04, 0.06, 0.10, 0.17, 0.34, 0.84),
    ("stable", 5): (0.02, 0.02, 0.04, 0.06, 0.11, 0.26),
    ("fast", 15): (0.02, 0.04, 0.11, 0.18, 0.27, 0.60),
    ("default", 15): (0.01, 0.01, 0.02, 0.04, 0.08, 0.22),
    ("stable", 15): (0.00, 0.00, 0.01, 0.01, 0.02, 0.06),
}
TARGET = 40.0  # times SOFA's default row
TARGET_STEPS = (0.001, 0.002, 0.005, 0.010)
OUTSIDE = "outside stepSimulation a segment and step"
OUTSIDE_TARGET = 2.5  # [us] a segment and step
DEEP = 0.002  # [m]


@dataclass
class Touches:
    """Contacts of the hand with object and table: points that touch in each step, and pairs that
    were first seen touching too deep.
    """

    points: list[int] = field(default_factory=list)
    begun: int = 0
    missed: int = 0
    _before: set[tuple[int, ...]] = field(default_factory=set)

    def look(self, simulation: Simulation) -> None:
        """Take in the contacts after a step."""
        hand = set(simulation.bodies.ids)
        now: dict[tuple[int, ...], float] = {}
        points = pybullet.getContactPoints(physicsClientId=simulation.engine.world.client)
        for point in points:
            if (point[1] in hand or point[2] in hand) and point[8] <= 0.0:
                pair = point[1:5]
                now[pair] = min(point[8], now.get(pair, 0.0))
        fresh = [depth for pair, depth in now.items() if pair not in self._before]
        self.begun += len(fresh)
        self.missed += sum(depth < -DEEP for depth in fresh)
        self._before = set(now)
        self.points.append(sum(point[8] <= 0.0 for point in points))


@dataclass(frozen=True)
class Run:
    """One grasp: times of its steps, contacts, outcome."""

    times: StepTimes
    touches: Touches
    result: GraspResult

    @property
    def diverged(self) -> bool:
        """Whether the simulation broke off."""
        return "diverged" in self.result.reason

    @property
    def outcome(self) -> str:
        """What became of the grasp."""
        return "diverged" if self.diverged else self.result.outcome


def grasp(settings: str, segments: int, step: float) -> Run:
    """The surface-constrained grasp of the thesis with RBO Hand 2."""
    touches = Touches()
    with timed_steps(touches.look) as times:
        trial = run_trial(0, TrialSettings(step=step, segments=segments, solver=settings))
    return Run(times, touches, trial.result)


def rows(small: bool) -> list[dict[str, Any]]:
    """All cells of the table."""
    run_trial(0, TrialSettings(step=0.01))  # compile
    found = []
    for (settings, segments), theirs in THESIS.items():
        if small and settings != "default":
            continue
        runs = [grasp(settings, segments, step) for step in STEPS]
        print(_lines(settings, segments, runs, theirs), flush=True)
        for step, run, other in zip(STEPS, runs, theirs, strict=True):
            found += _cell(settings, segments, step, run, other)
    return found


def _cell(
    settings: str, segments: int, step: float, run: Run, other: float
) -> list[dict[str, Any]]:
    name = f"RBO Hand 2, {ACTUATORS * segments} segments, {settings}, {1e3 * step:g} ms"
    if run.diverged:
        return [stated(f"{name}: diverged", True, "")]
    factor, touches = run.times.factor(step), run.touches
    found = [
        stated(f"{name}: real-time factor", factor, ""),
        stated(f"{name}: share of stepSimulation", 100 * run.times.share(), "%"),
        stated(f"{name}: contacts missed", touches.missed, f"of {touches.begun}"),
        stated(f"{name}: contact points that touch, most", max(touches.points), ""),
        stated(f"{name}: gripped", run.result.gripped, ""),
    ]
    if settings == "default" and step in TARGET_STEPS:
        outside = 1e6 * run.times.outside() / (ACTUATORS * segments)
        found.append(at_least(f"{name}: times the thesis", factor / other, "", TARGET))
        found.append(at_most(f"{name}: {OUTSIDE}", outside, "us", OUTSIDE_TARGET))
    return found


def page_table() -> str:
    """The table of the simulator's page in Markdown: here, SOFA (the thesis) and MuJoCo."""
    head = "".join(f" {1e3 * step:g} ms |" for step in STEPS)
    lines = [f"| actuators x segments | engine, settings |{head}", "|---" * (len(STEPS) + 2) + "|"]
    for segments in (5, 15):
        size = f"| {ACTUATORS} x {segments} |"
        for settings in ("fast", "default", "stable"):
            runs = [grasp(settings, segments, step) for step in STEPS]
            cells = [
                _held(run.times.factor(h), run.outcome) for run, h in zip(runs, STEPS, strict=True)
            ]
            lines.append(_line(f"{size} here, {settings} |", cells))
        for settings in ("fast", "default", "stable"):
            cells = [f"{value:.2f}" for value in THESIS[settings, segments]]
            lines.append(_line(f"{size} thesis: SOFA, {settings} |", cells))
        for engine in MUJOCO:
            found = [mujoco_grasp(engine, 0, step, segments) for step in STEPS]
            cells = [
                _held(run.times.factor(h), run.result.outcome)
                for run, h in zip(found, STEPS, strict=True)
            ]
            lines.append(_line(f"{size} {engine} |", cells))
    return "\n".join(lines)


def _line(head: str, cells: Sequence[str]) -> str:
    line = head + "".join(f" {cell} |" for cell in cells)
    print(line, file=sys.stderr, flush=True)
    return line


def _held(factor: float, outcome: str) -> str:
    if outcome == "diverged":
        return outcome
    return f"{factor:.2f}" if outcome == "gripped" else f"{factor:.2f} ({outcome})"


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, and print the table."""
    argparse.ArgumentParser(
        prog="bench.sim.thesis_table",
        description="Make Table 5.2 again (some minutes) and print it in Markdown.",
    ).parse_args(arguments)
    run_trial(0, TrialSettings(step=0.01))  # compile
    print(page_table())


def _lines(settings: str, segments: int, runs: Sequence[Run], theirs: Sequence[float]) -> str:
    """The rows of the thesis' table, ours and its own, and what became of the grasp."""
    head = f"{ACTUATORS * segments} segments, {settings}"
    cells = {
        "step [ms]": [f"{1e3 * step:g}" for step in STEPS],
        "ours": [
            "-" if run.diverged else f"{run.times.factor(step):.2f}"
            for step, run in zip(STEPS, runs, strict=True)
        ],
        "thesis": [f"{value:.2f}" for value in theirs],
        "missed": [f"{run.touches.missed}/{run.touches.begun}" for run in runs],
        "outcome": [run.outcome for run in runs],
    }
    return "\n".join(
        [head]
        + [f"  {key:10s}" + "".join(f"{cell:>10s}" for cell in row) for key, row in cells.items()]
    )


if __name__ == "__main__":
    main()
