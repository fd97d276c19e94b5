"""Where finished sets are kept, so that the benchmark can be stopped and taken up again."""

from __future__ import annotations

import json
import secrets
from pathlib import Path
from typing import Any

from bench.kept import revision_of

OUT = Path("out/bench")
LINES = OUT / "bench-lab.jsonl"
UNDER_WAY = OUT / "bench-lab-run.json"
SOURCES = (
    "src/softhand_model/softhand_model",
    "src/model_lab/model_lab",
    "bench/hidden",
)
DEVELOPMENT = 0
LARGEST = 10**6
SPAN = 2**31  # beyond all seeds of the generator that belong to one seed of a run


def revision_of_the_code() -> str:
    """A short digest of everything whose change makes old results stale."""
    return revision_of(SOURCES)


def key_of(case: str, seed: int, noise: float, revision: str) -> str:
    """Name of one set under one revision of the code."""
    return f"{case}|{seed}|{noise:g}|{revision}"


def first_seed(run: int) -> int:
    """The seed of the first set of each case in a run; runs have no seeds in common.

    >>> first_seed(DEVELOPMENT)
    0
    """
    return run * SPAN


def seed_of_run(chosen: dict[str, Any], path: Path = UNDER_WAY) -> int:
    """The seed of a run that was stopped, if the same was `chosen` (with the revision of the code);
    else a new one, which is kept until `finish`.
    """
    if path.is_file():
        known = json.loads(path.read_text())
        if known["chosen"] == chosen:
            return int(known["seed"])
    seed = 1 + secrets.randbelow(LARGEST)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps({"seed": seed, "chosen": chosen}) + "\n")
    return seed


def finish(path: Path = UNDER_WAY) -> None:
    """The next run draws new seeds."""
    path.unlink(missing_ok=True)
