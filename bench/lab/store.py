"""Where finished sets are kept, so that the benchmark can be stopped and taken up again."""

from __future__ import annotations

from pathlib import Path

from bench.kept import revision_of

OUT = Path("out/bench")
LINES = OUT / "bench-lab.jsonl"
SOURCES = (
    "src/softhand_model/softhand_model",
    "src/model_lab/model_lab",
    "bench/hidden",
)


def revision_of_the_code() -> str:
    """A short digest of everything whose change makes old results stale."""
    return revision_of(SOURCES)


def key_of(case: str, seed: int, noise: float, revision: str) -> str:
    """Name of one set under one revision of the code."""
    return f"{case}|{seed}|{noise:g}|{revision}"
