"""Put small bugs in on purpose, one at a time, and count those that the tests see.

The bugs are cosmic-ray's mutants at places that lie evenly over the modules that decide
(`modules.py`); each module has the tests that should see them, its mirror before all. A mutant
is seen when one of these tests fails or does not end. Survivors are listed with what they would
mean, as far as `survivors.yaml` knows; out/bench/bench-mutants.json has them all.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

import yaml

from bench.__main__ import OUT, table
from bench.mutants.modules import MODULES, Row
from bench.mutants.places import Mutant, even_sample, source_file
from bench.mutants.trial import ROOT, load_libraries, passes
from bench.row import at_least, stated

MEANINGS = Path(__file__).with_name("survivors.yaml")
SAMPLE, SEED, TARGET = 420, 12, 88.0
SECONDS = 5  # of processor time that a mutant may take beside five times that of the tests
LONGEST = 600  # of the tests without a mutant


def options(arguments: list[str] | None) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(prog="bench.mutants", description=__doc__.splitlines()[0])
    add = parser.add_argument
    add(
        "--count",
        type=int,
        default=SAMPLE,
        metavar="N",
        help=f"mutants of all modules (default: {SAMPLE})",
    )
    add("--seed", type=int, default=SEED, help=f"of the sample (default: {SEED})")
    add(
        "--only",
        nargs="+",
        default=[""],
        metavar="WORD",
        help="of the sample, those in modules whose name holds a word",
    )
    return parser.parse_args(arguments)


def try_row(row: Row, mutants: list[Mutant], code: str) -> list[dict[str, Any]]:
    """Records of the mutants of one module.

    Raises:
        RuntimeError: its tests fail, or find nothing to do, without a mutant.
    """
    sound, used = passes(row, None, LONGEST)
    if not sound:
        raise RuntimeError(f"{row.module}: expected its tests to pass without a mutant")
    records = []
    for mutant in mutants:
        passed, _ = passes(row, mutant.source(code), SECONDS + int(5 * used))
        records.append(record_of(mutant, code, not passed))
        if passed:
            print(f"  {row.module}:{mutant.position[0]}: {records[-1]['change']}", flush=True)
    seen = sum(record["seen"] for record in records)
    print(f"{row.module}: {seen} of {len(records)} seen", flush=True)
    return records


def record_of(mutant: Mutant, code: str, seen: bool) -> dict[str, Any]:
    """What is written of a mutant; `meaning` as far as it is known for one that was not seen."""
    change = mutant.change(code)
    meanings = yaml.safe_load(MEANINGS.read_text("utf-8"))[mutant.module] or {}
    return {
        "module": mutant.module,
        "line": mutant.position[0],
        "operator": mutant.operator.removeprefix("core/"),
        "change": change,
        "seen": seen,
        "meaning": None if seen else meanings.get(change),
    }


def rows_of(records: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Share of seen mutants of all modules, and of each."""
    of_module = Counter(record["module"] for record in records)
    seen = Counter(record["module"] for record in records if record["seen"])
    shares = [stated(f"{name} ({n})", 100.0 * seen[name] / n, "%") for name, n in of_module.items()]
    whole = 100.0 * seen.total() / len(records)
    return [
        at_least(f"mutants seen ({seen.total()} of {len(records)})", whole, "%", TARGET),
        *shares,
    ]


def main(arguments: list[str] | None = None) -> int:
    """Sample, try, print and write."""
    chosen = options(arguments)
    code = {row.module: source_file(ROOT, row.module).read_text("utf-8") for row in MODULES}
    rows = [row for row in MODULES if any(word in row.module for word in chosen.only)]
    names = {row.module for row in rows}
    sample = [m for m in even_sample(code, chosen.count, chosen.seed) if m.module in names]
    print(
        f"mutants: {len(sample)} in {len(rows)} modules, seed {chosen.seed}; not seen:", flush=True
    )
    load_libraries()
    begin = time.monotonic()
    records = [
        record
        for row in rows
        for record in try_row(row, [m for m in sample if m.module == row.module], code[row.module])
    ]
    figures = [*rows_of(records), stated("time", (time.monotonic() - begin) / 60.0, "min")]
    OUT.mkdir(parents=True, exist_ok=True)
    written = {"seed": chosen.seed, "rows": figures, "mutants": records}
    (OUT / "bench-mutants.json").write_text(json.dumps(written, indent=2) + "\n")
    print(table(figures))
    return 0


if __name__ == "__main__":
    sys.exit(main())
