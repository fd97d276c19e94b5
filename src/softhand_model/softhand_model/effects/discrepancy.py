"""A generic term for what no known effect explains. It is not physics."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import ClassVar

import numpy as np

from softhand_model.effects.effect import RUBBER, Parameter
from softhand_model.effects.stages import Array, ElasticEffect, Memory, SectionShape, Strain

KNOTS = (1.0, 1.05, 1.12, 1.22, 1.36, 1.55, 2.0, 3.0)  # stretches
GROWING = 0.9  # of the fall at which the elastic side would no longer grow
HIGHEST = 1.5  # of the logarithm of the factor between two knots


def _steepest_fall(low: float, high: float) -> float:
    """Fall of log(factor) between two stretches at which the elastic side just keeps growing.

    The slope of log(q) over log(lambda) falls with lambda; the mode in which it is least counts.
    """
    slopes = (
        (high + 3.0 * high**-3) / (high - high**-3),  # pure shear
        (high + 2.0 * high**-2) / (high - high**-2),  # uniaxial
        high / (high - 1.0),  # linear
    )
    return float(min(slopes) * np.log(high / low))


def _ramp(index: int, low: float, high: float) -> Parameter:
    fall = GROWING * _steepest_fall(low, high)
    return Parameter(
        f"a{index}",
        "",
        -round(fall, 3),
        HIGHEST,
        f"change of log(factor) from stretch {low:g} to {high:g}",
        typical=(-0.2, 0.2),
        neutral=0.0,
    )


class Discrepancy(ElasticEffect):
    """A generic term, not physics: factor exp(a1*r1 + ... + a7*r7) on the elastic side.

    Each r rises from 0 to 1 between two neighbours of the stretches 1, 1.05, 1.12, 1.22, 1.36,
    1.55, 2 and 3, in a straight line over log(lambda), and keeps its value beyond: between them the
    factor is a power of the stretch. It says how much stiffer or softer the actuator is than the
    model at which stretch, not why, and holds only for inputs like those that it was fitted to.
    What has not been stretched so far keeps the factor of the largest stretch that was. Bounds keep
    the elastic side growing.
    """

    name = "discrepancy"
    experiments = RUBBER
    physical = False
    parameters = tuple(_ramp(i + 1, *ends) for i, ends in enumerate(pairwise(KNOTS)))
    unseen_in: ClassVar[Mapping[str, str]] = {
        "valve_pulse": "no rubber is strained; the generic term of a pulse is pulse_bias",
    }

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] times the factor."""
        logarithm = np.log(strain.stretch)
        total: Array | float = 0.0
        for parameter, (low, high) in zip(self.parameters, pairwise(np.log(KNOTS)), strict=True):
            ramp = np.clip((logarithm - low) / (high - low), 0.0, 1.0)
            total = total + self.values[parameter.name] * ramp
        return np.asarray(stress * np.exp(total))
