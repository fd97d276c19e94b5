"""Motions that test a grasp: the wrist turns gravity through six directions, shakes and swings.

In the thesis (8.2.2) a person rotates and translates the hand; amplitudes and times are our choice.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from grasp_strategies.pose import Pose, minimum_jerk

Array = NDArray[np.float64]
WristPath = Callable[[float], Pose]  # pose of the wrist at a share of a motion, 0 to 1

# where gravity points in the wrist frame, each turned to from the one before by 90 deg
GRAVITY = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0), (0, -1, 0), (0, 0, -1))
TURN_TIME, DWELL = 1.0, 0.3  # [s]
SHAKE, SHAKE_TIME = 0.030, 1.0  # amplitude along each axis [m], period [s]
SWING, SWING_TIME = math.radians(45.0), 2.0  # amplitude about each axis [rad], period [s]


def motions(upright: Pose, strength: float = 1.0) -> list[tuple[float, WristPath]]:
    """Duration [s] and path of each motion of a wrist that is upright at its start and end;
    `strength` [-] scales the amplitudes of shaking and swinging.
    """
    return [*_turns(upright), *_shakes(upright, strength), *_swings(upright, strength)]


def _turns(upright: Pose) -> list[tuple[float, WristPath]]:
    """Turns of gravity through six directions and back; the heading of the wrist changes."""
    found: list[tuple[float, WristPath]] = []
    down, turn = np.array(GRAVITY[-1], float), Rotation.identity()
    for gravity in GRAVITY:
        # the hand turns the other way round
        axis = np.cross(gravity, down)
        found += [(TURN_TIME, _turning(upright, turn, 0.5 * np.pi * axis))]
        turn = turn * Rotation.from_rotvec(0.5 * np.pi * axis)
        found += [(DWELL, _turning(upright, turn, np.zeros(3)))]
        down = np.array(gravity, float)
    return [*found, (TURN_TIME, _turning(upright, turn, turn.inv().as_rotvec()))]


def _turning(upright: Pose, start: Rotation, by: Array) -> WristPath:
    """A turn from a start by a rotation vector (3,) [rad] in the wrist's own axes."""

    def at(share: float) -> Pose:
        turn = start * Rotation.from_rotvec(minimum_jerk(share) * by)
        return Pose(upright.position, turn.as_quat())

    return at


def _shakes(upright: Pose, strength: float) -> list[tuple[float, WristPath]]:
    def shake(axis: Array) -> WristPath:
        def at(share: float) -> Pose:
            way = strength * SHAKE * math.sin(2.0 * np.pi * share)
            return Pose(upright.position + way * axis, upright.orientation)

        return at

    return [(SHAKE_TIME, shake(axis)) for axis in np.eye(3)]


def _swings(upright: Pose, strength: float) -> list[tuple[float, WristPath]]:
    def swing(axis: Array) -> WristPath:
        def at(share: float) -> Pose:
            angle = strength * SWING * math.sin(2.0 * np.pi * share)
            return Pose(upright.position, Rotation.from_rotvec(angle * axis).as_quat())

        return at

    return [(SWING_TIME, swing(axis)) for axis in np.eye(3)]
