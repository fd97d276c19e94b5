"""A periodic loop on absolute deadlines, for control without a simulator."""

import time
from collections.abc import Callable
from threading import Event


class DeadlineLoop:
    """Calls a step at a fixed period; ticks that were missed are dropped and counted.

    `ticks` counts the steps, `missed` the dropped ticks, `lateness` [s] how late the last step
    began.

    Args:
        period: from step to step [s].
        record: gets the lateness of every step; None keeps the last alone.

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
        self.lateness = 0.0
        self._deadline = 0.0

    @property
    def slack(self) -> float:
        """Time from now to the next step, while one runs; below 0 when it is late already [s]."""
        return self._deadline + self.period - time.monotonic()

    def run(self, step: Callable[[], None], stop: Event) -> None:
        """Call `step` every period until `stop` is set."""
        self._deadline = time.monotonic() + self.period
        while not stop.is_set():
            left = self._deadline - time.monotonic()
            if left > 0:
                time.sleep(left)
            self.lateness = time.monotonic() - self._deadline
            if self._record is not None:
                self._record.append(self.lateness)
            step()
            self.ticks += 1
            self._advance()

    def _advance(self) -> None:
        late = int(max(0.0, time.monotonic() - self._deadline) / self.period)
        self.missed += late
        self._deadline += (late + 1) * self.period
