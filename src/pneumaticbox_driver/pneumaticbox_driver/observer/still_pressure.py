"""Detection of constant pressures by averages over windows, for noise of any size."""

import math

import numpy as np

from pneumaticbox_driver.arrays import Flags, Floats
from softhand_common.numerics.compiled import compiled

AVERAGE_WINDOW = 0.1  # over which a pressure is averaged [s]
WINDOW_END = AVERAGE_WINDOW - 1e-9  # with room for rounding [s]
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
        self.add(0.0, self._sum.copy())  # compile or load the kernel before the first sample
        self.restart()

    def restart(self, channels: Flags | slice = slice(None)) -> None:
        """Clear the samples of these channels, which are then not constant."""
        for memory in (self._sum, self._squares, self._count, self._since):
            memory[channels] = 0.0
        for memory in (self._last, self.mean):
            memory[channels] = np.nan
        self.still[channels] = False

    def shift(self, channel: int, change: float) -> None:
        """Shift the earlier samples of a channel by `change` [Pa], as its sensor has a new
        offset.
        """
        self._sum[channel] += self._count[channel] * change
        self._last[channel] += change
        self.mean[channel] += change

    def add(self, dt: float, pressures_abs: Floats) -> bool:
        """Add absolute pressures (n,) [Pa] after `dt` [s]; returns whether a window is full."""
        window = self._last, self._squares, self._sum, self._count, self._since
        if not add_to_window(dt, pressures_abs, *window):
            return False
        full = (self._since >= WINDOW_END) & (self._count >= LEAST_WINDOW_SAMPLES)
        mean = self._sum / self._count
        # steps have twice the variance of a sample, the difference of two means 2/count of it
        tolerance = np.maximum(STILL_TOLERANCE, STILL_SIGMAS * np.sqrt(self._squares) / self._count)
        self.still = np.where(full, np.abs(mean - self.mean) < tolerance, self.still)
        self.mean = np.where(full, mean, self.mean)
        for memory in (self._sum, self._squares, self._count, self._since):
            memory[full] = 0.0
        return True


@compiled
def add_to_window(
    dt: float,
    pressures_abs: Floats,
    last: Floats,
    squares: Floats,
    total: Floats,
    count: Floats,
    since: Floats,
) -> bool:
    """Add absolute pressures (n,) [Pa] after `dt` [s] to the windows of `StillPressure`, in place;
    returns whether one is full.
    """
    full = False
    for i in range(len(last)):
        step = pressures_abs[i] - last[i]
        if not math.isnan(step):
            squares[i] += step * step
        last[i] = pressures_abs[i]
        total[i] += pressures_abs[i]
        count[i] += 1.0
        since[i] += dt
        full |= since[i] >= WINDOW_END and count[i] >= LEAST_WINDOW_SAMPLES
    return full
