"""Gather verdicts with what they rest on, for `bench.lab.calibrate`: `python -m bench.lab.gather`.

Sets of development seeds that no threshold has seen; a run that is stopped goes on. Every set is
one line in out/bench/calibration.jsonl, done again where the code has changed since.
"""

from __future__ import annotations

import argparse
import random
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from bench.hidden.case import Case
from bench.hidden.cases import all_cases
from bench.hidden.reserved import is_reserved
from bench.kept import append, read
from bench.lab.store import OUT, revision_of_the_code
from bench.lab.work import Job, finished

LINES = OUT / "calibration.jsonl"
FIRST_SEED, ROUNDS = 640, 20
LEFT_OUT = ("plan",)  # rows that are no single verdict


def jobs(revision: str, experiments: Sequence[str] = ()) -> list[Job]:
    """Every case once a round in a random order, one noise level each, with two seeds in turn."""
    cases = [
        case
        for case in all_cases()
        if case.row not in LEFT_OUT
        and (not experiments or case.experiment in experiments)
        and not is_reserved(case.name)
    ]
    made = []
    for turn in range(ROUNDS):
        for case in sorted(cases, key=lambda case: random.Random(f"{turn} {case.name}").random()):
            chance = random.Random(case.name)
            seed = FIRST_SEED + 2 * (turn // 2) + (turn + chance.randrange(2)) % 2
            made.append(Job(case.name, seed, _noise(case, turn, chance), revision))
    return made


def _noise(case: Case, turn: int, chance: random.Random) -> float:
    return case.noises[(turn + chance.randrange(len(case.noises))) % len(case.noises)]


def name_of(job: Job) -> str:
    """What a set is known by, whatever the revision."""
    return f"{job.case}|{job.seed}|{job.noise:g}"


def main(arguments: list[str] | None = None) -> int:
    """Gather for some minutes."""
    parser = argparse.ArgumentParser(prog="bench.lab.gather", description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=480.0)
    parser.add_argument("--sets", type=int, default=1200, help="so many in all")
    parser.add_argument("--experiments", nargs="+", default=[], help="default: all")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--lines", type=Path, default=LINES)
    chose = parser.parse_args(arguments)
    until = time.monotonic() + 60 * chose.minutes
    revision = revision_of_the_code()
    known = {key for key, one in read(chose.lines).items() if one["revision"] == revision}
    asked = jobs(revision, chose.experiments)[: chose.sets]
    names = {job.key: name_of(job) for job in asked if name_of(job) not in known}
    print(f"bench.lab.gather: {len(names)} of {len(asked)} sets to do", flush=True)
    left = [job for job in asked if job.key in names]
    for record in finished(left, chose.workers, until):
        append(record | {"key": names.pop(record["key"])}, chose.lines)
    if names:
        print("bench.lab.gather: time is over; run it again to go on", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
