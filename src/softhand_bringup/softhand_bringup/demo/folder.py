"""A folder of its own for every run, and the link to the latest."""

from __future__ import annotations

import itertools
import time
from pathlib import Path


def make_run_folder(out: Path, prefix: str = "demo") -> Path:
    """Make `out/demo-<time>` and let the link `out/demo` point to it.

    Raises:
        OSError: the folder cannot be made or written.
    """
    out.mkdir(parents=True, exist_ok=True)
    stem = time.strftime(f"{prefix}-%Y%m%d-%H%M%S")
    for number in itertools.count(1):
        folder = out / (stem if number == 1 else f"{stem}-{number}")
        try:
            folder.mkdir()
            break
        except FileExistsError:
            continue
    _point(out / prefix, folder.name)
    return folder


def _point(link: Path, target: str) -> None:
    """Replace a symbolic link in one step, so that it never points nowhere."""
    fresh = link.with_name(f".{link.name}-{target}")
    fresh.symlink_to(target)
    fresh.replace(link)
