"""Implicit joint springs of serial chains of spherical joints, in a number of operations linear
in the joints.

Linear: the energy is e*K*e/2, e the rotation vector of the joint against its rest. Rubber (eq.
3.24) in bending: with u = 1 + s*bend the stretch of the top, moment k*(q(u) - q(u_rest))/(2*s), q =
u - u**-3, in place of k*e_y: 2*k of a straight joint, k/2 of one bent far.

Implicit joint springs of serial chains of spherical joints, in a number of operations linear in
the joints.

One step solves, for each chain,

    (M(q) + dt D + dt^2 (K + G)) a = -K (e + dt v) - (D + dt G) v + f_ext
    torque = -K (e + dt (v + dt a)) - (D + dt G) (v + dt a)

with e the rotation vector of rest^-1 q, K and D the stiffness and damping about the axes of each
joint's child frame, G the stiffness of enclosed gas (it acts only on the motion within the step:
the pressure at the start of the step is already in `rest`), and f_ext all else that acted on the
joints in the step before, observed as M_prev (v - v_prev)/dt - torque_prev. At rest a = 0 and
torque = -K e whatever dt. Where K is not the same about all axes, or not constant, -K e stands for
the torque of `elastic_kernel`, and K within the step for its tangent.

A joint meets a stiff stop before it could turn over into its opposite, and no pressure turns its
rest beyond that stop. Fingers that fold so far meet themselves, which the model leaves out. A joint
that would turn farther in a step than can be integrated is braked; only blows make one so fast.

`chain_kernel` solves it, with dt D + dt^2 (K + G) added to each joint's own inertia.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pneuflex_sim.dynamics.chain import inertial_torque, place_joints, solve_chains
from pneuflex_sim.dynamics.spatial import (
    cross,
    quaternion_of_rotation,
    quaternion_product,
    rotation_between,
    write,
)
from softhand_model.hand.joint_stiffness import LEAST_STRETCH
from softhand_model.numerics.compiled import compiled

SMALL_ANGLE = 1e-2  # [rad], below which series stand for the rotation's Jacobian


@compiled
def rubber_stress(stretch):
    """`joint_stiffness.rubber_stress` of one joint: elastic term and slope [-] at a stretch [-]."""
    least = max(stretch, LEAST_STRETCH)
    inverse = 1.0 / least
    cube = inverse * inverse * inverse
    slope = 1.0 + 3.0 * cube * inverse
    return least - cube + slope * (stretch - least), slope


@compiled
def elastic_torque(error, rest_bend, stiffness, stretching):
    """Torque (3,) [N m] of a joint's spring on its child, in the child's axes, at a rotation
    `error` (3,) [rad] from a rest bent by rest_bend [rad]; and factors on the stiffness in bending:
    of its tangent here and in the rest shape.

    It is minus the gradient of the energy: the transposed inverse of the rotation's right Jacobian
    times K*e, K*e - e x K*e/2 + c*e x (e x K*e).
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


Array = NDArray[np.float64]

STOP_ANGLE = 2.4  # [rad] of a joint from rest; at pi a rotation would turn over into its opposite
STOP_SHARE = 20.0  # stiffness of the stop over the joint's own
BRAKE_ANGLE = 0.2  # [rad] a joint may turn in a step before it is braked,
SLOWEST_BRAKE, FASTEST_BRAKE = 20.0, 50.0  # [rad/s] within these speeds
BRAKE_TIME = 0.3  # [s] damping of the brake over the joint's stiffness


@compiled
def _beyond_stop(angle):
    """How far [rad] a rotation from rest is beyond the stop; 0 within."""
    if angle > STOP_ANGLE:
        return angle - STOP_ANGLE
    return min(0.0, angle + STOP_ANGLE)


@compiled
def _brake(n, dt, v, acceleration, stiffness, torque, right, added):
    """Add damping to the joints that would turn too far in a step; whether there are any."""
    fastest, braked = min(max(BRAKE_ANGLE / dt, SLOWEST_BRAKE), FASTEST_BRAKE), False
    for i in range(n):
        for k in range(3):
            after = v[i, k] + dt * acceleration[i, k]
            if abs(after) > fastest:
                damping = BRAKE_TIME * stiffness[i, k]
                drag = damping * (v[i, k] - math.copysign(fastest, after))
                torque[i, k] -= drag
                right[i, k] -= drag
                added[i, k] += dt * damping
                braked = True
    return braked


