"""numba where it is installed, plain Python where it is not (the same results, slower)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

try:
    from numba import njit as _njit
except ImportError:
    _njit = None

COMPILED = _njit is not None


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Decorate a numerical kernel: compiled and cached on disk by numba, or left as it is."""
    if _njit is None:
        return function
    return _njit(cache=True, fastmath=False)(function)
