"""A serial chain of spherical joints that a moving base presses on a plate.

A step of duration h solves, for the turns d of the joints since its start,

    -K e(q) - D d / h + J^T (weight + contact) = 0

by iteration, with springs K and dampers D in parallel; at rest it is the equilibrium. Of inertia,
only the acceleration of the base counts: it is added to the weight.

Contact: each point of the skin that touches the plate is a spring, along the normal and along the
plate, from the place where it first touched. Its shear force is at most friction times its normal
force; beyond that it slides (return mapping).

Iteration: the slopes are the tangents of the joint springs and of the contact forces. A point that
slides has the slope (shear force over displacement) across the direction in which it slides; along
it, where the true tangent is 0, it has a share ALONG of that, as otherwise it would overshoot. The
change of lever arms with the turns is left out. The slope of the contacts on a link enters the
articulated-body recursion like the mass of a point, so the number of operations is linear in the
joints.

Vectors are in the axes of the world, z up, which is the normal of the plate.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from softhand_common.numerics.compiled import compiled
from softhand_model.dynamics.chain import (
    Folded,
    Links,
    Placed,
    accelerate,
    plus_transposed,
    shift_to_parent,
)
from softhand_model.dynamics.joint_springs import Springs, elastic_torque
from softhand_model.dynamics.spatial import (
    ZERO,
    ZERO_MATRIX,
    Array,
    IntArray,
    apply,
    cross,
    invert_symmetric,
    minus,
    minus_matrix,
    multiply,
    plus,
    plus_matrix,
    quaternion_of_rotation,
    quaternion_product,
    rotate_diagonal,
    rotation_between,
    rotation_matrix,
    rows,
    transposed,
    write,
    write_matrix,
)

MOST_ROUNDS, ROUNDS_BEFORE_HALF = 100, 25  # in a step; after as many turns are halved
STILL_TURN, ROUND_TURN = 3e-6, 0.02  # [rad] of a joint in an iteration
ALONG = 0.5  # of the slope of a point that slides, along its way
SKIN_NEAR = 0.003  # [m] above the plate, from which on points of the skin are followed


class Skin(NamedTuple):
    """Points of the skin of n links.

    start (n + 1,): index of the first point of each link. place (m, 3) [m]: in the axes of the
    link. reach (n,) [m]: distance of a link's farthest point from its joint. radius [m]: of the
    ball around each point, which touches.
    """

    start: IntArray
    place: Array
    reach: Array
    radius: float


class Plate(NamedTuple):
    """A plate: height [m] of its surface, friction [-] of the skin on it, stiffness [N/m] of a
    point of the skin along the normal, and along the plate.
    """

    height: float
    friction: float
    normal: float
    shear: float


class PressDrive(NamedTuple):
    """Inputs of a chain at the end of each step.

    duration (steps,) [s]. bend (steps, n, 3) [rad]: rotation that pressure adds to the rest of the
    joints. place (steps, 3) [m], frame (steps, 3, 3): of the chain's base. wrist (steps, 3) [m]:
    point about which moments are taken. pull (steps, 3) [m/s2]: on the masses; gravity less the
    acceleration of the base.
    """

    duration: Array
    bend: Array
    place: Array
    frame: Array
    wrist: Array
    pull: Array


class Touched(NamedTuple):
    """A placed chain and what acts on it.

    joint (n, 3) [m]: positions. force (n, 3) [N], moment (n, 3) [N m]: on each link, about its
    joint. angular, coupling, linear (n, 3, 3): derivatives of the contact forces by rotation and
    displacement of the link, in the form of a spatial inertia. seen (m,): whether a point of the
    skin is near the plate. anchor (m, 2) [m]: where the shear force of a point is 0.
    """

    joint: Array
    force: Array
    moment: Array
    angular: Array
    coupling: Array
    linear: Array
    seen: NDArray[np.bool_]
    anchor: Array


@compiled
def press_out(
    links: Links,
    springs: Springs,
    skin: Skin,
    plate: Plate,
    drive: PressDrive,
    kept: Array,
    q: Array,
    found: Array,
) -> tuple[float, int, int]:
    """Press one chain through all steps of `drive`. q (n, 4): orientations of the joints at the
    start, updated in place. kept (k,): rising numbers of steps. found (k, 6): is filled with force
    [N] and moment [N m] about the wrist, of contact and weight, at the end of these steps.

    Returns the largest turn [rad] of a joint in the last iteration of a step that did not converge,
    and the numbers of that step and joint; 0 if all steps did.
    """
    n, m = len(links.mass), len(skin.place)
    lines, turns, seen = np.zeros((4, n, 3)), np.zeros((8, n, 3, 3)), np.zeros(m, np.bool_)
    placed = Placed(turns[0], lines[0], lines[1], turns[1], turns[1])
    touched = Touched(
        lines[1], lines[2], lines[3], turns[2], turns[3], turns[4], seen, np.zeros((m, 2))
    )
    folded = Folded(turns[5], turns[6], turns[7], np.empty((n, 3)))
    turned, turn = np.empty((n, 3)), np.empty((n, 3))
    row, unsettled, worst_step, worst_joint, fastest = 0, 0.0, 0, 0, 0
    for step in range(len(drive.duration)):
        turned[:] = 0.0
        largest = 0.0
        for attempt in range(MOST_ROUNDS):
            _place(q, links, drive.place[step], drive.frame[step], placed)
            _load(links, skin, plate, drive.pull[step], placed, touched, False)
            _fold(
                springs, drive.bend[step], drive.duration[step], q, turned, placed, touched, folded
            )
            accelerate(0, n, placed, folded, turn)
            largest = 0.0
            for i in range(n):
                for k in range(3):
                    if abs(turn[i, k]) > largest:
                        largest, fastest = abs(turn[i, k]), i
            part = 0.5 ** (attempt // ROUNDS_BEFORE_HALF)  # points may stick and slide in turns
            share = min(part, ROUND_TURN / max(largest, STILL_TURN))
            for i in range(n):
                by = (share * turn[i, 0], share * turn[i, 1], share * turn[i, 2])
                next_q = quaternion_product(q[i], quaternion_of_rotation(by))
                for k in range(4):
                    q[i, k] = next_q[k]
                for k in range(3):
                    turned[i, k] += by[k]
            if largest < STILL_TURN:
                break
        if largest >= STILL_TURN and largest > unsettled:
            unsettled, worst_step, worst_joint = largest, step, fastest
        _place(q, links, drive.place[step], drive.frame[step], placed)
        _load(links, skin, plate, drive.pull[step], placed, touched, True)
        while row < len(kept) and kept[row] == step:
            _sum_up(drive.wrist[step], touched, found[row])
            row += 1
    return unsettled, worst_step, worst_joint


@compiled
def _place(q: Array, links: Links, place: Array, base: Array, placed: Placed) -> None:
    """Place the links in the world; the joints are the centres of `placed`."""
    frame, at = rows(base), plus(place, ZERO)
    for i in range(len(q)):
        arm = apply(frame, links.offset[i])
        at = plus(at, arm)
        frame = multiply(frame, rotation_matrix(q[i]))
        write(arm, placed.arm[i])
        write(at, placed.center[i])
        write_matrix(frame, placed.frame[i])


@compiled
def _load(
    links: Links,
    skin: Skin,
    plate: Plate,
    pull: Array,
    placed: Placed,
    touched: Touched,
    ended: bool,
) -> None:
    """Weight and contact of the placed links; when a step has ended, points that slid are anchored
    anew.
    """
    for i in range(len(links.mass)):
        frame, joint = rows(placed.frame[i]), placed.center[i]
        mass = links.mass[i]
        weight = (mass * pull[0], mass * pull[1], mass * pull[2])
        force, moment = weight, cross(apply(frame, links.center[i]), weight)
        a, b, c = ZERO_MATRIX, ZERO_MATRIX, ZERO_MATRIX
        near = joint[2] - skin.reach[i] - skin.radius - plate.height < SKIN_NEAR
        for point in range(skin.start[i], skin.start[i + 1]):
            if not near:
                touched.seen[point] = False
                continue
            arm = apply(frame, skin.place[point])
            x, y = joint[0] + arm[0], joint[1] + arm[1]
            depth = plate.height + skin.radius - joint[2] - arm[2]
            anchor = touched.anchor[point]
            away_x, away_y = x - anchor[0], y - anchor[1]
            if not touched.seen[point]:
                away_x = away_y = 0.0
            if depth > 0.0:
                arm = (arm[0], arm[1], arm[2] - skin.radius)
                normal = plate.normal * depth
                shear_x, shear_y = -plate.shear * away_x, -plate.shear * away_y
                size = math.sqrt(shear_x * shear_x + shear_y * shear_y)
                share, less_x, less_y = 1.0, 0.0, 0.0
                if size > plate.friction * normal:  # slides
                    share = plate.friction * normal / size
                    less_x = math.sqrt(1.0 - ALONG) * shear_x / size
                    less_y = math.sqrt(1.0 - ALONG) * shear_y / size
                shear_x, shear_y = share * shear_x, share * shear_y
                stiff = share * plate.shear
                push = (shear_x, shear_y, normal)
                force, moment = plus(force, push), plus(moment, cross(arm, push))
                slope = (
                    (stiff * (1.0 - less_x * less_x), -stiff * less_x * less_y, 0.0),
                    (-stiff * less_x * less_y, stiff * (1.0 - less_y * less_y), 0.0),
                    (0.0, 0.0, plate.normal),
                )
                crossed = transposed(
                    (cross(arm, slope[0]), cross(arm, slope[1]), cross(arm, slope[2]))
                )
                about = (cross(crossed[0], arm), cross(crossed[1], arm), cross(crossed[2], arm))
                a = minus_matrix(a, about)
                b, c = plus_matrix(b, crossed), plus_matrix(c, slope)
                away_x, away_y = -shear_x / plate.shear, -shear_y / plate.shear
            else:
                away_x = away_y = 0.0
            if ended:
                anchor[0], anchor[1] = x - away_x, y - away_y
                touched.seen[point] = True
        write(force, touched.force[i])
        write(moment, touched.moment[i])
        write_matrix(a, touched.angular[i])
        write_matrix(b, touched.coupling[i])
        write_matrix(c, touched.linear[i])


@compiled
def _fold(
    springs: Springs,
    bend: Array,
    duration: float,
    q: Array,
    turned: Array,
    placed: Placed,
    touched: Touched,
    folded: Folded,
) -> None:
    """The pass from tip to base of an iteration, of joints at q (n, 4) that turned by
    `turned` (n, 3) [rad] since the step of a duration [s] began.
    """
    a, b, c = ZERO_MATRIX, ZERO_MATRIX, ZERO_MATRIX
    moment, force = ZERO, ZERO  # that the joints further out take, as turns of theirs give way
    for i in range(len(q) - 1, -1, -1):
        a = plus_matrix(a, rows(touched.angular[i]))
        b = plus_matrix(b, rows(touched.coupling[i]))
        c = plus_matrix(c, rows(touched.linear[i]))
        moment = minus(moment, touched.moment[i])
        force = minus(force, touched.force[i])
        target = quaternion_product(springs.rest[i], quaternion_of_rotation(bend[i]))
        error, stiffness = rotation_between(target, q[i]), springs.stiffness[i]
        elastic, here, _ = elastic_torque(error, bend[i, 1], stiffness, springs.stretching[i])
        drag = (
            springs.damping[i, 0] / duration,
            springs.damping[i, 1] / duration,
            springs.damping[i, 2] / duration,
        )
        added = (
            stiffness[0] + drag[0],
            stiffness[1] * here + drag[1],
            stiffness[2] + drag[2],
        )
        right = (
            elastic[0] - drag[0] * turned[i, 0],
            elastic[1] - drag[1] * turned[i, 1],
            elastic[2] - drag[2] * turned[i, 2],
        )
        frame, arm = rows(placed.frame[i]), placed.arm[i]
        s = invert_symmetric(plus_matrix(rotate_diagonal(frame, added), a))
        left = minus(apply(frame, right), moment)
        write_matrix(a, folded.angular[i])
        write_matrix(b, folded.coupling[i])
        write_matrix(s, folded.inverse[i])
        write(left, folded.torque[i])
        sa, sb = multiply(s, a), multiply(s, b)
        force = plus_transposed(force, sb, left)
        moment = plus(plus_transposed(moment, sa, left), cross(arm, force))
        a, b, c = (
            minus_matrix(a, multiply(a, sa)),
            minus_matrix(b, multiply(a, sb)),
            minus_matrix(c, multiply(transposed(b), sb)),
        )
        a, b = shift_to_parent(arm, a, b, c)


@compiled
def _sum_up(wrist: Array, touched: Touched, out: Array) -> None:
    """Force [N] and moment [N m] about the wrist, into an array (6,)."""
    force, moment = ZERO, ZERO
    for i in range(len(touched.force)):
        force = plus(force, touched.force[i])
        arm = minus(touched.joint[i], wrist)
        moment = plus(moment, plus(touched.moment[i], cross(arm, touched.force[i])))
    write(force, out[:3])
    write(moment, out[3:])
