"""Output effects: the reading of a sensor as a function of the true value; and a generic term for
an error that no effect explains.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import ClassVar

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_model.effects.effect import OUTPUT_UNIT, RUBBER, STRETCHED, Parameter
from softhand_model.effects.stages import (
    ElasticEffect,
    Memory,
    OutputEffect,
    SectionShape,
    Strain,
    lagged,
)
from softhand_model.effects.whole_runs import RunTimes, lagged_in_runs

ONE_SENSOR = STRETCHED | {"free_bending", "blocked_tip"}
THREE_SENSORS: Mapping[str, str] = {"base_torque": "three torques have three sensors"}
MEASURED = ("tip_angle", "tip_force", "stress")
KNOTS = (1.0, 1.05, 1.12, 1.22, 1.36, 1.55, 2.0, 3.0)  # stretches
GROWING = 0.9  # of the fall at which the elastic side would no longer grow
HIGHEST = 1.5  # of the logarithm of the factor between two knots


class _Offset(OutputEffect):
    """The sensor's zero is off: y_read = y + offset."""

    rank = 1

    def reading(self, value: Array, memory: Memory, dt: Array | float) -> Array:
        """Reading in the unit of the output."""
        return value + self.values["offset"]


class AngleOffset(_Offset):
    """The tip angle is read too large or too small by the same angle in all samples: y_read = y +
    offset.
    """

    name = "angle_offset"
    cause, member = "offset", "angle"
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


class ForceOffset(_Offset):
    """The force gauge reads too much or too little by the same force [N] in all samples:
    y_read = y + offset.
    """

    name = "force_offset"
    cause, member = "offset", "force"
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


class StressOffset(_Offset):
    """The load cell of a test of the rubber shows the same stress too much or too little in all
    samples, as when it was not tared: y_read = y + offset.
    """

    name = "stress_offset"
    cause, member = "offset", "stress"
    experiments = STRETCHED
    quantity = "stress"
    parameters = (
        Parameter(
            "offset",
            "Pa",
            -1e7,
            1e7,
            "reading without stress",
            (-1e4, 1e4),
            neutral=0.0,
            relative=("output", -0.1, 0.1),
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("free_bending", "blocked_tip"), "no stress is measured"
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "stretch_offset": "alike at small stretches, as far as the stress is proportional to them"
    }


class AngleGain(OutputEffect):
    """The scale of the angle's sensor is off: y_read = gain*y, before an offset.

    So read a bend sensor, or a camera that was calibrated with a wrong length.
    """

    name = "angle_gain"
    cause, member = "gain", "angle sensor"
    experiments = frozenset({"free_bending"})
    quantity = "tip_angle"
    parameters = (
        Parameter("gain", "", 0.2, 5.0, "reading over true value", (0.7, 1.4), neutral=1.0),
    )
    unseen_in: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("blocked_tip", "uniaxial", "rubber"), "no angle is measured"
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "modulus_scale": "alike at small angles",
        "coefficient": "one with it",
        "pressure_gain": "one with it as far as the angle is proportional to the pressure",
        "camera_perspective": "alike at small angles",
        "gent_stiffening": "both change the curve at large angles",
        "yeoh_stiffening": "both change the curve at large angles",
    }

    def reading(self, value: Array, memory: Memory, dt: Array | float) -> Array:
        """Reading [rad]."""
        return value * self.values["gain"]


class AngleSensorLag(OutputEffect):
    """The reading of the tip angle lags behind the tip: time_constant*y_read' = y - y_read.

    The cause may be a filter in the sensor or in the tracking of a camera. Exact for angles that
    are linear between samples.
    """

    name = "angle_sensor_lag"
    cause, member = "lag", "sensor"
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

    def in_runs(self, value: Array, times: RunTimes) -> Array:
        """Readings (lanes, rows, 1) through whole runs, as `reading` gives them step by step."""
        return lagged_in_runs(value, times, self.values["time_constant"])


