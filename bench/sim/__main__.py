"""Run the benchmark of the simulator, print its table and write out/bench/bench-sim.json.

All groups run in this process or in children of it, one at a time. Times are CPU times of one
thread; figures of engines that are compared are ratios of runs in turn. Exit status 1 if a group
could not be run; a target that is missed shows in the table only.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import sys
import time
import traceback
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import bench.sim
from bench.__main__ import table

OUT = Path("out/bench")


def groups() -> list[str]:
    """Names of the modules that have rows, told without importing them."""
    files = sorted(Path(bench.sim.__file__).parent.glob("*.py"))
    return [file.stem for file in files if "\ndef rows(" in file.read_text()]


def options(arguments: list[str] | None) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(prog="bench.sim", description="Measure the simulator.")
    add = parser.add_argument
    add(
        "--rows",
        nargs="+",
        default=groups(),
        choices=groups(),
        metavar="GROUP",
        help="of %(choices)s; default: all",
    )
    add("--small", action="store_true", help="few runs of each, to try it out")
    return parser.parse_args(arguments)


def main(arguments: list[str] | None = None) -> int:
    """Measure, print, write."""
    chose = options(arguments)
    rows: list[dict[str, Any]] = []
    seconds, failed = {}, []
    for name in chose.rows:
        print(f"bench.sim: {name} ...", file=sys.stderr, flush=True)
        begin = time.perf_counter()
        try:
            rows += importlib.import_module(f"bench.sim.{name}").rows(chose.small)
        except Exception:  # noqa: BLE001 (one broken group must not hide the others)
            traceback.print_exc()
            failed.append(name)
        seconds[name] = time.perf_counter() - begin
    print(table(rows))
    stamp = datetime.now(UTC).isoformat(timespec="seconds")
    measured = [row | {"measured": stamp} for row in rows]
    _write({"small": chose.small, "load": os.getloadavg()[0], "seconds": seconds, "rows": measured})
    for name in failed:
        print(f"bench.sim: {name} could not be run", file=sys.stderr)
    return 1 if failed else 0


def _write(document: dict[str, Any]) -> None:
    """Write the file, and keep the rows of earlier runs that this one did not measure again; each
    row says when it was measured.
    """
    path = OUT / "bench-sim.json"
    OUT.mkdir(parents=True, exist_ok=True)
    if path.exists():
        measured = {row["name"] for row in document["rows"]}
        before = json.loads(path.read_text())
        if before["small"] == document["small"]:
            document["rows"] += [row for row in before["rows"] if row["name"] not in measured]
            document["seconds"] = before["seconds"] | document["seconds"]
    path.write_text(json.dumps(document, indent=2) + "\n")
    print(f"bench.sim: written to {path}", file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
