"""numba where it is installed, plain Python where it is not (the same results, slower)."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

COMPILED = find_spec("numba") is not None


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Decorate a numerical kernel: compiled and cached on disk by numba, or left as it is."""
    if not COMPILED:
        return function
    from numba import njit

    return njit(cache=True, fastmath=False)(function)
