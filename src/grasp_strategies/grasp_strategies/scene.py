"""The interface between a strategy and the scene in which it runs.

A strategy commands wrist and air, lets time pass and observes. It does not depend on whether the
physics is computed in the same process or behind ROS topics. Units are SI, poses are in the frame
`world` (z up), quaternions are (x, y, z, w).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from grasp_strategies.pose import Pose
from softhand_common.numerics.arrays import Array

PALM_PLATE = "palm_plate"  # name in contacts of the rigid part of a hand


class SceneError(RuntimeError):
    """The scene cannot go on: a topic has no messages, time stands still, the simulation
    diverged.
    """


@dataclass(frozen=True)
class Observation:
    """The state of the scene at one instant.

    Attributes:
        time: time of the scene [s].
        wrist_position, object_position: (3,) [m] in `world`.
        wrist_orientation, object_orientation: quaternions (4,) in `world`.
        wrist_force: (3,) [N] of the hand on the wrist, in world axes.
        air_mass: (channels,) [kg above the fill at rest and ambient pressure].
        pressure: (channels,) [Pa], gauge.
        touching: names of the bodies that press on the object.
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
    """Where a strategy runs. Commands hold until the next one; time advances in `step` only."""

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the air channels, in the order of all arrays."""

    @property
    def hand_bodies(self) -> frozenset[str]:
        """Names in `Observation.touching` that are parts of the hand; all others belong to the
        surroundings.
        """

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
        """Set the gauge pressures (channels,) [Pa] to reach and keep, whatever air that takes; NaN
        for a channel that keeps its command. The latest command of a channel counts, be it mass or
        pressure.
        """

    def hold_object(self, position: Array, orientation: Array) -> None:
        """Put the object at a pose in the wrist frame, position (3,) [m] and quaternion (4,), and
        hold it there by a spring until it is released; raises SceneError where that is impossible.
        """

    def release_object(self, duration: float) -> None:
        """Let the holding spring fade within a duration [s]."""

    def vent(self) -> None:
        """Open every outlet; raises SceneError when that is not confirmed."""

    def step(self, duration: float) -> None:
        """Let `duration` [s] of scene time pass, less when interrupted.

        Raises SceneError when the scene's time cannot go on.
        """

    def observe(self) -> Observation:
        """Return the state now; raises SceneError when a part of it is missing."""


class AirTarget(NamedTuple):
    """Target of the channels: air `masses` (channels,) [kg above the fill at rest and ambient
    pressure] or gauge `pressures` (channels,) [Pa]; NaN where the other quantity is commanded.
    """

    masses: Array
    pressures: Array

    def changed(
        self, masses: Mapping[str, float], pressures: Mapping[str, float], channels: tuple[str, ...]
    ) -> AirTarget:
        """This target with other commands for some of the channels.

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
        """Start of a ramp to `goal`. A channel starts at this target if both command the same
        quantity, otherwise at the measured value.
        """
        measured = (seen.air_mass, seen.pressure)
        parts = (
            np.where(np.isnan(wanted), np.nan, np.where(np.isnan(own), found, own))
            for own, wanted, found in zip(self, goal, measured, strict=True)
        )
        return AirTarget(*parts)

    def towards(self, goal: AirTarget, share: float) -> AirTarget:
        """Linear interpolation between this target (share 0) and `goal` (share 1), which commands
        the same quantities.
        """
        return AirTarget(*(a + share * (b - a) for a, b in zip(self, goal, strict=True)))


def hand_body_names(chains: Iterable[str]) -> frozenset[str]:
    """Names that contacts use for the parts of a hand: its chains and its plate."""
    return frozenset(chains) | {PALM_PLATE}
