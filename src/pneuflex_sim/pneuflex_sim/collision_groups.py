"""Which parts of a hand meet which: neighbouring fingers do not meet each other unless asked to,
fingers that face each other do, and so do fingers and thumb; all of them meet the environment.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pneuflex_sim.layout import Body, HandLayout
from softhand_model.hands import WRIST, HandDescription
from softhand_model.rotation import rotate

ENVIRONMENT, FINGER, THUMB, PALM = 1, 2, 4, 8  # collision groups
FACING = 16  # and its doubles: fingers that face those of the group FINGER, and one another
# [-], cosine of 60 deg; no more than 12 directions are that far apart, so there are bits enough
SAME_SIDE = 0.5


def collision_groups(layout: HandLayout, body: Body) -> list[int]:
    """Collision group of each joint's link: one for all fingers that bend to the same side, within
    60 deg, as `bending_sides` has it; arcs are the palm, what rides on them is the thumb.
    """
    groups, sides = [], bending_sides(layout.description)
    for name in body.chains:
        joints = layout.chain_joints[name]
        group = _collision_group(layout.description, name, sides)
        groups += [group] * (joints.stop - joints.start)
    return groups


def collides_with(group: int, neighbours: bool = False) -> int:
    """Mask of the groups that meet a group, its own among them if neighbouring fingers meet."""
    if group == PALM:
        return ENVIRONMENT
    return ~PALM if neighbours else ~(PALM | group)


def bending_sides(hand: HandDescription) -> dict[str, int]:
    """Index of the side to which each chain on the wrist bends, in the order of the chains;
    a chain is of the first side whose first chain bends within 60 deg of where it does.
    """
    sides: dict[str, int] = {}
    firsts: list[NDArray[np.float64]] = []
    for chain in hand.chains:
        if chain.mount.parent != WRIST or chain.turn:
            continue
        bending = rotate(chain.mount.quaternion, np.array([1.0, 0.0, 0.0]))
        near = [k for k, first in enumerate(firsts) if bending @ first > SAME_SIDE - 1e-9]
        sides[chain.name] = near[0] if near else len(firsts)
        if not near:
            firsts.append(bending)
    return sides


def _collision_group(hand: HandDescription, name: str, sides: dict[str, int]) -> int:
    """Group of a chain; what rides on a finger is part of it."""
    chain = hand.chain(name)
    if chain.turn:
        return PALM
    parent = chain.mount.parent
    if parent == WRIST:
        return FACING << (sides[name] - 1) if sides[name] else FINGER
    return THUMB if hand.chain(parent).turn else _collision_group(hand, parent, sides)
