"""Keeping simulated time from running ahead of wall time."""

from __future__ import annotations

import time


class Pace:
    """Sleeps so that simulated over wall time stays at `limit` or below; 0 never sleeps."""

    def __init__(self, limit: float) -> None:
        self.limit = limit
        self.restart(0.0)

    def restart(self, simulated: float) -> None:
        """Begin to count at this simulated time [s]."""
        self._wall, self._simulated, self._now = time.monotonic(), simulated, simulated

    def wait(self, simulated: float) -> None:
        """Sleep until the wall clock has caught up; time that was lost is not made up for."""
        self._now = simulated
        if not self.limit:
            return
        ahead = (simulated - self._simulated) / self.limit - (time.monotonic() - self._wall)
        if ahead > 0:
            time.sleep(ahead)
        elif ahead < -0.1:
            self.restart(simulated)

    def factor(self) -> float:
        """Simulated over wall time since the last restart."""
        wall = time.monotonic() - self._wall
        return (self._now - self._simulated) / wall if wall > 0 else 0.0
