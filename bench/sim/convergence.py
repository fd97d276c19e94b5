"""What step, segments and iterations do to motion and grasp, as two tables.

python -m bench.sim.convergence --help
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from dataclasses import replace

from bench.simulator import response_time
from grasp_strategies.judging.judge import GraspResult
from pneuflex_sim.world import SOLVER_SETTINGS
from softhand_trials.trials import TrialSettings, run_trial

STEPS, SEGMENTS = (0.001, 0.002, 0.005, 0.010), (5, 10, 15)
SEEDS = (0, 1, 2)
USUAL = TrialSettings(step=0.005)


def grasps(settings: TrialSettings) -> str:
    """Outcome of the surface-constrained grasp for some seeds: successes, worst slip, lift."""
    results = [run_trial(seed, settings).result for seed in SEEDS]
    slips = [_slip(result) for result in results]
    lifts = [1e3 * result.lift_height for result in results]
    gripped = sum(result.gripped for result in results)
    return f"{gripped} of {len(SEEDS)} | {max(slips):.2f} | {sum(lifts) / len(lifts):.1f}"


def _slip(result: GraspResult) -> float:
    return math.inf if math.isnan(result.slip) else 1e3 * result.slip


def by_step() -> list[str]:
    """Rows over step and segments."""
    rows = []
    for segments in SEGMENTS:
        for step in STEPS:
            settings = replace(USUAL, step=step, segments=segments)
            quick = f"{response_time(segments, step):.0f}"
            rows.append(f"| {segments} | {1e3 * step:g} | {quick} | {grasps(settings)} |")
            print(rows[-1], file=sys.stderr, flush=True)
    return rows


def by_settings() -> list[str]:
    """Rows over the settings of the solver, at steps of 2 and 5 ms."""
    rows = []
    for name, solver in SOLVER_SETTINGS.items():
        for step in STEPS[1:3]:
            found = grasps(replace(USUAL, step=step, solver=name))
            numbers = f"{solver.iterations} | {solver.residual:g}"
            rows.append(f"| `{name}` | {numbers} | {1e3 * step:g} | {found} |")
            print(rows[-1], file=sys.stderr, flush=True)
    return rows


def text(steps: Sequence[str], settings: Sequence[str]) -> str:
    """Both tables in Markdown."""
    outcome = "gripped | slip, worst [mm] | lift, mean [mm]"
    return "\n".join(
        [
            f"| segments | step [ms] | time to 90 % [ms] | {outcome} |",
            "|---|---|---|---|---|---|",
            *steps,
            "",
            f"| solver | iterations | residual | step [ms] | {outcome} |",
            "|---|---|---|---|---|---|---|",
            *settings,
        ]
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, and print the tables."""
    argparse.ArgumentParser(
        prog="bench.sim.convergence",
        description="Measure what step, segments and iterations do to motion and grasp (some "
        "minutes), and print it as tables in Markdown.",
    ).parse_args(arguments)
    run_trial(0, TrialSettings(step=0.01))  # compile
    print(text(by_step(), by_settings()))


if __name__ == "__main__":
    main()
