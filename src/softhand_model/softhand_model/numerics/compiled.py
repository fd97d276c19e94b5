"""Numerical kernels compiled by numba, and cached on disk until any of them changes."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from numba import njit
from numba.core import event

COMPILING = "compiling the numerical kernels: about a minute, at the first start only"


def compiled(function: Callable[..., Any]) -> Any:
    """Decorate a numerical kernel: compiled and cached on disk by numba, with numpy's divisions.

    What is cached counts as old when any kernel of its package has changed: by itself numba looks
    at the file of the function alone, and would go on with what it calls in other files as it was.
    """
    kernel: Any = njit(cache=True, fastmath=False, error_model="numpy")(function)
    file = sys.modules[function.__module__].__file__ if function.__module__ in sys.modules else None
    if file is not None:
        depth = function.__module__.count(".")
        kernel._cache._cache_file._source_stamp = kernels_stamp(
            Path(file).parents[max(0, depth - 1)]
        )
    return kernel


@cache
def kernels_stamp(folder: Path) -> tuple[float, int]:
    """Time of the latest change [s] and size [bytes] of all files with kernels below a folder."""
    stats = [file.stat() for file in folder.rglob("*.py") if "@compiled" in file.read_text("utf-8")]
    return max((s.st_mtime for s in stats), default=0.0), sum(s.st_size for s in stats)


class _BeforeCompiling(event.Listener):
    """Tells that a kernel is about to be compiled, of the first one only."""

    def __init__(self, tell: Callable[[str], None]) -> None:
        self._tell, self._told = tell, False

    def on_start(self, event: event.Event) -> None:
        """Called by numba before a kernel that is not in the cache."""
        if not self._told:
            self._told = True
            self._tell(COMPILING)

    def on_end(self, event: event.Event) -> None:
        """Called by numba after it."""


@contextmanager
def compilation_told(tell: Callable[[str], None]) -> Iterator[None]:
    """Have `tell` called with a sentence before the first kernel is compiled, if one has to be."""
    with event.install_listener("numba:compile", _BeforeCompiling(tell)):
        yield
