"""What slow valves can follow: the shortest pulse and the pause between pulses."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Valves = NDArray[np.int8]


class PulseTiming:
    """Keeps a valve open for the shortest pulse and closed for the shortest pause.

    A pulse shorter than the delays of the valve (20-40 ms) may move no air at all, and one that
    follows too soon begins before the last one has ended: equation 4.1 holds for neither. One
    outlet follows the other only through a pause.

    Args:
        channels: number of channels.
        shortest_pulse: least time a valve stays open [s].
        shortest_pause: least time it stays closed [s].
    """

    def __init__(self, channels: int, shortest_pulse: float, shortest_pause: float) -> None:
        self._pulse = shortest_pulse
        self._pause = shortest_pause
        self.valves: Valves = np.zeros(channels, dtype=np.int8)
        self.switched: Floats = np.full(channels, -np.inf)  # when each valve switched last [s]

    def follow(self, time: float, wanted: Valves) -> Valves:
        """Return the valves to command at `time` [s], as near to `wanted` (n,) as they can."""
        if (wanted == self.valves).all():
            return self.valves
        is_open = self.valves != 0
        through_pause = np.where(is_open & (wanted != self.valves), 0, wanted)
        least = np.where(is_open, self._pulse, self._pause)
        ready = time - self.switched >= least - 1e-6
        return np.where(ready, through_pause, self.valves).astype(np.int8)

    def switch(self, time: float, valves: Valves) -> None:
        """Note that `valves` (n,) are commanded at `time` [s]."""
        self.switched[valves != self.valves] = time
        self.valves = valves.copy()

    def restart(self) -> None:
        """Forget the past, valves closed: time has been set back."""
        self.valves = np.zeros_like(self.valves)
        self.switched[:] = -np.inf
