"""Compiled integration of a chain from its base to its tip under a wrench at the base.

The rotation of a joint follows from the wrench and from the joints before it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_common.numerics.compiled import compiled
from softhand_common.numerics.triples import (
    IDENTITY_MATRIX,
    Matrix,
    Vector,
    about_y,
    apply,
    cross,
    left_jacobian,
    minus,
    multiply,
    plus,
    rotation,
    scaled,
    transposed,
    vector_at,
)
from softhand_model.chain.segments import SegmentChain
from softhand_model.equilibrium.joint_balance import SpringArrays, compliance, joint_rotation
from softhand_model.equilibrium.joint_springs import JointSprings

SPIN, POSITION_CHANGE, MOMENT = range(
    3
)  # quantities that depend on the wrench: orientation, position, moment
CHANGES = (3, 6, 3)  # shape: quantity, component of the wrench at the base, vector


class Links(NamedTuple):
    """Links of a straight chain with n joints.

    along (n + 1,) [m]: from the base to the first joint, from joint to joint, and to the tip. mass
    (n,) [kg] and center (n, 3) [m] of each link, in its own frame.
    """

    along: Array
    mass: Array
    center: Array


def straight_links(chain: SegmentChain) -> Links:
    """The links of a chain; raises ValueError for a chain that is not straight at rest."""
    chain.require_straight()
    along = np.append(chain.offset[:, 2], chain.tip_offset[2])
    return Links(along, np.array(chain.mass, float), np.array(chain.body_center, float))


def tip_pose(links: Links, springs: JointSprings, wrench: Array) -> tuple[Array, Array]:
    """(position (3,) [m], orientation (3, 3)) of the tip of a weightless chain with springs at a
    single point, under a wrench (6,) [N, N m] at its base.
    """
    none, change = np.empty((3, 0)), np.empty(CHANGES)
    place, turn, _ = march(links, springs.arrays(), none, False, 0, wrench, change, False)
    return np.array(place), np.array(turn)


@compiled
def march(
    links: Links,
    springs: SpringArrays,
    gravity: Array,
    heavy: bool,
    point: int,
    wrench: Array,
    change: Array,
    sloped: bool,
) -> tuple[Vector, Matrix, Vector]:
    """(position [m], orientation, force [N]) at the tip, for a wrench (6,) [N, N m] that the chain
    exerts on its base.

    gravity (3, n) [m/s2]: counts if `heavy`. point: index of the point in springs and gravity.
    sloped: whether to fill `change` with the derivatives of position and orientation by the wrench;
    the force at the tip changes as the force at the base does.
    """
    force, moment = (wrench[0], wrench[1], wrench[2]), (wrench[3], wrench[4], wrench[5])
    place, turn = (0.0, 0.0, 0.0), IDENTITY_MATRIX
    if sloped:
        _begin(change)
    for joint in range(len(links.mass)):
        reach = scaled(links.along[joint], (turn[0][2], turn[1][2], turn[2][2]))
        place = plus(place, reach)
        rest = about_y(turn, springs.sine[joint, point], springs.cosine[joint, point])
        carried = minus(moment, cross(place, force))
        local = apply(transposed(rest), carried)
        bent = joint_rotation(springs, joint, point, local)
        turn = multiply(rest, rotation(bent))
        if sloped:
            _advance(change, reach)
            inward = compliance(springs, joint, point, bent, local)
            turned = multiply(rest, multiply(left_jacobian(bent), inward))
            outward = multiply(turned, transposed(rest))
            _bend(change, outward, place, force, carried)
        if heavy:
            weight = scaled(links.mass[joint], vector_at(gravity, point))
            center = links.center[joint, 0], links.center[joint, 1], links.center[joint, 2]
            arm = apply(turn, center)
            moment = minus(moment, cross(plus(place, arm), weight))
            force = minus(force, weight)
            if sloped:
                _unload(change, arm, weight)
    reach = scaled(links.along[-1], (turn[0][2], turn[1][2], turn[2][2]))
    if sloped:
        _advance(change, reach)
    return plus(place, reach), turn, force


@compiled
def _begin(change: Array) -> None:
    change[:] = 0.0
    for axis in range(3):
        change[MOMENT, 3 + axis, axis] = 1.0


@compiled
def _advance(change: Array, reach: Vector) -> None:
    """Continue along a link."""
    for by in range(6):
        _add(change, POSITION_CHANGE, by, cross(_of(change, SPIN, by), reach))


@compiled
def _bend(change: Array, outward: Matrix, place: Vector, force: Vector, moment: Vector) -> None:
    """Pass a joint whose rotation changes by `outward` times the change of its moment."""
    x, y, z = place
    by_force = ((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0))  # -place x unit vector
    for by in range(6):
        more = minus(_of(change, MOMENT, by), cross(_of(change, POSITION_CHANGE, by), force))
        more = minus(more, cross(_of(change, SPIN, by), moment))
        if by < 3:
            more = plus(more, by_force[by])
        _add(change, SPIN, by, apply(outward, more))


@compiled
def _unload(change: Array, arm: Vector, weight: Vector) -> None:
    """Subtract the weight of a link, which acts with an arm about its joint."""
    for by in range(6):
        moved = plus(_of(change, POSITION_CHANGE, by), cross(_of(change, SPIN, by), arm))
        _add(change, MOMENT, by, cross(weight, moved))


@compiled
def _of(change: Array, what: int, by: int) -> Vector:
    return (change[what, by, 0], change[what, by, 1], change[what, by, 2])


@compiled
def _add(change: Array, what: int, by: int, more: Vector) -> None:
    for axis in range(3):
        change[what, by, axis] += more[axis]
