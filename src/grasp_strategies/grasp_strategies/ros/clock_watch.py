"""Whether simulated time stands still."""

from __future__ import annotations

from dataclasses import dataclass

CLOCK_STILL_WARNING_TIME = 5.0  # [s] of wall time without a tick that is worth a warning


@dataclass
class ClockWatch:
    """Detects that simulated time stands still.

    >>> watch = ClockWatch()
    >>> [watch.warning(now, wall) for now, wall in ((1, 0.0), (1, 4.0), (2, 5.0), (2, 9.0))]
    ['', '', '', '']
    >>> watch.warning(2, 11.0)
    '/clock has stood still for 6 s (simulator paused or absent)'
    """

    last: int | None = None
    since: float = 0.0

    def warning(self, now: int, wall: float) -> str:
        """The warning at simulated time `now` [ns] and wall time `wall` [s]; empty while time
        advances.
        """
        if now != self.last:
            self.last, self.since = now, wall
        still = wall - self.since
        if still <= CLOCK_STILL_WARNING_TIME:
            return ""
        return f"/clock has stood still for {still:.0f} s (simulator paused or absent)"
