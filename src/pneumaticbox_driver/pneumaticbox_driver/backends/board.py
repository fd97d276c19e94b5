"""What a backend is that this process drives itself: a board with valves and pressure sensors."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Valves = NDArray[np.int8]


class Board(Protocol):
    """Valves and sensors of n channels; the driver's loop reads it, answers, reads again.

    Whoever makes one raises ValueError or OSError for devices that are not there, with a sentence
    that names them, before a valve has moved.
    """

    @property
    def time(self) -> float:
        """Time of the last reading on a clock that is never set back [s]; NaN before the first."""
        ...

    def read(self) -> Floats:
        """Read absolute pressures: channels, then supply (n + 1,) [Pa]; NaN for no reading.

        Raises:
            ValueError, OSError: the board has failed.
        """
        ...

    def command(self, valves: Valves) -> None:
        """Switch the valves (n,): +1 inflate, -1 deflate, 0 closed; raises as `read` does."""
        ...

    def close(self) -> None:
        """Leave the outlets open and let the devices go."""
        ...
