"""Results that a user names: nothing is overwritten unless it is asked for."""

from __future__ import annotations

from pathlib import Path

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
