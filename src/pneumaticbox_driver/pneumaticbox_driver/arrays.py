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
