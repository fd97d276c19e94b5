"""How often the valves of each channel have opened of late: shows a valve that chatters."""

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

Counts = NDArray[np.int64]
ACTIVITY_WINDOW = 10.0  # of node time [s]
RESOLUTION = 0.5  # from one remembered count to the next [s]
CHATTER = 5.0  # openings a second; a 45 ms pulse and a 60 ms pause allow nearly twice that [1/s]


class ValveActivity:
    """Remembers the counts of openings over a window of the box's time.

    Args:
        channels: number of channels.

    >>> activity = ValveActivity(2)
    >>> for second in range(30):
    ...     activity.note(float(second), np.array([second, 6 * second]))
    >>> activity.recent, activity.chatters
    (array([10, 60]), array([False,  True]))
    """

    def __init__(self, channels: int) -> None:
        self._none: Counts = np.zeros(channels, dtype=np.int64)
        self._counts: deque[tuple[float, Counts]] = deque()

    def note(self, time: float, openings: Counts) -> None:
        """Take the openings so far (n,) at the box's `time` [s]; set back, it begins anew."""
        if math.isnan(time):
            return  # no sample has come yet
        counts = self._counts
        if counts and time < counts[-1][0]:
            counts.clear()
        if counts and time - counts[-1][0] < RESOLUTION:
            return
        counts.append((time, openings.copy()))
        while len(counts) > 1 and time - counts[1][0] >= ACTIVITY_WINDOW:
            counts.popleft()

    @property
    def recent(self) -> Counts:
        """Openings within the window (n,)."""
        if not self._counts:
            return self._none
        return np.asarray(self._counts[-1][1] - self._counts[0][1])

    @property
    def chatters(self) -> NDArray[np.bool_]:
        """Channels whose valve opens more often than any target asks for (n,)."""
        return np.asarray(self.recent > CHATTER * ACTIVITY_WINDOW)
