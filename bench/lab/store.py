"""Finished sets, one JSON line each, so that a benchmark can be stopped and taken up again."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
OUT = Path("out/bench")
LINES = OUT / "bench-lab.jsonl"
SOURCES = (
    "src/softhand_model/softhand_model",
    "src/model_lab/model_lab",
    "bench/hidden",
)


def revision_of_the_code() -> str:
    """A short digest of everything whose change makes old results stale."""
    digest = hashlib.sha256()
    for source in SOURCES:
        for file in sorted((ROOT / source).rglob("*.py")):
            digest.update(file.read_bytes())
    return digest.hexdigest()[:12]


def key_of(case: str, seed: int, noise: float, revision: str) -> str:
    """Name of one set under one revision of the code."""
    return f"{case}|{seed}|{noise:g}|{revision}"


def read(path: Path = LINES) -> dict[str, dict[str, Any]]:
    """Finished sets by key; a line that was cut off while writing is left out."""
    found = {}
    for line in path.read_text().splitlines() if path.is_file() else []:
        try:
            record = json.loads(line)
        except json.JSONDecodeError:
            continue
        found[record["key"]] = record
    return found


def append(record: dict[str, Any], path: Path = LINES) -> None:
    """Keep one finished set."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a") as file:
        file.write(json.dumps(record) + "\n")
