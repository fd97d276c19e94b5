"""Measurements of the lab story: plateaus of pressure in a finger, as setpoints of air mass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from softhand_model.gas import AMBIENT_PRESSURE, air_mass
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.hand import load_hand

RIG_HAND = "single_finger"
FINGER = "finger"  # chain and actuator of that hand
STATE_NAME, ANGLES, RESIDUAL = "/pneumaticbox/state", "/hand/tip_angles", "/model/residual"
RISE_TIME = 0.2  # from plateau to plateau [s], which the valves need


@dataclass(frozen=True)
class Measurement:
    """A protocol: a sequence of gauge pressures [Pa], each held for `hold` [s].

    Plateaus are used in place of ramps: the simulated finger lags its pressure by 10 ms and swings
    after each valve pulse, which the lab's model does not describe. At constant pressure neither
    matters, but effects with memory are still seen, as a finger creeps at constant pressure.
    """

    protocol: str
    levels: Sequence[float]
    hold: float

    @property
    def duration(self) -> float:
        """Duration of the protocol [s]."""
        return len(self.levels) * self.hold


@dataclass(frozen=True)
class PlayedRun:
    """A completed run: name, protocol, start and end in simulated time [s]."""

    name: str
    protocol: str
    start: float
    end: float


def finger() -> Actuator:
    """The actuator on the simulated rig."""
    return load_hand(RIG_HAND).chain(FINGER).actuators[FINGER]


@dataclass(frozen=True)
class Plan:
    """Measurements of a session, carried out one after the other, all of them `repeats` times, each
    after a `rest` [s] with open outlets.
    """

    measurements: Sequence[Measurement]
    repeats: int = 2
    rest: float = 6.0


STAIRCASE = Measurement("staircase", (8e3, 15e3, 23e3, 30e3, 18e3, 9e3, 0.0), 1.2)
LOOPS = Measurement("loops", (18e3, 12e3, 18e3, 12e3, 24e3, 18e3, 28e3, 0.0), 1.0)
FULL_PLAN = Plan(
    (
        STAIRCASE,
        Measurement("step_and_hold", (26e3, 0.0), 4.0),
        LOOPS,
        Measurement("two_steps", (14e3, 29e3, 0.0), 2.7),
    )
)
CHECK_PLAN = Plan((STAIRCASE, LOOPS), repeats=1)


def air_mass_setpoints(actuator: Actuator, measurement: Measurement) -> list[tuple[float, float]]:
    """Pairs of time [s] and air mass [kg above rest] of a measurement, to be interpolated linearly.

    The masses are those of the base model in free bending; further effects change the pressure a
    little, but the pressure is measured.
    """
    points, before = [], 0.0
    for index, level in enumerate(measurement.levels):
        begin, mass = index * measurement.hold, enclosed_air(actuator, level)
        points += [(begin, before), (begin + RISE_TIME, mass)]
        before = mass
    return points


def enclosed_air(actuator: Actuator, pressure: float) -> float:
    """Air mass in chamber and tube [kg above that at ambient pressure] at a gauge pressure [Pa], in
    free bending.

    >>> from softhand_model.hand.actuator import load_actuator
    >>> round(1e6 * enclosed_air(load_actuator("P10.finger"), 30e3), 1)
    15.6
    """
    x, weight = actuator.quadrature()
    rest = actuator.chamber_volume() + actuator.supply_volume
    bend = weight * actuator.free_curvature(pressure, x)
    volume = rest + float(np.sum(bend * actuator.chamber_volume_gain(x)))
    held = air_mass(AMBIENT_PRESSURE + pressure, volume) - air_mass(AMBIENT_PRESSURE, rest)
    return float(held)
