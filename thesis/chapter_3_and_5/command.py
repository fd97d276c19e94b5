"""The command `pneuflex-validate`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from thesis.chapter_3_and_5 import (
    approximation,
    base_torque,
    blocked_force,
    discretisation,
    disturbance,
    payload,
    straight_finger,
    wall_strain,
    wall_thickness,
)
from thesis.chapter_3_and_5.experiment import (
    FIGURE,
    RESULTS,
    EarlierRunError,
    Experiment,
    read_results,
    write_figure,
    write_report,
    write_results,
)

OUT = Path("out/validation")
EXPERIMENTS: dict[str, Experiment] = {
    module.EXPERIMENT.name: module.EXPERIMENT
    for module in (
        discretisation,
        wall_thickness,
        blocked_force,
        base_torque,
        straight_finger,
        wall_strain,
        approximation,
        payload,
        disturbance,
    )
}


def parser() -> argparse.ArgumentParser:
    """The command line."""
    found = argparse.ArgumentParser(
        prog="pneuflex-validate",
        description="Make an experiment of the thesis again: results.json (SI units, angles in "
        "rad), verdict.txt and figure.png go to a folder; the table of what came out (units in it) "
        "and the verdict are printed.",
        epilog="Exit status: 0 when every target is met, 1 when one is missed, 2 for a wrong call.",
    )
    found.add_argument("name", help=f"list, all, or one of {', '.join(EXPERIMENTS)}")
    found.add_argument("--out", type=Path, help=f"folder of one experiment (default: {OUT}/NAME)")
    found.add_argument("--force", action="store_true", help="overwrite an earlier run")
    found.add_argument(
        "--redraw", action="store_true", help="judge and draw the results of an earlier run"
    )
    found.add_argument("--figure", type=Path, help="draw another copy of the figure here (PNG)")
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """List experiments, or make one or all of them."""
    options = parser().parse_args(arguments)
    if options.name == "list":
        print("\n".join(f"{one.name:16} {one.title}" for one in EXPERIMENTS.values()))
        return 0
    if options.name == "all" and (options.out or options.figure):
        return _refuse("all: expected no --out and no --figure, which are for one experiment")
    if options.name != "all" and options.name not in EXPERIMENTS:
        return _refuse(
            f"experiment: expected list, all or one of {', '.join(EXPERIMENTS)}, got {options.name}"
        )
    names = list(EXPERIMENTS) if options.name == "all" else [options.name]
    try:
        return max([_make(EXPERIMENTS[name], options) for name in names])
    except EarlierRunError as error:
        return _refuse(str(error))


def _make(experiment: Experiment, options: argparse.Namespace) -> int:
    """Make one experiment; 1 if a target is missed."""
    folder = options.out or OUT / experiment.name
    if options.redraw:
        results = read_results(experiment, folder)
    else:
        if (folder / RESULTS).exists() and not options.force:
            raise EarlierRunError(f"{folder}: expected no run, got one; --force overwrites it")
        print(f"{experiment.name}: {experiment.title} ...", file=sys.stderr, flush=True)
        results = experiment.simulate()
        write_results(experiment, results, folder)
    print(write_report(experiment, results, folder))
    for path in [folder / FIGURE, *([options.figure] if options.figure else [])]:
        write_figure(experiment, results, path)
    print(f"{experiment.name}: written to {folder}", file=sys.stderr)
    return int(any(finding.met is False for finding in experiment.report(results)))


def _refuse(words: str) -> int:
    print(f"pneuflex-validate: {words}", file=sys.stderr)
    return 2
