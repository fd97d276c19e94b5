"""Gather verdicts on sets of the second author: `python -m bench.lab.gather_others`.

As `bench.lab.gather`, into the same lines: sets with a hidden effect, with slips and with faults in
their series, kinds in turn, each with seeds that follow one another, as slips and faults come in
turn. Even seeds are for the fit, odd ones to show it.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

from bench.kept import append, read
from bench.lab.adapter import diagnosis_of
from bench.lab.gather import LINES
from bench.lab.scoring import SECOND_AUTHOR
from bench.lab.store import revision_of_the_code
from bench.second_author.__main__ import MAKERS
from bench.second_author.score import score

FIRST_SEED = 30000  # beyond all that a rule was tried or a figure was told on
TURN = ("forms", "slips", "forms", "slips", "series")  # kinds in turn


def sets_of(count: int) -> list[tuple[str, int]]:
    """Kind and seed of so many sets.

    >>> sets_of(3)
    [('forms', 30000), ('slips', 30000), ('forms', 30001)]
    """
    made = Counter[str]()
    sets = []
    for number in range(count):
        kind = TURN[number % len(TURN)]
        sets.append((kind, FIRST_SEED + made[kind]))
        made[kind] += 1
    return sets


def record_of(kind: str, seed: int, revision: str) -> dict[str, Any]:
    """What `calibrate` needs of one set; no answer where the lab refused the files."""
    record: dict[str, Any] = {
        "key": f"{SECOND_AUTHOR}/{kind}|{seed}",
        "row": f"{SECOND_AUTHOR}, {kind}",
    }
    record |= {"experiment": "", "seed": seed, "revision": revision}
    with tempfile.TemporaryDirectory(prefix="bench-lab-") as folder:
        truth = MAKERS[kind](seed, Path(folder))
        try:
            said = diagnosis_of(Path(folder), 0)
        except ValueError as reason:
            return record | {"error": str(reason)}
    answer = {name: said[name] for name in ("effects", "tied", "guess", "confidence", "evidence")}
    answer["verdict"] = said.get("verdict_mended") or said["verdict"]
    answer |= {name: len(said.get(name, ())) for name in ("slips", "events")}
    found = score(truth, said)
    about = {"label": truth.label, "said": found.said, "outcome": found.outcome}
    return (
        record
        | about
        | {
            "experiment": said["experiment"],
            "right": found.outcome == "right",
            "answer": answer,
        }
    )


def main(arguments: list[str] | None = None) -> int:
    """Gather for some minutes."""
    parser = argparse.ArgumentParser(
        prog="bench.lab.gather_others", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--sets", type=int, default=300, help="so many in all")
    parser.add_argument("--lines", type=Path, default=LINES)
    chose = parser.parse_args(arguments)
    until = time.monotonic() + 60 * chose.minutes
    revision = revision_of_the_code()
    known = {key for key, one in read(chose.lines).items() if one["revision"] == revision}
    for kind, seed in sets_of(chose.sets):
        if time.monotonic() > until:
            print("bench.lab.gather_others: time is over; run it again to go on", flush=True)
            break
        if f"{SECOND_AUTHOR}/{kind}|{seed}" not in known:
            append(record_of(kind, seed, revision), chose.lines)
    return 0


if __name__ == "__main__":
    sys.exit(main())
