"""Recognises a channel at rest, so that its sensor and its air mass can be zeroed."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
WINDOW = 0.1  # over which a pressure is averaged [s]
LEAST_SAMPLES = 25  # in a window, whatever the sampling: less would leave noise in the mean
STILL_TOLERANCE = 45.0  # between the means of two windows in a row [Pa]


class StillPressure:
    """Averages pressures over windows and tells which stand still from window to window.

    Args:
        channels: number of channels.
    """

    def __init__(self, channels: int) -> None:
        self._sum: Floats = np.zeros(channels)
        self._count: Floats = np.zeros(channels)
        self._since: Floats = np.zeros(channels)
        self.mean: Floats = np.full(channels, np.nan)  # of the last full window [Pa]
        self.still: Flags = np.zeros(channels, dtype=bool)

    def restart(self, channels: Flags | slice = slice(None)) -> None:
        """Forget the samples of these channels: none of them stands still any more."""
        for memory in (self._sum, self._count, self._since):
            memory[channels] = 0.0
        self.mean[channels] = np.nan
        self.still[channels] = False

    def add(self, dt: float, pressures: Floats) -> bool:
        """Add a sample (n,) [Pa], `dt` [s] after the one before; True when a window is full."""
        self._sum += pressures
        self._count += 1.0
        self._since += dt
        full = (self._since >= WINDOW - 1e-9) & (self._count >= LEAST_SAMPLES)
        if not full.any():
            return False
        mean = self._sum / self._count
        self.still = np.where(full, np.abs(mean - self.mean) < STILL_TOLERANCE, self.still)
        self.mean = np.where(full, mean, self.mean)
        for memory in (self._sum, self._count, self._since):
            memory[full] = 0.0
        return True
