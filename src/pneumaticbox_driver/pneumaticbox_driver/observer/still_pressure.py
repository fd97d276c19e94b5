"""Detection of constant pressures by averages over windows, for noise of any size."""

import numpy as np

from pneumaticbox_driver.arrays import Flags, Floats

AVERAGE_WINDOW = 0.1  # over which a pressure is averaged [s]
LEAST_WINDOW_SAMPLES = 25  # in a window at any sampling rate, to limit the noise of the mean
STILL_TOLERANCE = 45.0  # between the means of two consecutive windows [Pa]
STILL_SIGMAS = 4.0  # tolerance in standard deviations of that difference, if that is more [-]


class StillPressure:
    """Averages pressures over windows and marks those that are constant from window to window.

    The noise is estimated from differences of consecutive samples, hardly affected by motion.

    Args:
        channels: number of channels.
    """

    def __init__(self, channels: int) -> None:
        self._sum: Floats = np.zeros(channels)
        self._squares: Floats = np.zeros(channels)  # of the steps from sample to sample [Pa2]
        self._count: Floats = np.zeros(channels)
        self._since: Floats = np.zeros(channels)
        self._last: Floats = np.full(channels, np.nan)
        self.mean: Floats = np.full(channels, np.nan)  # of the last full window [Pa]
        self.still: Flags = np.zeros(channels, dtype=bool)

    def restart(self, channels: Flags | slice = slice(None)) -> None:
        """Clear the samples of these channels, which are then not constant."""
        for memory in (self._sum, self._squares, self._count, self._since):
            memory[channels] = 0.0
        for memory in (self._last, self.mean):
            memory[channels] = np.nan
        self.still[channels] = False

    def shift(self, channel: int, change: float) -> None:
        """Shift the earlier samples of a channel by `change` [Pa], for a new offset."""
        self._sum[channel] += self._count[channel] * change
        self._last[channel] += change
        self.mean[channel] += change

    def add(self, dt: float, pressures_abs: Floats) -> bool:
        """Add absolute pressures (n,) [Pa] after `dt` [s]; returns whether a window is full."""
        step = pressures_abs - self._last
        self._squares += np.where(np.isnan(step), 0.0, step * step)
        self._last = pressures_abs.copy()
        self._sum += pressures_abs
        self._count += 1.0
        self._since += dt
        full = (self._since >= AVERAGE_WINDOW - 1e-9) & (self._count >= LEAST_WINDOW_SAMPLES)
        if not full.any():
            return False
        mean = self._sum / self._count
        # steps have twice the variance of a sample, the difference of two means 2/count of it
        tolerance = np.maximum(STILL_TOLERANCE, STILL_SIGMAS * np.sqrt(self._squares) / self._count)
        self.still = np.where(full, np.abs(mean - self.mean) < tolerance, self.still)
        self.mean = np.where(full, mean, self.mean)
        for memory in (self._sum, self._squares, self._count, self._since):
            memory[full] = 0.0
        return True
