"""The sealed truth of a synthesised set: written once, read by `reveal` alone."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

SEAL = ".seal"


def seal(folder: Path, truth: dict[str, Any]) -> None:
    """Put the truth into the folder, encoded so that no glance at the file gives it away."""
    text = base64.b64encode(json.dumps(truth).encode()).decode()
    (folder / SEAL).write_text(text + "\n", encoding="ascii")


def open_seal(folder: Path) -> dict[str, Any]:
    """The truth of a synthesised set.

    Raises ValueError when there is no seal or it cannot be read.
    """
    path = folder / SEAL
    if not path.is_file():
        raise ValueError(f"{path}: expected the seal of a synthesised set, got no such file")
    try:
        truth = json.loads(base64.b64decode(path.read_text(encoding="ascii"), validate=False))
    except ValueError as reason:
        raise ValueError(f"{path}: expected an unbroken seal, got {reason}") from reason
    if not isinstance(truth, dict):
        raise ValueError(f"{path}: expected the truth of a synthesised set, got {truth!r}")
    return truth
