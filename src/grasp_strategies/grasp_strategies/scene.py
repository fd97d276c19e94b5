"""The contract between a strategy and the place where it runs.

A strategy commands the wrist and the air, lets time pass and observes; it never learns whether
physics is computed in the same process or beyond ROS topics. Units are SI, poses are in the frame
`world` (z up), quaternions (x, y, z, w).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Protocol

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
        """Set the target air masses (channels,) [kg above the fill at rest and ambient]."""

    def vent(self) -> None:
        """Open every outlet; raises SceneError when it cannot be known that this happened."""

    def step(self, duration: float) -> None:
        """Let `duration` [s] of scene time pass, less when interrupted.

        Raises SceneError when time cannot go on.
        """

    def observe(self) -> Observation:
        """Return the state now; raises SceneError when a part of it is missing."""


def masses_in_order(
    masses: Mapping[str, float], channels: tuple[str, ...], otherwise: Array
) -> Array:
    """Air masses (channels,) [kg] by channel; channels that are not named keep `otherwise`.

    >>> masses_in_order({"b": 2e-5}, ("a", "b"), np.array([1e-5, 0.0])).tolist()
    [1e-05, 2e-05]
    """
    return np.array(
        [masses.get(name, kept) for name, kept in zip(channels, otherwise, strict=True)]
    )


def hand_body_names(chains: Iterable[str]) -> frozenset[str]:
    """Names in contacts that are parts of a hand with these chains."""
    return frozenset(chains) | {PALM_PLATE}
