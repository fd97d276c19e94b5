"""Writing of results: nothing is overwritten unless it is asked for."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np


def write_new(path: Path, text: str, force: bool = False) -> None:
    """Write a text file whole or not at all, with the folders above it.

    Raises ValueError when it exists (unless `force`) or cannot be written.
    """
    check_new(path, force)
    beside = path.with_name(path.name + ".part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        beside.write_text(text, encoding="utf-8")
        beside.replace(path)
    except OSError as reason:
        raise ValueError(f"{path}: expected a place to write to, got {reason.strerror}") from reason


def write_json(path: Path, content: dict[str, Any], force: bool = False) -> None:
    """Write a JSON file; numbers that are not finite become null, which JSON has for them."""
    text = json.dumps(plain(content), indent=1, allow_nan=False)
    write_new(path, text + "\n", force)


def plain(value: Any) -> Any:
    """The same with numpy's arrays and numbers as Python's, and None for what is not finite.

    >>> plain({"a": np.array([1.0, np.nan])})
    {'a': [1.0, None]}
    """
    if isinstance(value, dict):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
