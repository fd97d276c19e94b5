"""The command `softhand-search`: runs or continues a search, and prints its best evaluation."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from softhand_trials.search.objective import ALLOW, COST, find_objective
from softhand_trials.search.problem import load_problem
from softhand_trials.search.run import SearchResult, run_search


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="softhand-search",
        description="Searches the values of a problem's variables with the least cost, by the "
        "budget that stands in the file. Each evaluation is a line of results.jsonl as soon as it "
        "is done. Start it again to go on.",
    )
    add = parser.add_argument
    add("problem", type=Path, help="YAML file of the format softhand-search/1")
    add("--out", type=Path, help="folder of the results (out/searches/NAME)")
    add("--jobs", type=int, default=2, help="processes at a time; 0: in this one (%(default)s)")
    add("--scheduler", help="address of a Dask scheduler instead, such as tls://node:8786")
    add(ALLOW, action="store_true", help="run the objective that the file names, of any module")
    return parser


def _run(options: argparse.Namespace) -> int:
    if options.jobs < 0:
        raise ValueError(f"jobs: expected 0 or more, got {options.jobs}")
    problem = load_problem(options.problem, options.allow_objectives)
    find_objective(problem.objective, problem.allow_any)  # said now, not once an evaluation
    folder = options.out or Path("out/searches") / problem.name
    print(summary(run_search(problem, folder, options.jobs, options.scheduler)))
    return 0


def summary(result: SearchResult) -> str:
    """The number of evaluations, and the best one."""
    best = result.best
    values = "\n".join(f"  {name:<16}{value:.6g}" for name, value in best["values"].items())
    failed = f", {result.failed} of them failed" if result.failed else ""
    return f"{len(result.records)} evaluations{failed}\n{best['key']}: cost {best[COST]:.6g}\n" + (
        values
    )


def main(arguments: list[str] | None = None) -> int:
    """Run a search from the command line; returns 0, or 2 when it cannot be run."""
    options = _parser().parse_args(arguments)
    try:
        return _run(options)
    except (ValueError, OSError) as error:
        print(f"softhand-search: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("softhand-search: stopped; start it again to go on", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
