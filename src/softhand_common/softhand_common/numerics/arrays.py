"""Types of arrays by their content."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.intp]
Spools = NDArray[np.int8]  # of valves: +1 inflating, -1 deflating, 0 closed
