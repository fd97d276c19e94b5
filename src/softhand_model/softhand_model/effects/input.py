"""Input effects: which pressure acts in the chamber, or which stretch in a strip, given the reading
of its sensor.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_model.effects.effect import (
    BENDING,
    NO_PRESSURE,
    POSED,
    STRETCHED,
    Parameter,
    unseen_when_stretched,
)
from softhand_model.effects.stages import InputEffect, Memory, lagged
from softhand_model.effects.whole_runs import RunTimes, lagged_in_runs


class PressureOffset(InputEffect):
    """The pressure sensor's zero is off: p_read = p + offset.

    With `pressure_gain`: p_read = gain*p + offset, so the offset is subtracted from the reading
    first.
    """

    name = "pressure_offset"
    cause, member = "offset", "pressure"
    experiments = BENDING | POSED
    parameters = (
        Parameter("offset", "Pa", -50e3, 50e3, "reading at no pressure", (-4e3, 4e3), neutral=0.0),
    )
    unseen_in: ClassVar[Mapping[str, str]] = NO_PRESSURE
    confounded_with: ClassVar[Mapping[str, str]] = {
        "angle_offset": "alike in free bending as far as the curve is straight",
        "force_offset": "one with it in a blocked tip as far as the force is proportional to p",
        "dead_zone": "alike where no reading lies below the threshold",
    }
    rank = 0

    def chamber_pressure(self, pressure: Array, memory: Memory, dt: Array | float) -> Array:
        """Pressure [Pa] in the chamber."""
        return pressure - self.values["offset"]


class StretchOffset(InputEffect):
    """The stretch of a test of the rubber is not 1 where the rubber is free: lambda_read = lambda +
    offset.

    A strip that was clamped slack has a positive offset, and bears nothing until it is taut; one
    that was clamped under tension has a negative one.
    """

    name = "stretch_offset"
    cause, member = "offset", "stretch"
    experiments = STRETCHED
    parameters = (
        Parameter(
            "offset",
            "",
            -0.5,
            0.5,
            "reading, less 1, at which the rubber becomes taut",
            (-0.06, 0.06),
            neutral=0.0,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = dict.fromkeys(
        sorted(BENDING), "no stretch is measured"
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "modulus_scale": "alike at large stretches, where the stress grows in proportion"
    }

    def imposed_stretch(self, stretch: Array) -> Array:
        """Stretch [-] of the rubber; a slack strip carries no load."""
        return np.maximum(stretch - self.values["offset"], np.minimum(stretch, 1.0))


class PressureGain(InputEffect):
    """The pressure sensor's scale is off: p_read = gain*p (after `pressure_offset`).

    Bending depends on p/G. So there it only shows as far as the calibration of G cannot imitate it;
    in forces of a blocked tip it always shows, and is one with the scale of the force gauge.
    """

    name = "pressure_gain"
    cause, member = "gain", "pressure sensor"
    experiments = BENDING | POSED
    parameters = (
        Parameter("gain", "", 0.2, 5.0, "reading over pressure", (0.7, 1.4), neutral=1.0),
    )
    unseen_in: ClassVar[Mapping[str, str]] = NO_PRESSURE
    confounded_with: ClassVar[Mapping[str, str]] = {
        "modulus_scale": "one with the shear modulus in free bending, where only p/G acts",
        "coefficient": "one with it",
        "passive_layer_slack": "one with its ratio at small loads of a blocked tip",
    }
    rank = 1

    def chamber_pressure(self, pressure: Array, memory: Memory, dt: Array | float) -> Array:
        """Pressure [Pa] in the chamber."""
        return pressure / self.values["gain"]


class TubeLag(InputEffect):
    """The chamber follows the sensor through the tube: time_constant*p' = p_read - p.

    It is of first order, a simple form of the flow (`pneumatics.plant`), and exact for readings
    that are linear between samples.
    """

    name = "tube_lag"
    cause, member = "lag", "tube"
    experiments = BENDING
    parameters = (
        Parameter(
            "time_constant",
            "s",
            1e-4,
            100.0,
            "time in which the chamber follows",
            (0.02, 1.0),
            logarithmic=True,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = NO_PRESSURE
    confounded_with: ClassVar[Mapping[str, str]] = {
        "angle_sensor_lag": "a lag of the output instead: where the curve is straight they are one",
        "viscoelasticity": "alike on triangles of one rate",
        "hysteresis": "alike on triangles of one rate",
    }
    has_memory = True
    rank = 2

    def chamber_pressure(self, pressure: Array, memory: Memory, dt: Array | float) -> Array:
        """Pressure [Pa] in the chamber."""
        return lagged(pressure, memory, dt, self.values["time_constant"])

    def in_runs(self, pressure: Array, times: RunTimes) -> Array:
        """Pressure (lanes, rows, 1) [Pa] in the chamber through whole runs, as `chamber_pressure`
        gives it step by step.
        """
        return lagged_in_runs(pressure, times, self.values["time_constant"])


class GrowingChamberLag(InputEffect):
    """The chamber follows the sensor through the tube, and the more slowly the more it has grown:
    time_constant*(1 + max(p, 0)/doubling_pressure)*p' = p_read - p.

    The mass flow through a tube fills a volume, which grows with the pressure as the actuator
    bends. A step is computed with the time constant at its middle.
    """

    name = "growing_chamber_lag"
    cause, member = "lag", "tube with a growing chamber"
    experiments = BENDING
    parameters = (
        *TubeLag.parameters,
        Parameter(
            "doubling_pressure",
            "Pa",
            1e3,
            1e7,
            "pressure at which the chamber follows half as fast",
            (10e3, 200e3),
            logarithmic=True,
            relative=("pressure", 0.3, 5.0),
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = NO_PRESSURE
    refines = ("tube_lag", "angle_sensor_lag")
    has_memory = True
    rank = 2

    def chamber_pressure(self, pressure: Array, memory: Memory, dt: Array | float) -> Array:
        """Pressure [Pa] in the chamber."""
        before, _ = memory.get("state", (0.0, 0.0))
        guess = lagged(pressure, dict(memory), dt, self._constant(before))
        return lagged(pressure, memory, dt, self._constant((before + guess) / 2.0))

    def _constant(self, pressure: Array | float) -> Array:
        """Time constant [s] at a chamber pressure [Pa]."""
        grown = 1.0 + np.maximum(pressure, 0.0) / self.values["doubling_pressure"]
        return np.asarray(self.values["time_constant"] * grown)

    def in_runs(self, pressure: Array, times: RunTimes) -> Array:
        """Pressure (lanes, rows, 1) [Pa] in the chamber through whole runs, as `chamber_pressure`
        gives it step by step.
        """
        constant, doubling = self.values["time_constant"], self.values["doubling_pressure"]
        return lagged_in_runs(pressure, times, constant, doubling)


class DeadZone(InputEffect):
    """Pressure up to a threshold has no effect: p -> max(0, p - threshold)."""

    name = "dead_zone"
    cause, member = "offset", "dead zone"
    experiments = BENDING | POSED
    parameters = (
        Parameter(
            "threshold",
            "Pa",
            0.0,
            100e3,
            "pressure from which the actuator moves",
            (500.0, 10e3),
            neutral=0.0,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = NO_PRESSURE
    confounded_with: ClassVar[Mapping[str, str]] = {
        "pressure_offset": "alike where no reading lies below the threshold",
        "section_rounding": "alike at low pressure, which it weakens smoothly",
    }
    rank = 3

    def chamber_pressure(self, pressure: Array, memory: Memory, dt: Array | float) -> Array:
        """Pressure [Pa] that has an effect."""
        return np.maximum(pressure - self.values["threshold"], 0.0)


class ClockOffset(InputEffect):
    """Output and pressure were recorded by two clocks: the output at time t belongs to the pressure
    p(t - delay), with delay = offset + drift*(t - start of the run).

    A video that runs 0.3 s late has an offset of 0.3 s. Between samples the pressure is
    interpolated; a run that does not start steady is taken to have been at 0 before.
    """

    name = "clock_offset"
    cause, member = "lag", "clock"
    experiments = frozenset({"free_bending", "blocked_tip"})
    parameters = (
        Parameter(
            "offset", "s", -10.0, 10.0, "time by which the output is late", (-0.5, 0.5), neutral=0.0
        ),
        Parameter(
            "drift", "", -0.3, 0.3, "by which it comes later, a second", (-0.05, 0.05), neutral=0.0
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = {
        **unseen_when_stretched("a testing machine has one clock for stretch and stress"),
        "base_torque": "pressure, pose and torque have three clocks",
    }
    confounded_with: ClassVar[Mapping[str, str]] = {
        "tube_lag": "a lag that rounds corners instead: alike on slow ramps",
        "angle_sensor_lag": "a lag that rounds corners instead: alike on slow ramps",
        "viscoelasticity": "alike on triangles of one rate",
        "hysteresis": "alike on triangles of one rate",
    }
    has_memory = True
    stands_for = ("tube_lag", "angle_sensor_lag")  # of second order they delay a ramp as a whole
    rank = -1
    not_simulated = "it parts two clocks of a recording, and a simulated hand has one"

    def delay(self, elapsed: Array) -> Array | float:
        """Delay [s] of the output at times `elapsed` [s] since the start of the run."""
        return self.values["offset"] + self.values["drift"] * elapsed
