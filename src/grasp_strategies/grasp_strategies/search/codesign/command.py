"""The command `softhand codesign`: runs a plan of hand and motion, and says what came out."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from grasp_strategies.search.codesign.plan import SHIPPED_PLAN, load_plan
from grasp_strategies.search.codesign.run import interval, run_plan, verdict
from grasp_strategies.sweep.run import workers

FOLDER = Path("out/codesign")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="softhand codesign",
        description="Searches a hand and its motion together and apart, with equal budgets of "
        "trials, and holds the best of each arm out. Start it again to go on.",
    )
    add = parser.add_argument
    add("plan", nargs="?", type=Path, default=SHIPPED_PLAN, help="YAML file (%(default)s)")
    add("--small", action="store_true", help="the plan's small form: that it runs, no result")
    add("--noise", action="store_true", help="negative control: successes drawn at random")
    add("--out", type=Path, help=f"folder of the results ({FOLDER}/NAME)")
    add("--jobs", type=int, default=2, help="processes at a time; 0: in this one (%(default)s)")
    add("--scheduler", help="address of a Dask scheduler instead, such as tcp://node:8786")
    return parser


def _run(options: argparse.Namespace) -> int:
    if options.jobs < 0:
        raise ValueError(f"jobs: expected 0 or more, got {options.jobs}")
    plan = load_plan(options.plan, options.small)
    plan = plan.with_noise() if options.noise else plan
    with workers(options.jobs, options.scheduler) as crew:
        found = run_plan(crew, plan, options.out or FOLDER / plan.name)
    print(summary(found))
    return 0


def summary(found: Mapping[str, Any]) -> str:
    """A line an arm, the shipped pair, and the verdict."""
    winners = found["winners"]
    lines = [
        f"{'arm':<10}{'training':>10}{'held out':>10}{'95 %':>14}{'trials':>9}{'infeasible':>12}"
    ]
    for arm in dict.fromkeys(winner["arm"] for winner in winners):
        of_arm = [winner for winner in winners if winner["arm"] == arm]
        training, held_out = ([one[key] for one in of_arm] for key in ("training", "held_out"))
        low, high = np.clip(interval(held_out), 0.0, 1.0)
        trials, infeasible = (sum(one[key] for one in of_arm) for key in ("trials", "infeasible"))
        lines.append(
            f"{arm:<10}{np.mean(training):>10.3f}{np.mean(held_out):>10.3f}"
            f"{f'{low:.2f} to {high:.2f}':>14}{trials:>9}{infeasible:>12}"
        )
    rate = found["trials_per_core_hour"]
    lines += [
        f"{'shipped':<10}{'':>10}{found['shipped']:>10.3f}",
        f"{rate:,.0f} trials a core-hour",
    ]
    return "\n".join([*lines, verdict(found["gain"])])


def main(arguments: list[str] | None = None) -> int:
    """Run a plan from the command line; returns 0, or 2 when it cannot be run."""
    options = _parser().parse_args(arguments)
    try:
        return _run(options)
    except (ValueError, OSError) as error:
        print(f"softhand codesign: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("softhand codesign: stopped; start it again to go on", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
