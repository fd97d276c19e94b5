"""Types of arrays with one entry per channel (n,)."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Counts = NDArray[np.int64]
Valves = NDArray[np.int8]  # +1 inflate, -1 deflate, 0 closed


def some(values: Floats | Flags | Valves) -> bool:
    """Whether a value (n,) is not 0; of a few channels that takes a third of `values.any()`.

    >>> some(np.array([False, True])), some(np.zeros(2))
    (True, False)
    """
    return any(values.tolist())


def same(one: Valves, other: Valves) -> bool:
    """Whether valves (n,) are the same; takes a fifth of `(one == other).all()`.

    >>> same(np.zeros(2, np.int8), np.array([0, 1], np.int8))
    False
    """
    return one.tobytes() == other.tobytes()
