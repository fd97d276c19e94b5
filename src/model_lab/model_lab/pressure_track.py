"""The latest pressures of a hand's channels: what they were at a stamp, and whether they stood."""

from __future__ import annotations

from bisect import bisect_left, bisect_right

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

KEPT = 5 * 10**9  # time [ns] for which pressures are kept; angles that come later find none


class PressureTrack:
    """Pressures (channels,) [Pa] by rising stamps [ns], straight lines between."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget all."""
        self._stamps: list[int] = []
        self._values: list[Array] = []

    @property
    def newest(self) -> int | None:
        """Stamp [ns] of the newest pressures."""
        return self._stamps[-1] if self._stamps else None

    def add(self, stamp: int, values: Array) -> None:
        """Take pressures that are newer than all before."""
        self._stamps.append(stamp)
        self._values.append(values)
        if stamp - self._stamps[0] > 2 * KEPT:  # seldom, as it moves the whole list
            self._forget(bisect_left(self._stamps, stamp - KEPT))

    def covers(self, stamp: int) -> bool:
        """Whether the stamp [ns] lies between pressures that are kept."""
        return bool(self._stamps) and self._stamps[0] <= stamp <= self._stamps[-1]

    def at(self, stamp: int) -> Array:
        """Pressures (channels,) [Pa] at a stamp [ns] that is covered.

        >>> track = PressureTrack()
        >>> track.add(0, np.array([0.0])), track.add(10, np.array([5.0]))
        (None, None)
        >>> track.at(4).tolist()
        [2.0]
        """
        after = bisect_left(self._stamps, stamp)
        if self._stamps[after] == stamp:
            return self._values[after]
        first, last = self._stamps[after - 1], self._stamps[after]
        share = (stamp - first) / (last - first)
        return (1.0 - share) * self._values[after - 1] + share * self._values[after]

    def stood(self, stamp: int, duration: int, band: float) -> Flags:
        """Whether each pressure has kept within a band [Pa] for a duration [ns] up to a stamp that
        is covered; False where that reaches back before the first.
        """
        first = bisect_left(self._stamps, stamp - duration)
        known = self._values[first : bisect_right(self._stamps, stamp)]
        values = np.array([*known, self.at(stamp)])
        since = self._stamps[0] <= stamp - duration
        return (np.ptp(values, axis=0) <= band) & since

    def _forget(self, count: int) -> None:
        del self._stamps[:count], self._values[:count]
