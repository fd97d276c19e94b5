"""The clock of a driver that has no simulator: the wall's at the start, never set after it."""

import time
from collections.abc import Callable


class SteadyClock:
    """Counts on from the wall clock's time at the start, whatever happens to the wall clock.

    The box's times are of this clock, those of messages of the wall clock: a step of the wall
    clock must not look like a pause or a leap of the sensors, and what has been scheduled before
    it keeps its moment.

    Args:
        monotonic: the steady source [s].
        wall: the wall clock [s].

    >>> clock = SteadyClock(monotonic=lambda: 5.0, wall=lambda: 1000.0)
    >>> clock.now(), clock.of_stamp(1002.0)
    (1000.0, 1002.0)
    """

    def __init__(
        self,
        monotonic: Callable[[], float] = time.monotonic,
        wall: Callable[[], float] = time.time,
    ) -> None:
        self._monotonic, self._wall = monotonic, wall
        self._begin = wall() - monotonic()

    def now(self) -> float:
        """Present time [s]."""
        return self._begin + self._monotonic()

    def of_stamp(self, stamp: float) -> float:
        """Time that a stamp of the present wall clock means [s]; 0 stands for now and stays."""
        return max(0.0, stamp - self._wall() + self.now()) if stamp else 0.0
