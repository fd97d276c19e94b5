"""What is measured: pressure protocols of a finger as courses of air mass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model_lab.protocols import protocol
from softhand_model.actuator import Actuator
from softhand_model.gas import AMBIENT_PRESSURE, air_mass

SPACING = 0.1  # [s] between points of a course


@dataclass(frozen=True)
class Measurement:
    """A protocol of the lab's bank, how long it takes [s] and up to which gauge pressure [Pa].

    All leave the finger time to settle between pulses of the valves: the lab's model has no
    inertia.
    """

    protocol: str
    duration: float
    peak: float = 30e3


@dataclass(frozen=True)
class Plan:
    """What a session plays: measurements, repeated in turn, with a rest [s] between two so that
    memory fades.
    """

    measurements: Sequence[Measurement]
    repeats: int = 2
    rest: float = 5.0


WHOLE = Plan(
    (
        Measurement("slow_ramp", 8.0),
        Measurement("step_and_hold", 6.0, 25e3),
        Measurement("staircase", 9.0),
        Measurement("small_loops", 9.0, 28e3),
    )
)
CHECK = Plan((Measurement("staircase", 9.0), Measurement("small_loops", 9.0, 28e3)), repeats=1)


def air_course(actuator: Actuator, measurement: Measurement) -> list[tuple[float, float]]:
    """Times [s] and air masses [kg above rest] of an actuator that is driven through a protocol.

    The mass is that of the base model bending freely; what else acts moves the pressure a little,
    which is measured.
    """
    points = round(measurement.duration / SPACING) + 1
    course = protocol(measurement.protocol).course(measurement.duration, measurement.peak, points)
    return [(float(t), enclosed_air(actuator, float(p))) for t, p in zip(*course, strict=True)]


def enclosed_air(actuator: Actuator, pressure: float) -> float:
    """Air mass [kg above rest at ambient] in chamber and tube at a gauge pressure [Pa], bending
    freely.

    >>> from softhand_model.actuator import load_actuator
    >>> round(1e6 * enclosed_air(load_actuator("P10.finger"), 30e3), 1)
    18.3
    """
    x, weight = actuator.quadrature()
    rest = actuator.chamber_volume() + actuator.supply_volume
    bend = weight * actuator.free_curvature(pressure, x)
    volume = rest + float(np.sum(bend * actuator.chamber_volume_gain(x)))
    held = air_mass(AMBIENT_PRESSURE + pressure, volume) - air_mass(AMBIENT_PRESSURE, rest)
    return float(held)
