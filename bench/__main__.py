"""Run the benchmarks, print a table and write out/bench/bench.json.

Every module of this folder with a function `run() -> list[dict]` takes part; the rows have the keys
name, value, unit, target and met (see `row.py`). Exit status 1 if a benchmark failed to run; a
target that is missed shows in the table only, since it says as much about the machine.
"""

from __future__ import annotations

import argparse
import importlib
import json
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bench

OUT = Path("out/bench")
KEYS = {"name", "value", "unit", "target", "met"}


def modules() -> list[str]:
    """Names of the modules that measure something, told without importing them."""
    files = sorted(Path(bench.__file__).parent.glob("*.py"))
    return [file.stem for file in files if "\ndef run(" in file.read_text()]


def measure(name: str) -> list[dict[str, Any]]:
    """Rows of one module.

    Raises:
        ValueError: a row lacks a key.
    """
    rows = importlib.import_module(f"bench.{name}").run()
    for row in rows:
        if set(row) != KEYS:
            raise ValueError(f"bench.{name}: expected the keys {sorted(KEYS)}, got {sorted(row)}")
    return rows


def table(rows: Sequence[dict[str, Any]]) -> str:
    """Rows as text.

    >>> print(table([{"name": "x", "value": 1.5, "unit": "s", "target": "<= 2", "met": True}]))
    what  measured  target  met
    x     1.5 s     <= 2    yes
    """
    words = {True: "yes", False: "NO", None: "-"}
    lines = [["what", "measured", "target", "met"]]
    for row in rows:
        value = f"{row['value']:.4g} {row['unit']}".strip()
        lines.append([row["name"], value, str(row["target"] or "-"), words[row["met"]]])
    widths = [max(len(line[k]) for line in lines) for k in range(4)]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )


def main(arguments: list[str] | None = None) -> int:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(prog="bench", description="Measure the suite.")
    parser.add_argument("modules", nargs="*", help=f"of {', '.join(modules())}; default: all")
    rows, failed = [], []
    for name in parser.parse_args(arguments).modules or modules():
        print(f"bench: {name} ...", flush=True)
        try:
            rows += measure(name)
        except Exception:  # noqa: BLE001 (one broken benchmark must not hide the others)
            traceback.print_exc()
            failed.append(name)
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / "bench.json").write_text(json.dumps(rows, indent=2) + "\n")
    print(table(rows))
    print(f"bench: written to {OUT / 'bench.json'}")
    for name in failed:
        print(f"bench: {name} could not be run", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
