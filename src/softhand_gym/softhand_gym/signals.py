"""The meaning of the numbers in actions and observations."""

from __future__ import annotations

import math

import numpy as np
from gymnasium import spaces

from grasp_strategies.in_process_scene import InProcessScene
from grasp_strategies.scene import Array, Observation
from softhand_model.chain.volumes import FreeVolumes
from softhand_model.hand.hand import HandDescription

MASS_COMMAND, PRESSURE_COMMAND = "air_mass", "pressure"
AIR_COMMANDS = (MASS_COMMAND, PRESSURE_COMMAND)
FULL_SHARE_BOUNDS = (-2.0, 5.0)  # of observed air, in units of full [-]; suction is below 0
FARTHEST_SEEN = 2.0  # of observed positions, along each axis [m]
STRONGEST_SEEN = 100.0  # of the observed force, along each axis [N]


class AirScale:
    """Air of a hand's channels, in units of full: `full_pressure` [Pa] and `full_mass` [kg]
    (channels,). `quantity` is the quantity that is commanded; raises ValueError unless it is one of
    AIR_COMMANDS.
    """

    def __init__(self, quantity: str, hand: HandDescription) -> None:
        if quantity not in AIR_COMMANDS:
            raise ValueError(f"air: expected one of {', '.join(AIR_COMMANDS)}, got {quantity!r}")
        self.quantity = quantity
        self.full_pressure = hand.max_pressures()
        self.full_mass = FreeVolumes(hand).air_masses(self.full_pressure)

    @property
    def full(self) -> Array:
        """The commanded quantity of full channels (channels,) [kg or Pa]."""
        return self.full_mass if self.quantity == MASS_COMMAND else self.full_pressure

    def command(self, scene: InProcessScene, numbers: Array) -> None:
        """Command the channels by the numbers of an action, -1 to 1."""
        wanted = 0.5 * (numbers + 1.0) * self.full
        if self.quantity == MASS_COMMAND:
            scene.command_air(wanted)
        else:
            scene.command_pressure(wanted)

    def numbers(self, wanted: Array) -> Array:
        """Numbers of an action that command masses [kg] or pressures [Pa] (channels,)."""
        return 2.0 * wanted / self.full - 1.0


class Sight:
    """Builds the agent's observations, and has their Gymnasium `space`. `touching_names`: bodies
    whose contact with the object is observed.
    """

    def __init__(
        self, air: AirScale, hand_bodies: frozenset[str], surroundings: tuple[str, ...]
    ) -> None:
        self._air = air
        self.touching_names = (*sorted(hand_bodies), *surroundings)
        channels = (len(air.full),)
        place = _box(-FARTHEST_SEEN, FARTHEST_SEEN, (3,))
        turn = _box(-1.0, 1.0, (4,))
        self._boxes = {
            "pressure": _box(*FULL_SHARE_BOUNDS, channels),
            "air_mass": _box(*FULL_SHARE_BOUNDS, channels),
            "wrist_position": place,
            "wrist_orientation": turn,
            "wrist_force": _box(-STRONGEST_SEEN, STRONGEST_SEEN, (3,)),
            "object_position": place,
            "object_orientation": turn,
            "touching": _box(0.0, 1.0, (len(self.touching_names),)),
        }
        self.space = spaces.Dict(dict[str, spaces.Space](self._boxes))

    def look(self, seen: Observation) -> dict[str, Array]:
        """The observation in the form of the space, clipped at its bounds."""
        found = {  # in the order of the boxes
            "pressure": seen.pressure / self._air.full_pressure,
            "air_mass": seen.air_mass / self._air.full_mass,
            "wrist_position": seen.wrist_position,
            "wrist_orientation": seen.wrist_orientation,
            "wrist_force": seen.wrist_force,
            "object_position": seen.object_position,
            "object_orientation": seen.object_orientation,
            "touching": np.array([name in seen.touching for name in self.touching_names], float),
        }
        return {
            name: np.clip(value, box.low, box.high, dtype=np.float32)
            for (name, value), box in zip(found.items(), self._boxes.values(), strict=True)
        }


def _box(low: float, high: float, shape: tuple[int, ...]) -> spaces.Box:
    return spaces.Box(low, high, shape, np.float32)


def turn_of(rotation: Array) -> Array:
    """Quaternion (4,) of a rotation vector (3,) [rad].

    >>> turn_of(np.array([0.0, 0.0, np.pi])).round(3).tolist()
    [0.0, 0.0, 1.0, 0.0]
    """
    angle = math.sqrt(rotation @ rotation)
    scale = 0.5 if angle < 1e-9 else math.sin(0.5 * angle) / angle
    return np.array([*(scale * rotation), math.cos(0.5 * angle)])


def rotation_of(quaternion: Array) -> Array:
    """Rotation vector (3,) [rad] of a unit quaternion (4,), the opposite of `turn_of`."""
    x, y, z, w = quaternion if quaternion[3] >= 0.0 else -quaternion
    sine = math.sqrt(x * x + y * y + z * z)
    scale = 2.0 if sine < 1e-9 else 2.0 * math.atan2(sine, w) / sine
    return scale * np.array([x, y, z])
