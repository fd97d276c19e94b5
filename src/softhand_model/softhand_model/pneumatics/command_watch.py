"""The plant's own safety rule: outlets open when the driver falls silent."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

SILENCE_LIMIT = 0.25  # of the plant's own time [s]


class CommandWatch:
    """Holds the last valve command and opens every outlet when none has come for a while.

    Valves without a driver must not stay as they are: a driver that died with an inlet open
    would burst the hand. Every command counts as a sign of life, also one that changes nothing.

    >>> watch = CommandWatch(channels=2)
    >>> watch.receive(0.0, [1, 0])
    >>> watch.valves(0.2).tolist(), watch.valves(0.3).tolist()
    ([1, 0], [-1, -1])
    """

    def __init__(
        self, channels: int, time: float = 0.0, silence_limit: float = SILENCE_LIMIT
    ) -> None:
        """Start with closed valves.

        Args:
            channels: number of channels.
            time: of the plant, now [s].
            silence_limit: longest time without a command [s].

        Raises:
            ValueError: `silence_limit` is not above zero.
        """
        if not silence_limit > 0:
            raise ValueError(f"silence_limit must be above 0 s, got {silence_limit}")
        self.silence_limit = silence_limit
        self._vent: NDArray[np.int8] = np.full(channels, -1, dtype=np.int8)
        self.reset(time)

    def reset(self, time: float) -> None:
        """Close the valves and start counting the silence at `time` [s]."""
        self._last = time
        self._valves: NDArray[np.int8] = np.zeros_like(self._vent)

    def receive(self, time: float, valves: ArrayLike) -> None:
        """Take a command at the plant's `time` [s]: +1 inflate, -1 deflate, 0 closed per channel.

        Raises:
            ValueError: wrong number of channels, or another value than -1, 0, 1.
        """
        self._valves = checked_valves(valves, len(self._vent))
        self._last = time

    def silent(self, time: float) -> bool:
        """Tell whether the driver has been silent for longer than the limit at `time` [s]."""
        return time - self._last > self.silence_limit + 1e-9

    def valves(self, time: float) -> NDArray[np.int8]:
        """Valves to apply at `time` [s]: the last command, or all outlets open after silence."""
        return self._vent if self.silent(time) else self._valves


def checked_valves(valves: ArrayLike, channels: int) -> NDArray[np.int8]:
    """Return valve commands (channels,) as integers in {-1, 0, 1}.

    Raises:
        ValueError: wrong shape or another value, NaN included.

    >>> checked_valves([1.0, 0.0, -1.0], 3)
    array([ 1,  0, -1], dtype=int8)
    """
    given = np.asarray(valves)
    if given.shape != (channels,):
        raise ValueError(f"valves must have shape ({channels},), got {given.shape}")
    for value in given.tolist():
        if value not in (-1, 0, 1):
            raise ValueError(f"valves must be -1, 0 or 1, got {value}")
    return given.astype(np.int8)
