"""Learns the noise of the sensors, and recognises one that goes on to send the same reading."""

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
LESSON = 100  # samples from which a sensor's noise is learnt
# A sensor whose noise is far below its converter's step stands still in its own right. These mark
# noise that shows wherever between two steps the pressure lies: it turns back at a fifth of the
# samples, and reaches four readings. Both together rule out noise at one edge, and a slow drift.
LEAST_TURNS = 0.2
LEAST_READINGS = 4
CHANCE = 1e-12  # of a run of equal readings that is still taken for noise


class FrozenReading:
    """Learns at rest how readings differ, and marks sensors that repeat one for too long.

    `frozen` (m,) marks them, `run` (m,) counts the equal readings in a row. A sensor without
    visible noise is never marked. `noise` (m,) is one sigma [Pa], infinite until it is learnt.

    Args:
        sensors: number of sensors m.
    """

    def __init__(self, sensors: int) -> None:
        self._longest: Floats = np.full(sensors, np.inf)  # run that noise may bring about
        self._last: Floats = np.full(sensors, np.nan)
        self._lesson: list[Floats] = []
        self._learnt = False
        self.run: Floats = np.zeros(sensors)
        self.noise: Floats = np.full(sensors, np.inf)

    @property
    def frozen(self) -> Flags:
        """Sensors whose reading stands still (m,)."""
        return self.run > self._longest

    def look(self, readings: Floats, in_range: Flags) -> None:
        """Take the readings of one sample (m,), as the sensors gave them.

        Those not `in_range` (m,) may well stand still.
        """
        self.run = np.where((readings == self._last) & in_range, self.run + 1.0, 0.0)
        self._last = readings
        if not self._learnt:
            self._lesson.append(readings)
            if len(self._lesson) == LESSON:
                self._learn(np.array(self._lesson))
                self._lesson.clear()

    def _learn(self, lesson: Floats) -> None:
        self._learnt = True
        steps = np.diff(lesson, axis=0)
        self.noise = np.sqrt(0.5 * np.mean(steps**2, axis=0))
        turns = np.mean(steps[1:] * steps[:-1] < 0, axis=0)
        for sensor in range(lesson.shape[1]):
            readings = len(np.unique(lesson[:, sensor]))
            if turns[sensor] < LEAST_TURNS or readings < LEAST_READINGS:
                continue
            # half the share that was seen: it varies with where between two steps the pressure is
            share = 0.5 * float(np.mean(steps[:, sensor] != 0))
            self._longest[sensor] = math.log(CHANCE) / math.log1p(-share)
