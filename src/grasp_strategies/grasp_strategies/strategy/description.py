"""A grasp strategy as data: phases of wrist motion and air. The file format is described in
`reading`.
"""

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
    """Goal of a wrist motion: where the point `pivot` (3,) [m] of the wrist frame moves, as
    `position` (3,) [m] in a `frame`. `rpy` (3,) [rad] is the goal orientation of the wrist; None
    keeps it.
    """

    frame: str
    position: Vector
    rpy: Vector | None
    pivot: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class HeldOut:
    """Pose in the wrist frame at which the object is held in front of the hand: position (3,) [m],
    quaternion (x, y, z, w).
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
    """One phase of a strategy; its keys are described in `reading`.

    Times are in [s], speeds in [m/s] and [rad/s], air masses in [kg], gauge pressures in [Pa].
    `held_out` is the pose at which the object is held from the beginning of the phase, `release`
    the time in which the holding spring fades.
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
        """Whether a condition ends the phase, rather than the end of motion, ramp and duration."""
        return bool(self.until or self.until_touching)


@dataclass(frozen=True)
class Success:
    """Criteria of success: least lift [m], least hold time [s], name of the hold phase, largest
    slip [m] and largest turn [rad] of the object in the hand.
    """

    lift_height: float = 0.100
    hold_time: float = 1.0
    hold_phase: str = "hold"
    max_slip: float = 0.010
    max_turn: float = math.radians(20.0)


@dataclass(frozen=True)
class Strategy:
    """A strategy: phases that the hand carries out in order.

    description: what the strategy is for. hand: name of the hand, or path of its file. object_rpy:
    orientation of the object [rad] in which the axes of the frame `object` are those of the world.
    objects: the objects that the strategy is known to lift. success: when a grasp counts.
    tried_with: the world in which the strategy was tried.
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
        """Whether the object is held in front of the hand; then it must be one of `objects`."""
        return any(phase.held_out is not None for phase in self.phases)
