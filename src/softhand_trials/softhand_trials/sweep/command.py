"""The command `softhand-sweep`: runs or continues a plan, and summarises or reports its results."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from pneuflex_sim.bullet import NotInstalled
from pneuflex_sim.engines import check_engines
from softhand_trials.agreement import add_engines
from softhand_trials.sweep.plan import load_plan
from softhand_trials.sweep.report import summary
from softhand_trials.sweep.report_files import write_report
from softhand_trials.sweep.run import run_sweep

REPORT_WORD = "report"  # in place of a plan


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="softhand-sweep",
        description="Runs the trials of a plan that are not done yet; each is a line of "
        "results.jsonl as soon as it is done. Start it again to go on. "
        f"`softhand-sweep {REPORT_WORD} FOLDER` writes tables, pictures and JSON of what is done.",
    )
    add = parser.add_argument
    add("plan", type=Path, help="YAML file of the format softhand-sweep/1")
    add("--out", type=Path, help="folder of the results (out/sweeps/NAME)")
    add("--jobs", type=int, default=2, help="processes at a time; 0: in this one (%(default)s)")
    add("--scheduler", help="address of a Dask scheduler instead, such as tls://node:8786")
    add("--dry", action="store_true", help="list the keys of all trials, and end")
    add_engines(parser)
    return parser


def _run(options: argparse.Namespace) -> int:
    if options.jobs < 0:
        raise ValueError(f"jobs: expected 0 or more, got {options.jobs}")
    plan = load_plan(options.plan)
    if options.engines:
        check_engines(options.engines)
        plan = plan.in_engines(options.engines)
    if options.dry:
        print("\n".join(task.key for task in plan.tasks()))
        return 0
    folder = options.out or Path("out/sweeps") / plan.name
    records = run_sweep(plan, folder, options.jobs, options.scheduler)
    print(summary(records))
    return 0


def _report_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=f"softhand-sweep {REPORT_WORD}",
        description="Writes the report of a sweep: report.md, report.json, shares.png and, where "
        "the cells are a grid, maps.png.",
    )
    parser.add_argument("folder", type=Path, help="folder of the results, finished or not")
    parser.add_argument("--out", type=Path, help="folder of the report (that of the results)")
    parser.add_argument("--force", action="store_true", help="overwrite a report that is there")
    return parser


def _report(options: argparse.Namespace) -> int:
    files = write_report(options.folder, options.out, options.force)
    print("\n".join(map(str, files)))
    return 0


def main(arguments: list[str] | None = None) -> int:
    """Run or report a sweep from the command line; returns 0, or 2 when plan or results cannot be
    used.
    """
    words = sys.argv[1:] if arguments is None else arguments
    reports = words[:1] == [REPORT_WORD]
    options = _report_parser().parse_args(words[1:]) if reports else _parser().parse_args(words)
    try:
        return _report(options) if reports else _run(options)
    except (ValueError, OSError, NotInstalled) as error:
        print(f"softhand-sweep: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("softhand-sweep: stopped; start it again to go on", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
