"""Gather verdicts on sets by others than `bench.hidden`: `python -m bench.lab.gather_others`.

As `bench.lab.gather`, into the same lines. The second author's sets with a hidden effect, with
slips and with faults in their series come in turn, each kind with seeds that follow one another.
`--real`: measurements and parts of them (`bench.lab.real`), numbered by set. What is right there,
by SOURCES.md of the measurements and the contract of the lab: of rubber and silicone a law of
rubber for each named effect, or `unexplained` where such a law helps most; of an actuator of
another make that snaps, `unexplained`.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from bench.kept import append, read
from bench.lab.adapter import diagnosis_of
from bench.lab.gather import LINES
from bench.lab.real import model_of, pieces, sets
from bench.lab.scoring import REAL, SECOND_AUTHOR, groups
from bench.lab.store import revision_of_the_code
from bench.second_author.__main__ import MAKERS
from bench.second_author.score import score
from model_lab.diagnosis.diagnose import diagnose

FIRST_SEED = 30000  # beyond all that a rule was tried or a figure was told on
TURN = ("forms", "slips", "forms", "slips", "series")  # kinds in turn
FURTHER_LAWS = {"yeoh_third_order", "arruda_boyce", "ogden", "mooney_rivlin", "second_invariant"}
RUBBER_LAWS = {"gent_stiffening", "yeoh_stiffening"} | FURTHER_LAWS


def sets_of(count: int, first_seed: int = FIRST_SEED) -> list[tuple[str, int]]:
    """Kind and seed of so many sets.

    >>> sets_of(3)
    [('forms', 30000), ('slips', 30000), ('forms', 30001)]
    """
    made = Counter[str]()
    sets = []
    for number in range(count):
        kind = TURN[number % len(TURN)]
        sets.append((kind, first_seed + made[kind]))
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
    answer = _kept(said)
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


def _kept(said: dict[str, Any]) -> dict[str, Any]:
    answer = {name: said[name] for name in ("effects", "tied", "guess", "confidence", "evidence")}
    answer["verdict"] = said.get("verdict_mended") or said["verdict"]
    return answer | {name: len(said.get(name, ())) for name in ("slips", "events")}


def records_of_measurements(revision: str) -> Iterator[dict[str, Any]]:
    """The same of measurements and parts of them."""
    for number, (name, data) in enumerate(sets().items()):
        for part, piece in [("whole", data), *pieces(data)]:
            said = diagnose(piece, model_of(piece)[1]).diagnosis.as_json()
            yield {
                "key": f"{REAL}|{name}: {part}",
                "row": REAL,
                "experiment": said["experiment"],
                "seed": number,
                "revision": revision,
                "right": right_of_measurements(name, said),
                "answer": _kept(said),
            }


def right_of_measurements(name: str, said: dict[str, Any]) -> bool:
    """Whether a diagnosis of a measured set says what is known of it; none of them has a slip."""
    if said["slips"]:
        return False
    if not name.startswith(("rubber", "silicone")):
        return bool(said["verdict"] == "unexplained")
    if said["verdict"] == "unexplained":
        helps = said["helps"]
        return bool(helps) and helps[0]["name"] in RUBBER_LAWS
    return bool(said["effects"]) and all(group & RUBBER_LAWS for group in groups(said))


def main(arguments: list[str] | None = None) -> int:
    """Gather for some minutes."""
    parser = argparse.ArgumentParser(
        prog="bench.lab.gather_others", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--sets", type=int, default=300, help="so many in all")
    parser.add_argument("--seed", type=int, default=FIRST_SEED, help="of the first set of a kind")
    parser.add_argument("--real", action="store_true", help="measurements instead")
    parser.add_argument("--lines", type=Path, default=LINES)
    chose = parser.parse_args(arguments)
    until = time.monotonic() + 60 * chose.minutes
    revision = revision_of_the_code()
    if chose.real:
        for record in records_of_measurements(revision):
            append(record, chose.lines)
        return 0
    known = {key for key, one in read(chose.lines).items() if one["revision"] == revision}
    for kind, seed in sets_of(chose.sets, chose.seed):
        if time.monotonic() > until:
            print("bench.lab.gather_others: time is over; run it again to go on", flush=True)
            break
        if f"{SECOND_AUTHOR}/{kind}|{seed}" not in known:
            append(record_of(kind, seed, revision), chose.lines)
    return 0


if __name__ == "__main__":
    sys.exit(main())
