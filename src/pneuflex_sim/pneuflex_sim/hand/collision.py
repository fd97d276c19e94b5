"""Collision shapes of a hand's links, and which parts of a hand collide with each other.

The collision shape of a link is a box, or a convex hull (`pieces`) of `softhand_model.chain.hulls`,
which the engine dilates by its collision margin.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.hand.layout import Body, HandLayout
from softhand_common.numerics.arrays import Array
from softhand_common.numerics.rotations import rotate
from softhand_model.chain.hulls import COLLISION_MARGIN, collision_hulls
from softhand_model.hand.hand import WRIST, HandDescription

HULL_PIECES, BOXES = "pieces", "boxes"  # kinds of collision shapes
COLLISION_KINDS = (HULL_PIECES, BOXES)
ENVIRONMENT_GROUP, FINGER_GROUP, THUMB_GROUP, PALM_GROUP = 1, 2, 4, 8  # collision groups
# and its multiples by powers of two: fingers on the sides that face FINGER_GROUP and each other
FACING_GROUP = 16
# [-], cosine of 60 deg; no more than 12 directions are that far apart, so there are bits enough
SAME_SIDE = 0.5
# skin of a finger, two of them in series where fingers meet: as stiff as balls of rubber that 1 N
# presses on each other, with a shear modulus of 67 kPa and radii of 8 mm (Hertz); [N/m], [N s/m]
SKIN_STIFFNESS, SKIN_DAMPING = 1500.0, 1.5
SKIN_PATCH = 0.0028  # radius of the patch that one of them makes with something rigid at 1 N [m]
SKIN_TWIST = 3.0 * np.pi / 16.0 * SKIN_PATCH  # moment over friction and normal force [m]


def collision_groups(layout: HandLayout, body: Body) -> list[int]:
    """Collision group of each joint's link. Fingers that bend to the same side, within 60 deg as in
    `bending_sides`, share a group; palm chains (arcs) are PALM_GROUP, chains mounted on them
    THUMB_GROUP.
    """
    groups, sides = [], bending_sides(layout.description)
    for name in body.chains:
        joints = layout.chain_joints[name]
        group = _collision_group(layout.description, name, sides)
        groups += [group] * (joints.stop - joints.start)
    return groups


def collides_with(group: int, neighbours: bool = False) -> int:
    """Bit mask of the groups that collide with `group`. Links of one group collide with each other
    only if `neighbours` is True.
    """
    if group == PALM_GROUP:
        return ENVIRONMENT_GROUP
    return ~PALM_GROUP if neighbours else ~(PALM_GROUP | group)


def bending_sides(hand: HandDescription) -> dict[str, int]:
    """Index of the side to which each chain on the wrist bends, in the order of the chains. A chain
    belongs to the first side whose first chain bends within 60 deg of its own direction.
    """
    sides: dict[str, int] = {}
    firsts: list[Array] = []
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
    """Group of a chain; a chain mounted on a finger has the finger's group."""
    chain = hand.chain(name)
    if chain.turn:
        return PALM_GROUP
    parent = chain.mount.parent
    if parent == WRIST:
        return FACING_GROUP << (sides[name] - 1) if sides[name] else FINGER_GROUP
    return THUMB_GROUP if hand.chain(parent).turn else _collision_group(hand, parent, sides)


@dataclass(frozen=True)
class Touch:
    """Contact properties of a hand: kind of its collision shapes, PyBullet's coefficient of
    friction [-], and whether neighbouring fingers collide; if they do, their skin is compliant.
    """

    kind: str = HULL_PIECES
    friction: float = 1.0
    neighbours: bool = False

    @property
    def skin(self) -> dict[str, float]:
        """PyBullet's resistance of a finger's contacts to twisting [m]; where neighbours collide,
        their stiffness [N/m] and damping [N s/m], too.
        """
        twisting = {"spinningFriction": SKIN_TWIST * self.friction}
        if not self.neighbours:
            return twisting
        return {**twisting, "contactStiffness": SKIN_STIFFNESS, "contactDamping": SKIN_DAMPING}


def check_kind(kind: str) -> None:
    """Raise ValueError unless `kind` is a kind of collision shapes."""
    if kind not in COLLISION_KINDS:
        raise ValueError(f"collision: expected one of {', '.join(COLLISION_KINDS)}, got {kind!r}")


def link_shapes(layout: HandLayout, body: Body, kind: str, client: int) -> list[int]:
    """Create the collision shape of every link of a body; returns their PyBullet ids.

    Each shape is centred at the link's centre of mass, so that PyBullet needs no compound around
    it.
    """
    of_body = body.joints
    if kind == BOXES:
        shapes = [
            {"shapeType": pybullet.GEOM_BOX, "halfExtents": (size / 2).tolist()}
            for size in layout.size[of_body]
        ]
    else:
        hulls = [
            hull
            for name in body.chains
            for hull in collision_hulls(layout.models[name].description, layout.segments)
        ]
        shapes = [
            {"shapeType": pybullet.GEOM_MESH, "vertices": (hull - center).tolist()}
            for hull, center in zip(hulls, layout.center[of_body], strict=True)
        ]
    return [
        pybullet.createCollisionShape(
            **shape, collisionFramePosition=center.tolist(), physicsClientId=client
        )
        for shape, center in zip(shapes, layout.center[of_body], strict=True)
    ]


def set_margin(body: int, link: int, kind: str, client: int) -> None:
    """Give a link's hull the collision margin by which it was eroded. Boxes keep PyBullet's margin,
    which lies inside them.
    """
    if kind == HULL_PIECES:
        pybullet.changeDynamics(
            body, link, collisionMargin=COLLISION_MARGIN, physicsClientId=client
        )