class CameraPerspective(OutputEffect):
    """A camera looks at the finger at a slant: tan(y_read) = foreshortening*tan(y).

    The factor is the cosine of the camera's tilt across the straight finger; a tilt along it makes
    the factor larger than 1. An angle of 90 deg does not change; small angles change as with
    another modulus. The distance of the camera is ignored.
    """

    name = "camera_perspective"
    experiments = frozenset({"free_bending"})
    quantity = "tip_angle"
    parameters = (
        Parameter(
            "foreshortening",
            "",
            0.2,
            5.0,
            "size across the straight finger over that along it, as seen",
            (0.6, 1.6),
            logarithmic=True,
            neutral=1.0,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("blocked_tip", *sorted(STRETCHED)), "no angle is measured"
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "modulus_scale": "alike at small angles",
        "yeoh_stiffening": "both change the curve at large angles",
        "gent_stiffening": "both change the curve at large angles",
    }
    rank = -1

    def reading(self, value: Array, memory: Memory, dt: Array | float) -> Array:
        """Angle [rad] as the camera sees it."""
        turns = np.round(value / np.pi)
        within = value - np.pi * turns
        factor = self.values["foreshortening"]
        return np.pi * turns + np.arctan2(factor * np.sin(within), np.cos(within))


class SensorDrift(OutputEffect):
    """The zero of the output's sensor drifts: y_read = y + per_run*n + rate*tau*(1 - exp(-t/tau)).

    tau is settling_time, t [s] the time since the start of the run, and n the number of earlier
    runs of the session. A steady drift has a tau much longer than the runs; for a sensor that is
    tared before each run, per_run is 0. In simulator and monitor, n is 0 and t counts from their
    reset.
    """

    name = "sensor_drift"
    cause, member = "drift", "sensor"
    experiments = ONE_SENSOR
    quantity = MEASURED
    axes = ("session",)
    fewest_runs = 2
    parameters = (
        Parameter(
            "rate",
            f"{OUTPUT_UNIT}/s",
            -1e6,
            1e6,
            "drift at a run's start",
            (-0.01, 0.01),
            neutral=0.0,
            relative=("output", -0.02, 0.02),
        ),
        Parameter(
            "settling_time",
            "s",
            0.05,
            1e6,
            "time in which it comes to rest",
            (3.0, 100.0),
            logarithmic=True,
        ),
        Parameter(
            "per_run",
            OUTPUT_UNIT,
            -1e6,
            1e6,
            "drift from run to run",
            (-0.01, 0.01),
            neutral=0.0,
            relative=("output", -0.01, 0.01),
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = THREE_SENSORS
    confounded_with: ClassVar[Mapping[str, str]] = {
        "angle_offset": "one with it where it has come to rest at once",
        "force_offset": "one with it where it has come to rest at once",
        "ageing": "alike where outputs hardly differ",
        "creep": "alike under constant load",
    }
    has_memory = True
    rank = 2

    def reading(self, value: Array, memory: Memory, dt: Array | float) -> Array:
        """Reading in the unit of the output; the drift within a run begins with its first
        sample.
        """
        elapsed = memory["elapsed"] + dt if "elapsed" in memory else 0.0 * np.asarray(dt)
        memory["elapsed"] = elapsed
        return self._drifted(value, elapsed)

    def in_runs(self, value: Array, times: RunTimes) -> Array:
        """Readings (lanes, rows, 1) through whole runs, as `reading` gives them step by step."""
        return self._drifted(value, times.elapsed())

    def _drifted(self, value: Array, elapsed: Array) -> Array:
        """Reading so long [s] after the run began."""
        settling = self.values["settling_time"]
        within = -self.values["rate"] * settling * np.expm1(-elapsed / settling)
        return np.asarray(value + within + self.values["per_run"] * self.around.get("session", 0.0))


class Saturation(OutputEffect):
    """The sensor of the output saturates at a limit: y_read = min(y, limit)."""

    name = "saturation"
    experiments = ONE_SENSOR
    quantity = MEASURED
    parameters = (
        Parameter(
            "limit",
            OUTPUT_UNIT,
            1e-6,
            1e9,
            "largest reading",
            (0.1, 10.0),
            logarithmic=True,
            relative=("output", 0.6, 1.0),
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = THREE_SENSORS
    confounded_with: ClassVar[Mapping[str, str]] = {
        "gent_stiffening": "both level the curve off, that one smoothly"
    }
    rank = 3

    def reading(self, value: Array, memory: Memory, dt: Array | float) -> Array:
        """Reading in the unit of the output."""
        return np.minimum(value, self.values["limit"])


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
    """A generic term, not physics: factor exp(a1*r1 + ... + a7*r7) on the elastic stress.

    Each r rises from 0 to 1, linear in log(lambda), between two neighbours of the stretches 1,
    1.05, 1.12, 1.22, 1.36, 1.55, 2 and 3. The factor says at which stretch the actuator is stiffer
    or softer than the model, not why, and holds only for inputs like those of the fit. Beyond the
    stretches that occurred, the factor is that of the largest one. Bounds ensure that the stress
    rises with the stretch.
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
        """Stress [-] (over the shear modulus) times the factor."""
        logarithm = np.log(strain.stretch)
        total: Array | float = 0.0
        for parameter, (low, high) in zip(self.parameters, pairwise(np.log(KNOTS)), strict=True):
            ramp = np.clip((logarithm - low) / (high - low), 0.0, 1.0)
            total = total + self.values[parameter.name] * ramp
        return np.asarray(stress * np.exp(total))
