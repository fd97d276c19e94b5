"""Aliases of the types that all modules share."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]

Tell = Callable[[str, int, int], None]
"""Progress callback: what is done now, its number from 1, of how many (0: unknown)."""


def tell_nobody(step: str, number: int, total: int) -> None:
    """A progress callback that does nothing. Its arguments are the name of the step, its number,
    and the number of all steps.
    """
