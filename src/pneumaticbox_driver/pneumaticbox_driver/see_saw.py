"""Durations of the test pulses of a calibration (Algorithm 1, section 4.4.2)."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SeeSawPlan:
    """Ranges of Algorithm 1: durations [s], gauge channel pressures [Pa], skew and speeds.

    `mean_duration` [s] is the scale of the exponential, `speed_ratio` that of deflation over
    inflation [-]. The thesis has a skew factor of 2 for 400 points and more. With 100 of them a
    bottle of 0.5 L is carried through the range by a larger one only; and as the longest pulses
    then carry it up, or down, all others can be as short as those of a controller.
    """

    shortest: float = 0.045  # just above the slowest opening delay, or a pulse may move nothing
    longest: float = 1.5
    mean_duration: float = 0.18
    low_pressure: float = 3e3
    high_pressure: float = 60e3
    skew_factor: float = 25.0
    speed_ratio: float = 4.0


class SeeSaw:
    """Draws pulse durations that carry each channel up and down through its pressure range.

    ERRATUM: Algorithm 1 prints the speed ratio upside down; here the faster deflation gets the
    shorter pulses, `t_deflation = t/skew * inflation_speed/deflation_speed`.

    Args:
        plan: ranges.
        channels: number of channels; each has its own durations.
        seed: of the durations.
    """

    def __init__(self, plan: SeeSawPlan, channels: int, seed: int) -> None:
        self._plan = plan
        self._random = np.random.default_rng(seed)
        self._skew: Floats = np.full(channels, math.sqrt(plan.skew_factor))

    def next(self, gauge: Floats) -> tuple[Floats, Floats]:
        """Draw the next durations of inflation and deflation (n,), (n,) [s].

        Args:
            gauge: present channel pressures (n,) [Pa].
        """
        plan = self._plan
        up = math.sqrt(plan.skew_factor)
        self._skew = np.where(gauge < plan.low_pressure, up, self._skew)
        self._skew = np.where(gauge > plan.high_pressure, 1 / up, self._skew)
        span = plan.longest - plan.shortest
        uniform = self._random.uniform(size=len(gauge))
        drawn = -plan.mean_duration * np.log1p(-uniform * -math.expm1(-span / plan.mean_duration))
        # the shortest pulse is the valve's and knows no skew
        inflation = plan.shortest + drawn * self._skew
        return inflation, plan.shortest + drawn / self._skew / plan.speed_ratio
