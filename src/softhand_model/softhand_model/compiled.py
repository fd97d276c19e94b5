"""numba where it is installed, plain Python where it is not (the same results, slower)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

try:
    import numba
except ImportError:
    numba = None

COMPILED = numba is not None


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Decorate a numerical kernel: compiled and cached on disk by numba, or left as it is."""
    if numba is None:
        return function
    return numba.njit(cache=True, fastmath=False)(function)
