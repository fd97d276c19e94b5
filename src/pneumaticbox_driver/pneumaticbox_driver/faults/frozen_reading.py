"""Detection of frozen sensors: their noise is learned, and readings that repeat too often are
marked."""

import math

import numpy as np
from scipy.special import betaincinv

from pneumaticbox_driver.arrays import Flags, Floats
from softhand_common.numerics.compiled import compiled

LEARNING_SAMPLES = 100  # from which the noise of a sensor is learnt
# The reading of a sensor with noise far below the step of its converter may be constant without a
# fault. A sensor has sufficient noise if a fifth of its changes reverse direction and it has four
# different readings: this excludes noise at the edge of one step, and slow drift.
LEAST_REVERSALS = 0.2
LEAST_READINGS = 4
FROZEN_CHANCE = 1e-12  # of a run of equal readings that is still taken for noise
COMMON_NOISE = 0.5  # correlation of sensors' noise from which it is that of one source
# Sensors that stand still together may do so for a moment because a board hands out old readings.
FEWEST_TOGETHER = 10
REPEATS_DOUBT = 1e-3  # that a sensor repeats readings more often than its lesson lets one expect


class FrozenReading:
    """Learns the noise of sensors at rest, and marks sensors with a constant reading.

    `frozen` (m,) marks them, `run` (m,) counts the equal readings in a row. Sensors with noise of
    their own that all stand still are marked sooner, as the chances multiply. A sensor without
    visible noise is never marked. `noise` (m,) is one sigma [Pa], infinite until it is learnt.

    Args:
        sensors: number of sensors m.
    """

    def __init__(self, sensors: int) -> None:
        self._longest: Floats = np.full(sensors, np.inf)  # run that noise may bring about
        self._together: Flags = np.zeros(sensors, dtype=bool)  # whose noise shows and is their own
        self._longest_together = np.inf  # run of all those that noise may bring about
        self._last: Floats = np.full(sensors, np.nan)
        self._lesson: list[Floats] = []
        self._learnt = False
        self.run: Floats = np.zeros(sensors)
        self.noise: Floats = np.full(sensors, np.inf)
        # compile or load the kernels before the first sample
        count_repeats(self._last, self._together, self._last.copy(), self.run)
        _ = self.frozen

    @property
    def frozen(self) -> Flags:
        """Sensors whose reading stands still (m,)."""
        frozen = np.empty_like(self._together)
        mark_frozen(self.run, self._longest, self._together, self._longest_together, frozen)
        return frozen

    def look(self, readings: Floats, in_range: Flags) -> None:
        """Add the unprocessed readings of one sample (m,).

        Sensors that are not `in_range` (m,) may have a constant reading without a fault.
        """
        count_repeats(readings, in_range, self._last, self.run)
        if not self._learnt:
            self._lesson.append(readings.copy())
            if len(self._lesson) == LEARNING_SAMPLES:
                self._learn(np.array(self._lesson))
                self._lesson.clear()

    def _learn(self, lesson: Floats) -> None:
        self._learnt = True
        steps = np.diff(lesson, axis=0)
        self.noise = np.sqrt(0.5 * np.mean(steps**2, axis=0))
        reversals = np.mean(steps[1:] * steps[:-1] < 0, axis=0)
        for sensor in range(lesson.shape[1]):
            readings = len(np.unique(lesson[:, sensor]))
            if reversals[sensor] < LEAST_REVERSALS or readings < LEAST_READINGS:
                continue
            repeats = _share_of_repeats(steps[:, sensor], self.noise[sensor])
            self._longest[sensor] = math.log(FROZEN_CHANCE) / math.log(repeats)
        noisy = np.isfinite(self._longest)
        if noisy.any() and _greatest_correlation(steps[:, noisy]) < COMMON_NOISE:
            self._together = noisy
            chance = 1.0 / np.sum(1.0 / self._longest[noisy])  # the logarithms add up
            self._longest_together = max(float(chance), FEWEST_TOGETHER)


@compiled
def count_repeats(readings: Floats, in_range: Flags, last: Floats, run: Floats) -> None:
    """Count equal readings in a row (m,) of sensors `in_range` (m,), and keep the `last` ones, in
    place.
    """
    for i in range(len(run)):
        run[i] = run[i] + 1.0 if in_range[i] and readings[i] == last[i] else 0.0
        last[i] = readings[i]


@compiled
def mark_frozen(
    run: Floats, longest: Floats, together: Flags, longest_together: float, frozen: Flags
) -> None:
    """Mark the sensors (m,) whose `run` (m,) of equal readings is above the `longest` (m,), and
    those of `together` (m,), if there are any, once each of their runs is above `longest_together`.
    """
    least = np.inf
    for i in range(len(run)):
        if together[i]:
            least = min(least, run[i])
    all_together = least < np.inf and least > longest_together
    for i in range(len(run)):
        frozen[i] = run[i] > longest[i] or (together[i] and all_together)


def _greatest_correlation(steps: Floats) -> float:
    """Greatest correlation between columns of `steps` (n, k)."""
    correlations = np.atleast_2d(np.corrcoef(steps, rowvar=False))
    return float(np.abs(np.triu(correlations, 1)).max())


def _share_of_repeats(steps: Floats, noise: float) -> float:
    """Upper bound of the probability that a reading equals the one before it, wherever between two
    steps of the converter the pressure lies.

    The larger of two bounds: the upper confidence limit (Clopper and Pearson) of the share among
    `steps` (n,) [Pa], the differences of readings, and the share of normal noise of one sigma
    `noise` [Pa] in the step of the converter around its mean. The latter also holds for noise that
    is correlated from sample to sample (AR(1)): `noise` then is at most that of its innovations.
    """
    moved = np.abs(steps[steps != 0])
    equal = len(steps) - len(moved)
    seen = float(betaincinv(equal + 1, len(steps) - equal, 1.0 - REPEATS_DOUBT))
    return max(seen, math.erf(moved.min() / (2.0 * math.sqrt(2.0) * noise)))