@compiled
def spring_torques(
    dt,
    first_step,
    start,
    q,
    v,
    rest,
    bend,
    stiffness,
    stretching,
    gas_stiffness,
    damping,
    offset,
    com,
    inertia,
    mass,
    v_before,
    frame,
    arm,
    center,
    world_inertia,
    torque,
):
    """One implicit step of all chains; joints of chain f are start[f]..start[f+1]-1.

    q, rest (n, 4); v, bend, stiffness, gas_stiffness, damping, offset, com, inertia (n, 3); mass
    (n,). `bend` is the rotation added to `rest` by actuation [rad], `stretching` (n,) [1/rad] that
    of the top with the bend of rubber, 0 for linear springs. Kept between steps and updated
    in place: v_before (n, 3), frame (n, 3, 3), arm (n, 3), center (n, 3), world_inertia (n, 3, 3),
    torque (n, 3) [N m], which is the result.
    """
    n = len(mass)
    external, right, added = np.zeros((n, 3)), np.empty((n, 3)), np.empty((n, 3))
    acceleration = np.empty((n, 3))
    placed = (frame, arm, center, world_inertia)
    if not first_step:
        _external_torque(dt, start, v, v_before, mass, placed, torque, external)
    for f in range(len(start) - 1):
        place_joints(start[f], start[f + 1], q, offset, com, inertia, *placed)
    _pull(
        n,
        dt,
        q,
        v,
        rest,
        bend,
        stiffness,
        stretching,
        gas_stiffness,
        damping,
        external,
        torque,
        right,
        added,
    )
    solve_chains(start, added, right, mass, frame, arm, center, world_inertia, acceleration)
    if _brake(n, dt, v, acceleration, stiffness, torque, right, added):
        solve_chains(start, added, right, mass, frame, arm, center, world_inertia, acceleration)
    for i in range(n):
        for k in range(3):
            torque[i, k] -= added[i, k] * acceleration[i, k]
            v_before[i, k] = v[i, k]


@compiled
def _external_torque(dt, start, v, v_before, mass, placed, torque, out):
    """What acted on the joints (n, 3) in the step before besides `torque`."""
    rate = (v - v_before) / dt
    for f in range(len(start) - 1):
        inertial_torque(start[f], start[f + 1], rate, mass, *placed, out)
    out -= torque


@compiled
def _pull(
    n,
    dt,
    q,
    v,
    rest,
    bend,
    stiffness,
    stretching,
    gas_stiffness,
    damping,
    external,
    torque,
    right,
    added,
):
    """Torque (n, 3) of the springs in a step without acceleration, the right-hand side with the
    load of the step before, and what the springs add to the inertia.
    """
    for i in range(n):
        for k in range(3):
            bend[i, k] = min(max(bend[i, k], -STOP_ANGLE), STOP_ANGLE)
        target = quaternion_product(rest[i], quaternion_of_rotation(bend[i]))
        error = rotation_between(target, q[i])
        elastic, here, at_rest = elastic_torque(error, bend[i, 1], stiffness[i], stretching[i])
        for k in range(3):
            tangent = stiffness[i, k] * (here if k == 1 else 1.0)
            gas = gas_stiffness[i, k] * (at_rest if k == 1 else 1.0)
            slack = damping[i, k] + dt * gas
            torque[i, k] = elastic[k] - (dt * tangent + slack) * v[i, k]
            added[i, k] = dt * (slack + dt * tangent)
            over = _beyond_stop(bend[i, k] + error[k] + dt * v[i, k])
            if over != 0.0:
                torque[i, k] -= STOP_SHARE * stiffness[i, k] * over
                added[i, k] += dt * dt * STOP_SHARE * stiffness[i, k]
            right[i, k] = torque[i, k] + external[i, k]


@compiled
def rotations_from_rest(rest, q, out):
    """Rotation vector (n, 3) [rad] of each joint against its rest orientation without pressure."""
    for i in range(len(q)):
        write(rotation_between(rest[i], q[i]), out[i])


@compiled
def look_at_joints(rest, q, v, out):
    """`rotations_from_rest`, and the greatest joint speed [rad/s] about an axis; not a number where
    one is not.
    """
    rotations_from_rest(rest, q, out)
    fastest = 0.0
    for i in range(len(v)):
        for k in range(3):
            speed = abs(v[i, k])
            if not speed <= fastest:
                fastest = speed
                if speed != speed:
                    return speed
    return fastest
