"""The pretended bench as a board: its time passes with the monotonic clock."""

import math
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.backends.embedded import EmbeddedBench

Floats = NDArray[np.float64]
Valves = NDArray[np.int8]
TICK = 1e-3  # of the bench's clock: the plant's longest substep, so that none is wasted [s]
LONGEST_CATCH_UP = 0.1  # that the bench catches up with when the process was held [s]


class EmbeddedBoard:
    """Lets a bench run up to the present whenever it is read.

    Args:
        bench: from its time 0 on.
        clock: monotonic [s].
    """

    def __init__(self, bench: EmbeddedBench, clock: Callable[[], float] = time.monotonic) -> None:
        self.bench = bench
        self._clock = clock
        self._last = clock()

    @property
    def time(self) -> float:
        """Up to when the bench has run, on the monotonic clock, in whole ticks [s]."""
        return self._last

    def read(self) -> Floats:
        """Read absolute pressures now: channels, then supply (n + 1,) [Pa]."""
        passed = math.floor((self._clock() - self._last) / TICK + 1e-6)
        self._last += passed * TICK
        return self.bench.advance(min(passed * TICK, LONGEST_CATCH_UP))

    def command(self, valves: Valves) -> None:
        """Switch the valves (n,): +1 inflate, -1 deflate, 0 closed."""
        self.bench.command(valves)

    def set_supply(self, gauge: float) -> None:
        """Turn the supply regulator to a gauge pressure [Pa]."""
        self.bench.plant.set_supply(gauge)

    def close(self) -> None:
        """Open the outlets."""
        self.bench.command(np.full(len(self.bench.mass), -1, dtype=np.int8))
