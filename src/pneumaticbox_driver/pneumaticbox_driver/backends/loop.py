"""Control loop on hardware: absolute deadlines, a monotonic clock, real-time priority."""

import os
import time
from collections.abc import Callable
from threading import Event


class DeadlineLoop:
    """Calls a function at a fixed period; missed periods are skipped and counted.

    `ticks` counts the steps, `missed` the dropped ticks.

    Args:
        period: time between the starts of two steps [s].
        record: list that gets the lateness of every step [s]; None for no record.

    Raises:
        ValueError: the period is not above zero.
    """

    def __init__(self, period: float, record: list[float] | None = None) -> None:
        if not period > 0:
            raise ValueError(f"period must be above 0 s, got {period}")
        self.period = period
        self._record = record
        self.ticks = 0
        self.missed = 0
        self._deadline = 0.0

    @property
    def slack(self) -> float:
        """Time from now to the next step [s]; negative when that is late."""
        return self._deadline + self.period - time.monotonic()

    def run(self, step: Callable[[], None], stop: Event) -> None:
        """Call `step` every period until `stop` is set."""
        self._deadline = time.monotonic() + self.period
        while not stop.is_set():
            left = self._deadline - time.monotonic()
            if left > 0:
                time.sleep(left)
            if self._record is not None:
                self._record.append(time.monotonic() - self._deadline)
            step()
            self.ticks += 1
            self._advance()

    def _advance(self) -> None:
        late = int(max(0.0, time.monotonic() - self._deadline) / self.period)
        self.missed += late
        self._deadline += (late + 1) * self.period


class SteadyClock:
    """A monotonic clock that starts at the time of the wall clock.

    The box uses this clock, while messages have stamps of the wall clock: when the wall clock is
    set, samples must show no pause or jump, and scheduled commands must keep their time.

    Args:
        monotonic: returns the time of the monotonic clock [s].
        wall: returns the time of the wall clock [s].

    >>> clock = SteadyClock(monotonic=lambda: 5.0, wall=lambda: 1000.0)
    >>> clock.now(), clock.of_stamp(1002.0)
    (1000.0, 1002.0)
    """

    def __init__(
        self, monotonic: Callable[[], float] = time.monotonic, wall: Callable[[], float] = time.time
    ) -> None:
        self._monotonic, self._wall = monotonic, wall
        self._begin = wall() - monotonic()

    def now(self) -> float:
        """Present time [s]."""
        return self._begin + self._monotonic()

    def of_stamp(self, stamp: float) -> float:
        """Time on this clock of a stamp of the wall clock [s]; a stamp of 0, which means now, stays
        0.
        """
        return max(0.0, stamp - self._wall() + self.now()) if stamp else 0.0


def set_priority(priority: int) -> bool:
    """Run this process with a fixed real-time priority, ahead of all ordinary processes.

    Args:
        priority: priority of SCHED_FIFO, 1 to 99; 0: ordinary scheduling.

    Returns:
        Whether the system allowed it; Linux requires root or a limit `rtprio`.

    >>> set_priority(0)
    True
    """
    policy = os.SCHED_FIFO if priority else os.SCHED_OTHER
    try:
        os.sched_setscheduler(0, policy, os.sched_param(priority))
    except PermissionError:
        return False
    return True
