"""Gather verdicts on sets of the second author: `python -m bench.lab.gather_others`.

As `bench.lab.gather`, into the same lines: sets with a hidden effect, with slips and with faults in
their series, kinds in turn. Even seeds are for the fit, odd ones to show it.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from bench.kept import append, read
from bench.lab.adapter import diagnosis_of
from bench.lab.gather import LINES
from bench.lab.scoring import SECOND_AUTHOR
from bench.lab.store import revision_of_the_code
from bench.second_author.__main__ import MAKERS
from bench.second_author.score import score

FIRST_SEED = 3000
TURN = ("forms", "forms", "slips", "forms", "series")  # kinds in turn


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
    for number in range(chose.sets):
        kind, seed = TURN[number % len(TURN)], FIRST_SEED + number
        if time.monotonic() > until:
            print("bench.lab.gather_others: time is over; run it again to go on", flush=True)
            break
        if f"{SECOND_AUTHOR}/{kind}|{seed}" not in known:
            append(record_of(kind, seed, revision), chose.lines)
    return 0


if __name__ == "__main__":
    sys.exit(main())
