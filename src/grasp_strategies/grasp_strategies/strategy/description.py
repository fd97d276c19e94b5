"""A grasp strategy as data: phases of wrist motion and air; `reading` tells of its file."""

from __future__ import annotations

import math
from dataclasses import dataclass

from grasp_strategies.strategy.tried_with import TriedWith

FORMAT = "softhand-strategy/1"
QUANTITIES = {
    "contact_force": "N",
    "height": "m",
    "air_mass_error": "kg",
    "pressure_error": "Pa",
    "pressure": "Pa",
}

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


@dataclass(frozen=True)
class Waypoint:
    """Where the point `pivot` [m] of the wrist's axes goes: `position` [m] and, for the whole
    wrist, `rpy` [rad], None to keep it, in a frame.
    """

    frame: str
    position: Vector
    rpy: Vector | None
    pivot: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class HeldOut:
    """Where the object is held out to the hand: position [m], quaternion (x, y, z, w), in the wrist
    frame.
    """

    position: Vector
    orientation: Quaternion


@dataclass(frozen=True)
class Condition:
    """An end condition: a quantity above or below a threshold in the quantity's unit."""

    quantity: str
    above: bool
    threshold: float

    def holds(self, value: float) -> bool:
        """Whether a value of the quantity fulfils the condition.

        >>> Condition("contact_force", above=True, threshold=2.0).holds(2.5)
        True
        """
        return value > self.threshold if self.above else value < self.threshold

    def __str__(self) -> str:
        relation = "above" if self.above else "below"
        return f"{self.quantity} {relation} {self.threshold:g} {QUANTITIES[self.quantity]}"


@dataclass(frozen=True)
class Phase:
    """One phase: times [s], speeds [m/s] and [rad/s], air masses [kg], gauge pressures [Pa]; see
    `reading`. `held_out` is where the object is held from its beginning on, `release` the
    time in which it is let go.
    """

    name: str
    wrist: Waypoint | None
    speed: float | None
    turn_speed: float
    duration: float | None
    air_mass: dict[str, float]
    pressure: dict[str, float]
    air_ramp: float
    until: tuple[Condition, ...]
    until_touching: frozenset[str]
    time_out: float | None
    next_on_time_out: bool
    option: str | None
    held_out: HeldOut | None = None
    release: float | None = None

    @property
    def conditional(self) -> bool:
        """Whether a condition ends it, rather than the end of motion, ramp and duration."""
        return bool(self.until or self.until_touching)


@dataclass(frozen=True)
class Success:
    """When a grasp counts: least lift [m] and hold [s], the phase to judge, largest slip [m] and
    largest turn [rad] of the object in the hand.
    """

    lift_height: float = 0.100
    hold_time: float = 1.0
    hold_phase: str = "hold"
    max_slip: float = 0.010
    max_turn: float = math.radians(20.0)


@dataclass(frozen=True)
class Strategy:
    """A strategy: its name, what it is for, the hand it was written for (by name, or by the path of
    its file), the objects that it is known to lift, its phases in order, and the world in which it
    was tried.
    """

    name: str
    description: str
    hand: str
    object_rpy: Vector | None
    objects: tuple[str, ...]
    success: Success
    phases: tuple[Phase, ...]
    tried_with: TriedWith

    @property
    def options(self) -> frozenset[str]:
        """Names of the options that switch phases on."""
        return frozenset(phase.option for phase in self.phases if phase.option)

    @property
    def holds_object_out(self) -> bool:
        """Whether the object is held out to the hand: then it has to be one of `objects`."""
        return any(phase.held_out is not None for phase in self.phases)
