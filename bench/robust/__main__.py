"""Run the benchmark of robustness, print its table, write out/bench/bench-robust.json.

Every module of this folder with a function `run(...) -> list[dict]` is a group of rows; those of
its arguments that are named as an option (`minutes`, `seed`) get it. Exit status 1 if a group could
not be run; a target that is missed shows in the table only.
"""

from __future__ import annotations

import argparse
import importlib
import inspect
import json
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bench.__main__ import table

OUT = Path("out/bench/bench-robust.json")
MINUTES = 5.0  # of the long rows, unless told otherwise


def groups() -> list[str]:
    """Names of the modules that measure something, told without importing them."""
    files = sorted(Path(__file__).parent.glob("*.py"))
    return [file.stem for file in files if "\ndef run(" in file.read_text()]


def measure(name: str, options: dict[str, Any]) -> list[dict[str, Any]]:
    """Rows of one group, with those of the options that it takes."""
    run = importlib.import_module(f"bench.robust.{name}").run
    taken = inspect.signature(run).parameters
    rows: list[dict[str, Any]] = run(**{k: v for k, v in options.items() if k in taken})
    return rows


def write(rows: Sequence[dict[str, Any]]) -> None:
    """Write what has been measured so far."""
    OUT.parent.mkdir(parents=True, exist_ok=True)
    OUT.write_text(json.dumps(rows, indent=2) + "\n")


def options(arguments: Sequence[str] | None) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="bench.robust", description="Attack the nodes and see what holds."
    )
    add = parser.add_argument
    add("--rows", nargs="+", default=groups(), choices=groups(), help="default: all")
    add("--minutes", type=float, default=MINUTES, help=f"of the long rows (default: {MINUTES:g})")
    add("--seed", type=int, default=0, help="of what is drawn (default: 0)")
    return parser.parse_args(arguments)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print, write."""
    parsed = options(arguments)
    print(f"bench: seed {parsed.seed}", flush=True)
    given = {"minutes": parsed.minutes, "seed": parsed.seed}
    rows, failed = [], []
    for name in parsed.rows:
        print(f"bench: {name} ...", flush=True)
        try:
            rows += measure(name, given)
            write(rows)
        except Exception:  # noqa: BLE001 (one broken group must not hide the others)
            traceback.print_exc()
            failed.append(name)
    write(rows)
    print(table(rows))
    print(f"bench: written to {OUT}")
    for name in failed:
        print(f"bench: {name} could not be run", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
