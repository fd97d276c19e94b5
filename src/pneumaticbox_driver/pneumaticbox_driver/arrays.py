"""Types of arrays with one entry per channel (n,)."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Counts = NDArray[np.int64]
Valves = NDArray[np.int8]  # +1 inflate, -1 deflate, 0 closed


def some(values: Floats | Flags | Valves) -> bool:
    """Whether any of the values (n,) is not 0; for a few channels in a third of the time of
    `values.any()`.

    >>> some(np.array([False, True])), some(np.zeros(2))
    (True, False)
    """
    return any(values.tolist())


def same(one: Valves, other: Valves) -> bool:
    """Whether two arrays of valves (n,) are equal; takes a fifth of the time of `(one ==
    other).all()`.

    >>> same(np.zeros(2, np.int8), np.array([0, 1], np.int8))
    False
    """
    return one.tobytes() == other.tobytes()
