"""Poses of the bases of a hand's chains at rest, and of parts on them; lengths in mm.

A pose is a matrix (3, 4), rotation and place. In a chain's frame z runs along it, x out of the
palm side and y across; a cast lies in its mould along x, with its back along z.
"""

from __future__ import annotations

import numpy as np

from softhand_common.numerics.rotations import from_rpy, rotate
from softhand_design.mould.plan import MILLI, Array
from softhand_model.chain.segments import arc_angle, lateral_places, mean_radius
from softhand_model.hand.hand import WRIST, ChainDescription, HandDescription

MOULD_IN_CHAIN = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])


def pose(rotation: Array, place: Array) -> Array:
    """A pose (3, 4) of a rotation (3, 3) and a place (3,) [mm]."""
    return np.column_stack([rotation, place])


def after(first: Array, second: Array) -> Array:
    """Product of two poses (3, 4): the pose `second`, given in a frame with the pose `first`."""
    return pose(first[:, :3] @ second[:, :3], first[:, :3] @ second[:, 3] + first[:, 3])


def turned(rpy: tuple[float, ...], position: tuple[float, ...]) -> Array:
    """The pose (3, 4) of roll, pitch, yaw [rad] and a position [m]."""
    return pose(rotate(from_rpy(rpy), np.eye(3)).T, np.array(position) / MILLI)


def mount_poses(hand: HandDescription) -> dict[str, Array]:
    """Poses (3, 4) [mm] in the wrist frame of the mounts of all chains at rest."""
    found: dict[str, Array] = {}
    for chain in hand.chains:
        here = turned(chain.mount.rpy, chain.mount.position)
        if chain.mount.parent != WRIST:
            parent = chain.mount.parent
            here = after(after(found[parent], _tip(hand.chain(parent))), here)
        found[chain.name] = here
    return found


def base_height(chain: ChainDescription) -> float:
    """Where z [mm] of its mount the rubber of a chain begins: behind its strut."""
    return chain.strut.length / MILLI if chain.strut else 0.0


def _tip(chain: ChainDescription) -> Array:
    """Pose (3, 4) [mm] of a chain's tip in the frame of its mount."""
    parts = list(chain.actuators.values())
    if not chain.turn:
        return pose(np.eye(3), np.array([0.0, 0.0, base_height(chain) + parts[0].length / MILLI]))
    angle, radius = arc_angle(parts), mean_radius(parts) / MILLI
    c, s = np.cos(angle), chain.turn * np.sin(angle)
    place = [0.0, chain.turn * radius * (1.0 - c), base_height(chain) + radius * np.sin(angle)]
    return pose(np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]]), np.array(place))


def cast_poses(chain: ChainDescription) -> dict[str, Array]:
    """Poses (3, 4) [mm] in the frame of its mount of the casts of a chain's actuators.

    An arc's mould turns towards +y; the cast of a chain with `turn` -1 comes from the mirrored
    mould, so that here its file is mirrored already.
    """
    return {
        name: pose(MOULD_IN_CHAIN, np.array([0.0, y / MILLI, base_height(chain)]))
        for name, y in zip(chain.actuators, lateral_places(chain), strict=True)
    }
