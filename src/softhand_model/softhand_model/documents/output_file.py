"""Writing of results: nothing is overwritten unless it is asked for."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

PICTURES = (".png", ".pdf", ".svg")  # what matplotlib writes without more libraries


def check_new(path: Path, force: bool, suffixes: tuple[str, ...] = ()) -> None:
    """Raise ValueError where a result cannot go: a folder, a file that exists (unless `force`), or
    another ending than one of `suffixes`, if there are any.

    To be asked before any work.
    """
    if suffixes and path.suffix.lower() not in suffixes:
        raise ValueError(
            f"{path}: expected a file that ends in {' or '.join(suffixes)}, got "
            f"{path.suffix or 'none'}"
        )
    if path.is_dir():
        raise ValueError(f"{path}: expected the name of a file, got a folder")
    if path.exists() and not force:
        raise ValueError(f"{path}: expected a new file, got one that exists; --force overwrites it")


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
