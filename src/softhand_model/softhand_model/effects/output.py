"""Output effects, what the sensor shows; and a generic term for what no effect explains."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import ClassVar

import numpy as np

from softhand_model.effects.effect import RUBBER, Parameter
from softhand_model.effects.stages import (
    ElasticEffect,
    Memory,
    OutputEffect,
    SectionShape,
    Strain,
    lagged,
)
from softhand_model.numerics.arrays import Array

KNOTS = (1.0, 1.05, 1.12, 1.22, 1.36, 1.55, 2.0, 3.0)  # stretches
GROWING = 0.9  # of the fall at which the elastic side would no longer grow
HIGHEST = 1.5  # of the logarithm of the factor between two knots


class AngleOffset(OutputEffect):
    """The tip's angle reads too much or too little everywhere: y_read = y + offset."""

    name = "angle_offset"
    experiments = frozenset({"free_bending"})
    quantity = "tip_angle"
    parameters = (
        Parameter(
            "offset", "rad", -1.5, 1.5, "reading of a straight finger", (-0.15, 0.15), neutral=0.0
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("blocked_tip", "uniaxial", "rubber"), "no angle is measured"
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "pressure_offset": "alike as far as the curve is straight"
    }
    rank = 1

    def reading(self, value: Array, memory: Memory, dt: Array | float) -> Array:
        """Reading [rad]."""
        return value + self.values["offset"]


class ForceOffset(OutputEffect):
    """The gauge reads too much or too little everywhere: y_read = y + offset."""

    name = "force_offset"
    experiments = frozenset({"blocked_tip"})
    quantity = "tip_force"
    parameters = (
        Parameter("offset", "N", -10.0, 10.0, "reading without force", (-0.15, 0.15), neutral=0.0),
    )
    unseen_in: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("free_bending", "uniaxial", "rubber"), "no force is measured"
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "pressure_offset": "one with it as far as the force is proportional to the pressure"
    }
    rank = 1

    def reading(self, value: Array, memory: Memory, dt: Array | float) -> Array:
        """Reading [N]."""
        return value + self.values["offset"]


class AngleSensorLag(OutputEffect):
    """The angle's reading follows the tip: time_constant*y_read' = y - y_read.

    A filter in the sensor or in the camera's tracking; exact for angles that change in a straight
    line between samples.
    """

    name = "angle_sensor_lag"
    experiments = frozenset({"free_bending"})
    quantity = "tip_angle"
    parameters = (
        Parameter(
            "time_constant",
            "s",
            1e-4,
            100.0,
            "time in which the reading follows",
            (0.02, 1.0),
            logarithmic=True,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("blocked_tip", "uniaxial", "rubber"), "no angle is measured"
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "tube_lag": "a lag of the input instead: where the curve is straight they are one",
        "viscoelasticity": "alike on triangles of one rate",
    }
    has_memory = True

    def reading(self, value: Array, memory: Memory, dt: Array | float) -> Array:
        """Reading [rad]."""
        return lagged(value, memory, dt, self.values["time_constant"])


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
        (-0.2, 0.2),
        neutral=0.0,
    )


class Discrepancy(ElasticEffect):
    """A generic term, not physics: factor exp(a1*r1 + ... + a7*r7) on the elastic side.

    Each r rises from 0 to 1 between two neighbours of the stretches 1, 1.05, 1.12, 1.22, 1.36,
    1.55, 2 and 3, in a straight line over log(lambda), and keeps its value beyond: between them the
    factor is a power of the stretch. It says how much stiffer or softer the actuator is than the
    model at which stretch, not why, and holds only for inputs like those that it was fitted to.
    What has not been stretched so far keeps the factor of the largest stretch that was. Bounds keep
    the elastic side growing (but for the largest ones in equibiaxial tension, where nothing is solved).
    """

    name = "discrepancy"
    experiments = RUBBER
    physical = False
    parameters = tuple(_ramp(i + 1, *ends) for i, ends in enumerate(pairwise(KNOTS)))
    unseen_in: ClassVar[Mapping[str, str]] = {
        "valve_pulse": "no rubber is strained; the generic term of a pulse is pulse_bias"
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
