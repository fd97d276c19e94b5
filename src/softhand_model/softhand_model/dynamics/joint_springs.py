"""Implicit joint springs of serial chains of spherical joints, in a number of operations linear
in the joints.

One step solves, for each chain,

    (M(q) + dt D + dt^2 (K + G)) a = -K (e + dt v) - (D + dt G) v + f_ext
    torque = -K (e + dt (v + dt a)) - (D + dt G) (v + dt a) + J (a + a_base)

with e the rotation vector of rest^-1 q, K and D the stiffness and damping about the axes of each
joint's child frame, G the stiffness of enclosed gas (it acts only on the motion within the step:
the pressure at the start of the step is already in `rest`), and f_ext all else that acted on the
joints in the step before, observed as (M + J)_prev (v - v_prev)/dt - (torque - J a_base)_prev. At
rest a = 0 and torque = -K e whatever dt. `chain` solves it, with dt D + dt^2 (K + G) added to each
joint's own inertia. Where K is not the same about all axes, or not constant, -K e stands for
`elastic_torque`, and K within the step for its tangent.

J is inertia that is given back: the engine's links are heavier than the hand's, so that its contact
solver, which does not see the springs, bears them. M is without J, and the torque makes up for what
J takes, at absolute spins: of the bases as well, whose reaction is kept from the wrist. For a link
that an obstacle stops, the observed load would overshoot by (M + J)/(M + dt D + dt^2 (K + G)) a
step. So J is 0 for chains that touch: they move with the engine's inertia, and rest. It is 0 for
fast ones as well: their gyroscopic terms, which are loads of the step before, would grow.

Springs are linear, of the energy e*K*e/2, or of rubber (eq. 3.24) in bending: with u = 1 + s*bend
the stretch of the top, moment k*(q(u) - q(u_rest))/(2*s), q = u - u**-3, in place of k*e_y: 2*k of
a straight joint, k/2 of one bent far.

A joint meets a stiff stop before it could turn over into its opposite, and no pressure turns its
rest beyond that stop. Fingers that fold so far meet themselves, which the model leaves out. A joint
that would turn farther in a step than can be integrated is braked; only blows make one so fast.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from softhand_common.numerics.compiled import compiled, without_allocation
from softhand_model.dynamics.chain import (
    Equation,
    Links,
    Placed,
    give_back,
    inertial_torque,
    not_placed,
    place_links,
    solve_chains,
)
from softhand_model.dynamics.spatial import (
    Array,
    Row,
    Vector,
    cross,
    quaternion_of_rotation,
    quaternion_product,
    rotation_between,
    write,
)
from softhand_model.hand.joint_stiffness import LEAST_STRETCH

SMALL_ANGLE = 1e-2  # [rad], below which series stand for the rotation's Jacobian
STOP_ANGLE = 2.4  # [rad] of a joint from rest; at pi a rotation would turn over into its opposite
STOP_SHARE = 20.0  # stiffness of the stop over the joint's own
BRAKE_ANGLE = 0.2  # [rad] a joint may turn in a step before it is braked,
SLOWEST_BRAKE, FASTEST_BRAKE = 20.0, 50.0  # [rad/s] within these speeds
BRAKE_TIME = 0.3  # [s] damping of the brake over the joint's stiffness


class Springs(NamedTuple):
    """Springs of joints about the axes of their child frames.

    Attributes:
        rest: quaternions (n, 4), x y z w, in which the springs have no torque.
        stiffness: (n, 3) [N m/rad].
        stretching: (n,) [1/rad] stretch of the top of the finger for a bend of the joint, as the
            law of rubber needs it; 0 makes the spring a linear one.
        damping: (n, 3) [N m s/rad].
    """

    rest: Array
    stiffness: Array
    stretching: Array
    damping: Array


class Joints(NamedTuple):
    """Joints after a step of the engine: orientations q (n, 4), velocities v (n, 3) [rad/s], and
    for each chain (chains,) whether its additional inertia is not compensated (`heavy`), because
    the chain has contact or is fast, or was so a short time ago.
    """

    q: Array
    v: Array
    heavy: NDArray[np.bool_]


class Actuation(NamedTuple):
    """Effect of pressure on joints: rotation `bend` (n, 3) [rad] of their rest, and stiffness `gas`
    (n, 3) [N m/rad] of the enclosed air.
    """

    bend: Array
    gas: Array


class Before(NamedTuple):
    """State that a step passes on to the next one.

    Attributes:
        v: velocities (n, 3) [rad/s].
        torque: (n, 3) [N m], which is also the result of the step.
        placed: the links.
        carried: (n, 3) [N m], the part of the torque that turns given inertia with the bases.
        base_rate: (chains, 3) [rad/s2] of the bases in the step, in their axes.
        reaction: (chains, 3) [N m] that the given inertia took from the bases in the step.
    """

    v: Array
    torque: Array
    placed: Placed
    carried: Array
    base_rate: Array
    reaction: Array


def nothing_before(joints: int, chains: int) -> Before:
    """The initial `Before`."""
    turning, bases = np.zeros((3, joints, 3)), np.zeros((2, chains, 3))
    return Before(turning[0], turning[1], not_placed(joints), turning[2], bases[0], bases[1])


@without_allocation
def rubber_stress(stretch: float) -> tuple[float, float]:
    """(elastic term, slope) [-] at a stretch [-], as `joint_stiffness.rubber_stress`, for one
    joint.
    """
    least = max(stretch, LEAST_STRETCH)
    inverse = 1.0 / least
    cube = inverse * inverse * inverse
    slope = 1.0 + 3.0 * cube * inverse
    return least - cube + slope * (stretch - least), slope


@without_allocation
def elastic_torque(
    error: Row, rest_bend: float, stiffness: Array, stretching: float
) -> tuple[Vector, float, float]:
    """Torque (3,) [N m] of a joint's spring on its child, in the child's axes, at a rotation
    `error` (3,) [rad] from a rest bent by rest_bend [rad]; and two factors on the stiffness in
    bending, by which its tangent differs here and in the rest shape.

    The torque is minus the gradient of the energy: the transposed inverse of the right Jacobian of
    the rotation times K*e, that is K*e - e x K*e/2 + c*e x (e x K*e).
    """
    bending, here, at_rest = stiffness[1] * error[1], 1.0, 1.0
    if stretching > 0.0:
        stress, here = rubber_stress(1.0 + stretching * (rest_bend + error[1]))
        rest_stress, at_rest = rubber_stress(1.0 + stretching * rest_bend)
        bending = stiffness[1] * (stress - rest_stress) / (2.0 * stretching)
        here, at_rest = 0.5 * here, 0.5 * at_rest
    square = error[0] * error[0] + error[1] * error[1] + error[2] * error[2]
    share = 1.0 / 12.0 + square / 720.0
    if square > SMALL_ANGLE * SMALL_ANGLE:
        half = 0.5 * math.sqrt(square)
        share = (1.0 - half / math.tan(half)) / square
    along = (stiffness[0] * error[0], bending, stiffness[2] * error[2])
    across = cross(error, along)
    again = cross(error, across)
    torque = (
        -along[0] + 0.5 * across[0] - share * again[0],
        -along[1] + 0.5 * across[1] - share * again[1],
        -along[2] + 0.5 * across[2] - share * again[2],
    )
    return torque, here, at_rest


@without_allocation
def beyond_stop(angle: float) -> float:
    """Angle [rad] by which a rotation from rest exceeds the stop; 0 within."""
    if angle > STOP_ANGLE:
        return angle - STOP_ANGLE
    return min(0.0, angle + STOP_ANGLE)


@compiled
def spring_torques(
    dt: float,
    first_step: bool,
    links: Links,
    springs: Springs,
    joints: Joints,
    actuation: Actuation,
    before: Before,
) -> None:
    """One implicit step of all chains: computes the torques in `before`, which is updated in place.
    first_step: whether `before` is that of `nothing_before`.
    """
    shape = joints.v.shape
    external = np.zeros(shape)
    equation = Equation(np.empty(shape), np.empty(shape), np.empty(shape))
    if not first_step:
        inertial_torque((joints.v - before.v) / dt, links, before.placed, external)
        external -= before.torque - before.carried
    place_links(joints.q, links, before.placed)
    for f in range(len(links.start) - 1):
        if joints.heavy[f]:
            before.placed.given[links.start[f] : links.start[f + 1]] = 0.0
    _pull(dt, springs, joints, actuation, external, before.torque, equation)
    solve_chains(equation, links, before.placed)
    if _brake(dt, joints.v, springs.stiffness, before.torque, equation):
        solve_chains(equation, links, before.placed)
    for i in range(shape[0]):
        for k in range(3):
            before.torque[i, k] -= equation.added[i, k] * equation.acceleration[i, k]
            before.v[i, k] = joints.v[i, k]
            before.carried[i, k] = 0.0
    unused = np.empty(before.reaction.shape)
    give_back(np.zeros(shape), before.base_rate, links, before.placed, before.carried, unused)
    give_back(
        equation.acceleration, np.zeros(unused.shape), links, before.placed, before.torque, unused
    )
    for i in range(shape[0]):
        for k in range(3):
            before.torque[i, k] += before.carried[i, k]


@without_allocation
def _pull(
    dt: float,
    springs: Springs,
    joints: Joints,
    actuation: Actuation,
    external: Array,
    torque: Array,
    equation: Equation,
) -> None:
    """Fill the torque (n, 3) [N m] of the springs for a step without acceleration, the right-hand
    side with the load of the step before, and the terms that the springs add to the inertia.
    """
    bend, v = actuation.bend, joints.v
    for i in range(len(v)):
        for k in range(3):
            bend[i, k] = min(max(bend[i, k], -STOP_ANGLE), STOP_ANGLE)
        stiffness = springs.stiffness[i]
        target = quaternion_product(springs.rest[i], quaternion_of_rotation(bend[i]))
        error = rotation_between(target, joints.q[i])
        elastic, here, at_rest = elastic_torque(error, bend[i, 1], stiffness, springs.stretching[i])
        for k in range(3):
            tangent = stiffness[k] * (here if k == 1 else 1.0)
            gas = actuation.gas[i, k] * (at_rest if k == 1 else 1.0)
            slack = springs.damping[i, k] + dt * gas
            torque[i, k] = elastic[k] - (dt * tangent + slack) * v[i, k]
            equation.added[i, k] = dt * (slack + dt * tangent)
            over = beyond_stop(bend[i, k] + error[k] + dt * v[i, k])
            if over != 0.0:
                torque[i, k] -= STOP_SHARE * stiffness[k] * over
                equation.added[i, k] += dt * dt * STOP_SHARE * stiffness[k]
            equation.right[i, k] = torque[i, k] + external[i, k]


@without_allocation
def _brake(dt: float, v: Array, stiffness: Array, torque: Array, equation: Equation) -> bool:
    """Add damping to the joints that would turn too far in a step; whether any was braked."""
    fastest, braked = min(max(BRAKE_ANGLE / dt, SLOWEST_BRAKE), FASTEST_BRAKE), False
    for i in range(len(v)):
        for k in range(3):
            after = v[i, k] + dt * equation.acceleration[i, k]
            if abs(after) > fastest:
                damping = BRAKE_TIME * stiffness[i, k]
                drag = damping * (v[i, k] - math.copysign(fastest, after))
                torque[i, k] -= drag
                equation.right[i, k] -= drag
                equation.added[i, k] += dt * damping
                braked = True
    return braked


@without_allocation
def look_at_joints(rest: Array, q: Array, v: Array, rotations: Array) -> float:
    """Fill `rotations` (n, 3) [rad], rotation vectors of the joints from their rest without
    pressure, and return the largest joint speed [rad/s] about an axis; NaN if a speed is NaN.
    """
    fastest = 0.0
    for i in range(len(rest)):
        write(rotation_between(rest[i], q[i]), rotations[i])
        for k in range(3):
            speed = abs(v[i, k])
            if speed > fastest or speed != speed:
                fastest = speed
    return fastest
