"""Measurements of the story: a finger brought to plateaus of pressure, as courses of air mass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from softhand_model.gas import AMBIENT_PRESSURE, air_mass
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.hand import load_hand

HAND = "single_finger"
FINGER = "finger"  # chain and actuator of that hand
STATE, ANGLES, RESIDUAL = "/pneumaticbox/state", "/hand/tip_angles", "/model/residual"
RISE = 0.2  # from plateau to plateau [s]; the valves take as long


@dataclass(frozen=True)
class Measurement:
    """A protocol: gauge pressures [Pa] one after the other, each held for so long [s].

    Plateaus, not ramps: the finger of the simulator lags 10 ms behind its pressure and swings after
    each pulse of the valves, which the lab's model leaves out. Where the pressure stands, neither
    shows, and what remembers still does: a finger creeps while it is held.
    """

    protocol: str
    levels: Sequence[float]
    hold: float

    @property
    def duration(self) -> float:
        """How long it takes [s]."""
        return len(self.levels) * self.hold


@dataclass(frozen=True)
class Played:
    """A run as it was played: name, protocol, start and end in simulated time [s]."""

    name: str
    protocol: str
    start: float
    end: float


def finger() -> Actuator:
    """The actuator on the bench."""
    return load_hand(HAND).chain(FINGER).actuators[FINGER]


@dataclass(frozen=True)
class Plan:
    """What a session plays: measurements in turn, so often, after a rest [s] with open outlets."""

    measurements: Sequence[Measurement]
    repeats: int = 2
    rest: float = 6.0


STAIRCASE = Measurement("staircase", (8e3, 15e3, 23e3, 30e3, 18e3, 9e3, 0.0), 1.2)
LOOPS = Measurement("loops", (18e3, 12e3, 18e3, 12e3, 24e3, 18e3, 28e3, 0.0), 1.0)
WHOLE = Plan(
    (
        STAIRCASE,
        Measurement("step_and_hold", (26e3, 0.0), 4.0),
        LOOPS,
        Measurement("two_steps", (14e3, 29e3, 0.0), 2.7),
    )
)
CHECK = Plan((STAIRCASE, LOOPS), repeats=1)


def air_course(actuator: Actuator, measurement: Measurement) -> list[tuple[float, float]]:
    """Times [s] and air masses [kg above rest], straight lines between, of a measurement.

    The mass is that of the base model bending freely; what else acts moves the pressure a little,
    which is measured.
    """
    points, before = [], 0.0
    for index, level in enumerate(measurement.levels):
        begin, mass = index * measurement.hold, enclosed_air(actuator, level)
        points += [(begin, before), (begin + RISE, mass)]
        before = mass
    return points


def enclosed_air(actuator: Actuator, pressure: float) -> float:
    """Air mass [kg above rest at ambient] in chamber and tube at a gauge pressure [Pa], bending
    freely.

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
