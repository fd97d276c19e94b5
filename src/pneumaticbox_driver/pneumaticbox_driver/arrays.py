"""Types of arrays with one entry per channel (n,)."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Counts = NDArray[np.int64]
Valves = NDArray[np.int8]  # +1 inflate, -1 deflate, 0 closed
