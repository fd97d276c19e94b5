"""Collision shapes of a hand's links, and which parts of a hand meet which.

The collision shape of a link is a box, or a convex hull (`pieces`) that follows the outline. The
hull is eroded by COLLISION_MARGIN, and the engine dilates it again. The thesis shrinks its skin by
1 mm and lets it touch at a distance of 1 mm (5.1.4), which rounds edges off; here the engine's
collision margin does the second half. A hull reaches from joint to joint. Its faces at joints are
not eroded, so that the passive layer is continuous from link to link and neighbours overlap by the
margin. Hulls meet on the axis of the joint: bending opens no gap in the passive layer, but wedges
on the back, as between boxes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, HalfspaceIntersection

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.hand.layout import SMALLEST_EDGE, Body, HandLayout
from pneuflex_sim.hand.outline import ChainOutline, hull_section
from softhand_common.numerics.rotations import rotate
from softhand_model.hand.hand import WRIST, ChainDescription, HandDescription

Array = NDArray[np.float64]

HULL_PIECES, BOXES = "pieces", "boxes"  # kinds of collision shapes
COLLISION_KINDS = (HULL_PIECES, BOXES)
COLLISION_MARGIN = 0.001  # [m]
MAX_TAPER_FACTOR = 2.0  # limit that keeps a section of SMALLEST_EDGE from vanishing
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
    """Mask of the groups that collide with a group; with its own group only if `neighbours`
    collide.
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


def collision_hulls(description: ChainDescription, segments: int) -> list[Array]:
    """Vertices (k, 3) [m] of each joint's hull in its link's frame, from the strut (or first joint)
    to the tip.

    A strut's link carries the first half segment of the rubber; the strut itself has no hull. The
    base of a chain without strut is part of the body that carries it and has none either. Sections
    thinner than SMALLEST_EDGE are thickened to it, behind the passive layer.
    """
    outline, hulls = ChainOutline(description, segments), []
    if description.strut is not None:
        lift = np.array([0.0, 0.0, description.strut.length / 2.0 + outline.edge / 2.0])
        hulls.append(_hull(outline, 0) + lift)
    return hulls + [_hull(outline, bone) for bone in range(1, segments + 1)]


def _hull(outline: ChainOutline, bone: int) -> Array:
    """Vertices (k, 3) [m] of a bone's hull in its frame, around the sections at both ends."""
    ends = outline.range(bone)
    shapes = [
        outline.outlines(place, hull_section(), SMALLEST_EDGE).reshape(-1, 2) for place in ends
    ]
    around = ConvexHull(shapes[0]).vertices  # counterclockwise; parallel actuators share a hull
    start, stop = (shape[around] for shape in shapes)
    steepness = _slopes(start, stop, ends[1] - ends[0])
    at_tip = COLLISION_MARGIN if bone == outline.segments else 0.0
    share = at_tip / (ends[1] - ends[0])
    stop, place = (1.0 - share) * stop + share * start, ends[1] - at_tip
    rings = []
    for ring, at in ((start, ends[0]), (stop, place)):
        point, axes = outline.section(bone, at)
        flat = inset(ring, COLLISION_MARGIN * steepness)
        rings.append(point + np.column_stack([flat, np.zeros(len(flat))]) @ axes.T)
    return np.vstack(rings)


def _normals(ring: Array) -> Array:
    """Outward unit normals (n, 2) of the edges from each vertex to the next, counterclockwise."""
    edge = np.roll(ring, -1, axis=0) - ring
    normal = np.stack([edge[:, 1], -edge[:, 0]], axis=1)
    return normal / np.linalg.norm(normal, axis=1)[:, None]


def _slopes(start: Array, stop: Array, length: float) -> Array:
    """Factor (n,) [-] by which each edge must move more in the plane of the section for its tapered
    face to move by 1 along the face's normal.
    """
    normal = _normals(start)
    rise = np.einsum("ij,ij->i", normal, stop - start) / length
    return np.minimum(np.sqrt(1.0 + rise**2), MAX_TAPER_FACTOR)


def inset(ring: Array, distances: Array) -> Array:
    """Corners (k, 2) of a convex polygon (n, 2) with every edge moved inwards by its distance (n,)
    [m]; edges that become empty vanish.

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> sorted(inset(square, np.full(4, 0.25)).tolist())
    [[0.25, 0.25], [0.25, 0.75], [0.75, 0.25], [0.75, 0.75]]
    """
    normal = _normals(ring)
    level = np.einsum("ij,ij->i", normal, ring) - distances
    halfplanes = np.column_stack([normal, -level])
    return np.unique(HalfspaceIntersection(halfplanes, ring.mean(axis=0)).intersections, axis=0)


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
    """Raise ValueError for anything but a kind of collision shapes."""
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
    """Dilate a link's hull by the margin it was eroded by; the margin of boxes lies within them."""
    if kind == HULL_PIECES:
        pybullet.changeDynamics(
            body, link, collisionMargin=COLLISION_MARGIN, physicsClientId=client
        )
