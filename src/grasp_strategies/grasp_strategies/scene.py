"""The contract between a strategy and the place where it runs.

A strategy commands the wrist and the air, lets time pass and observes; it never learns whether
physics is computed in the same process or beyond ROS topics. Units are SI, poses are in the frame
`world` (z up), quaternions (x, y, z, w).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from grasp_strategies.pose import Pose

Array = NDArray[np.float64]

PALM_PLATE = "palm_plate"  # name in contacts of the rigid part of a hand


class SceneError(RuntimeError):
    """The scene cannot go on: a topic fell silent, time stands still, the simulation diverged."""


@dataclass(frozen=True)
class Observation:
    """What a strategy may know at one instant.

    `time` [s] of the scene; wrist and object pose in `world` [m]; `wrist_force` (3,) [N] of the
    hand on the wrist in world axes; `air_mass` [kg above the fill at rest and ambient] and
    `pressure` [Pa gauge] per channel, in the order of `Scene.channels`; `touching`: names of the
    bodies that press on the object.
    """

    time: float
    wrist_position: Array
    wrist_orientation: Array
    wrist_force: Array
    object_position: Array
    object_orientation: Array
    air_mass: Array
    pressure: Array
    touching: frozenset[str]

    @property
    def wrist(self) -> Pose:
        """Pose of the wrist in the world."""
        return Pose(self.wrist_position, self.wrist_orientation)

    @property
    def object_in_wrist(self) -> Array:
        """Position of the object in the wrist frame (3,) [m]: constant while the hand holds it."""
        return self.wrist.locate(self.object_position)


class Scene(Protocol):
    """Where a strategy runs. Commands hold until the next one; nothing moves but in `step`."""

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the air channels, in the order of all arrays."""

    @property
    def hand_bodies(self) -> frozenset[str]:
        """Names in `Observation.touching` that are parts of the hand; others surround it."""

    @property
    def time(self) -> float:
        """Time of the scene [s]; simulated time in a simulation, at whatever speed it runs."""

    def command_wrist(self, position: Array, orientation: Array) -> None:
        """Set the target pose of the wrist: position (3,) [m], quaternion (4,)."""

    def command_air(self, masses: Array) -> None:
        """Set the target air masses (channels,) [kg above the fill at rest and ambient]; NaN for a
        channel that keeps the command it has.
        """

    def command_pressure(self, pressures: Array) -> None:
        """Set the gauge pressures (channels,) [Pa] to reach and to keep, whatever air that takes;
        NaN for a channel that keeps the command it has. A channel obeys the last of its commands,
        be it of a mass or of a pressure.
        """

    def hold_object(self, position: Array, orientation: Array) -> None:
        """Put the object at a pose in the wrist frame, position (3,) [m] and quaternion (4,), and
        have a spring hold it there until it is released; raises SceneError where nobody can.
        """

    def release_object(self, duration: float) -> None:
        """Let the spring that holds the object fade within a duration [s]."""

    def vent(self) -> None:
        """Open every outlet; raises SceneError when it cannot be known that this happened."""

    def step(self, duration: float) -> None:
        """Let `duration` [s] of scene time pass, less when interrupted.

        Raises SceneError when time cannot go on.
        """

    def observe(self) -> Observation:
        """Return the state now; raises SceneError when a part of it is missing."""


class AirTarget(NamedTuple):
    """What the channels shall contain: air `masses` (channels,) [kg above the fill at rest and
    ambient] or gauge `pressures` (channels,) [Pa], NaN where the other is commanded.
    """

    masses: Array
    pressures: Array

    def changed(
        self, masses: Mapping[str, float], pressures: Mapping[str, float], channels: tuple[str, ...]
    ) -> AirTarget:
        """The same with other commands for some of the channels.

        >>> target = AirTarget(np.array([1e-5, 2e-5]), np.full(2, np.nan))
        >>> target.changed({}, {"b": 2e3}, ("a", "b")).pressures.tolist()
        [nan, 2000.0]
        """
        found = AirTarget(self.masses.copy(), self.pressures.copy())
        for commands, own, other in ((masses, *found), (pressures, *found[::-1])):
            for name, value in commands.items():
                own[channels.index(name)], other[channels.index(name)] = value, np.nan
        return found

    def start(self, goal: AirTarget, seen: Observation) -> AirTarget:
        """Where a ramp to `goal` begins: at this target, and where it commands the other quantity
        at what is seen.
        """
        measured = (seen.air_mass, seen.pressure)
        parts = (
            np.where(np.isnan(wanted), np.nan, np.where(np.isnan(own), found, own))
            for own, wanted, found in zip(self, goal, measured, strict=True)
        )
        return AirTarget(*parts)

    def towards(self, goal: AirTarget, share: float) -> AirTarget:
        """The target a share of the way to `goal`, a target of the same quantities."""
        return AirTarget(*(a + share * (b - a) for a, b in zip(self, goal, strict=True)))


def hand_body_names(chains: Iterable[str]) -> frozenset[str]:
    """Names in contacts that are parts of a hand with these chains."""
    return frozenset(chains) | {PALM_PLATE}
