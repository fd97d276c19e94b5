"""Which parts of a hand meet which: fingers and thumb each other, all of them the environment."""

from __future__ import annotations

from pneuflex_sim.layout import Body, HandLayout
from softhand_model.hands import WRIST

ENVIRONMENT, FINGER, THUMB, PALM = 1, 2, 4, 8  # collision groups
COLLIDES_WITH = {FINGER: ENVIRONMENT | THUMB, THUMB: ENVIRONMENT | FINGER, PALM: ENVIRONMENT}


def collision_groups(layout: HandLayout, body: Body) -> list[int]:
    """Collision group of each joint's link: fingers and thumb meet each other, all meet the
    environment.
    """
    groups = []
    for name in body.chains:
        joints = layout.chain_joints[name]
        groups += [_collision_group(layout, name)] * (joints.stop - joints.start)
    return groups


def _collision_group(layout: HandLayout, name: str) -> int:
    """Arcs are the palm, what rides on them is the thumb, all else belongs to fingers."""
    chain = layout.description.chain(name)
    if chain.turn:
        return PALM
    parent = chain.mount.parent
    if parent == WRIST:
        return FINGER
    return THUMB if layout.description.chain(parent).turn else _collision_group(layout, parent)
