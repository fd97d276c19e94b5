"""Implicit joint springs of serial chains of spherical joints, in a number of operations linear in
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

The solve is the articulated-body recursion with E = dt D + dt^2 (K + G) added to each joint's own
inertia. Vectors are written in the axes of the chain's base and referred to the origin of each
joint, so that the motion subspace of a spherical joint is the identity and no six-dimensional
transform is needed.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pneuflex_sim.elastic_kernel import elastic_torque
from pneuflex_sim.spatial import (
    apply,
    apply_transposed,
    cross,
    invert_symmetric,
    multiply,
    quaternion_of_rotation,
    quaternion_product,
    rotate_diagonal,
    rotation_between,
    rotation_matrix,
)
from softhand_model.compiled import compiled

Array = NDArray[np.float64]

STOP_ANGLE = 2.4  # [rad] of a joint from rest; at pi a rotation would turn over into its opposite
STOP_SHARE = 20.0  # stiffness of the stop over the joint's own
BRAKE_ANGLE = 0.2  # [rad] a joint may turn in a step before it is braked,
SLOWEST_BRAKE, FASTEST_BRAKE = 20.0, 50.0  # [rad/s] within these speeds
BRAKE_TIME = 0.3  # [s] damping of the brake over the joint's stiffness


@compiled
def place_joints(first, last, q, offset, com, inertia, frame, arm, center, world_inertia):
    """Forward kinematics of joints first..last-1 in base axes: frame (n,3,3), arm from the joint
    before, centre of mass, inertia.
    """
    turn, base = np.empty((3, 3)), np.eye(3)
    for i in range(first, last):
        before = frame[i - 1] if i > first else base
        apply(before, offset[i], arm[i])
        rotation_matrix(q[i], turn)
        multiply(before, turn, frame[i])
        apply(frame[i], com[i], center[i])
        rotate_diagonal(frame[i], inertia[i], world_inertia[i])


@compiled
def inertial_torque(first, last, rate, mass, frame, arm, center, world_inertia, out):
    """M @ rate for the placed joints: rate and out (n, 3) in child axes; joint velocities other
    than rate are zero.
    """
    count = last - first
    spin, force, moment = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros((count, 3))
    linear, work, lever = np.zeros(3), np.zeros(3), np.zeros(3)
    for k in range(count):
        i = first + k
        apply(frame[i], rate[i], work)
        if k > 0:
            cross(spin[k - 1], arm[i], lever)
            for a in range(3):
                linear[a] += lever[a]
                work[a] += spin[k - 1, a]
        for a in range(3):
            spin[k, a] = work[a]
        cross(spin[k], center[i], lever)
        for a in range(3):
            force[k, a] = mass[i] * (linear[a] + lever[a])
        apply(world_inertia[i], spin[k], work)
        cross(center[i], force[k], lever)
        for a in range(3):
            moment[k, a] = work[a] + lever[a]
    for k in range(count - 1, -1, -1):
        i = first + k
        apply_transposed(frame[i], moment[k], out[i])
        if k > 0:
            cross(arm[i], force[k], lever)
            for a in range(3):
                force[k - 1, a] += force[k, a]
                moment[k - 1, a] += moment[k, a] + lever[a]


@compiled
def _shift_to_parent(r, a, b, c, shifted, angular, coupling, linear):
    """Add the spatial inertia [a b; b^T c] of a joint origin at `r` to (angular, coupling, linear)
    at the parent's origin; `shifted` (3, 3) is room to work.

    With R the cross-product matrix of r: b'' = b + R c, a'' = a - b'' R + R b^T.
    """
    for j in range(3):
        shifted[0, j] = b[0, j] - r[2] * c[1, j] + r[1] * c[2, j]
        shifted[1, j] = b[1, j] + r[2] * c[0, j] - r[0] * c[2, j]
        shifted[2, j] = b[2, j] - r[1] * c[0, j] + r[0] * c[1, j]
    for j in range(3):
        angular[0, j] += a[0, j] - r[2] * b[j, 1] + r[1] * b[j, 2]
        angular[1, j] += a[1, j] + r[2] * b[j, 0] - r[0] * b[j, 2]
        angular[2, j] += a[2, j] - r[1] * b[j, 0] + r[0] * b[j, 1]
    for i in range(3):
        angular[i, 0] -= shifted[i, 1] * r[2] - shifted[i, 2] * r[1]
        angular[i, 1] -= shifted[i, 2] * r[0] - shifted[i, 0] * r[2]
        angular[i, 2] -= shifted[i, 0] * r[1] - shifted[i, 1] * r[0]
        for j in range(3):
            coupling[i, j] += shifted[i, j]
            linear[i, j] += c[i, j]


@compiled
def _link_inertia(mass, com, own, angular, coupling, linear):
    """Spatial inertia of one link about its joint origin, added to the three blocks."""
    square = com[0] * com[0] + com[1] * com[1] + com[2] * com[2]
    for i in range(3):
        linear[i, i] += mass
        angular[i, i] += mass * square
        for j in range(3):
            angular[i, j] += own[i, j] - mass * com[i] * com[j]
    coupling[0, 1] -= mass * com[2]
    coupling[0, 2] += mass * com[1]
    coupling[1, 0] += mass * com[2]
    coupling[1, 2] -= mass * com[0]
    coupling[2, 0] -= mass * com[1]
    coupling[2, 1] += mass * com[0]


@compiled
def _reduce(angular, coupling, linear, weighted, mixed, a, b, c):
    """What a joint of inverse S hands on of its inertia [A B; B^T C], with weighted = S A and mixed
    = S B: a = A - A S A, b = B - A S B, c = C - B^T S B.
    """
    for r in range(3):
        for s in range(3):
            a[r, s] = angular[r, s] - (
                angular[r, 0] * weighted[0, s]
                + angular[r, 1] * weighted[1, s]
                + angular[r, 2] * weighted[2, s]
            )
            b[r, s] = coupling[r, s] - (
                angular[r, 0] * mixed[0, s]
                + angular[r, 1] * mixed[1, s]
                + angular[r, 2] * mixed[2, s]
            )
            c[r, s] = linear[r, s] - (
                coupling[0, r] * mixed[0, s]
                + coupling[1, r] * mixed[1, s]
                + coupling[2, r] * mixed[2, s]
            )


@compiled
def solve_chains(start, added, right, mass, frame, arm, center, world_inertia, out):
    """Solve (M + diag(added)) out = right for the placed joints of all chains; chain f has the
    joints start[f]..start[f+1]-1. added, right and out (n, 3) in child axes.
    """
    n = len(mass)
    angular, coupling, linear = np.zeros((n, 3, 3)), np.zeros((n, 3, 3)), np.zeros((n, 3, 3))
    inverse, drive, bias = np.empty((n, 3, 3)), np.empty((n, 3)), np.zeros((n, 6))
    stiff, weighted, mixed = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    a, b, c, room = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    vector, lever = np.empty(3), np.empty(3)
    for f in range(len(start) - 1):
        for i in range(start[f + 1] - 1, start[f] - 1, -1):
            _link_inertia(mass[i], center[i], world_inertia[i], angular[i], coupling[i], linear[i])
            rotate_diagonal(frame[i], added[i], stiff)
            for r in range(3):
                for s in range(3):
                    stiff[r, s] += angular[i, r, s]
            invert_symmetric(stiff, inverse[i])
            apply(frame[i], right[i], vector)
            for r in range(3):
                drive[i, r] = vector[r] - bias[i, r]
            if i == start[f]:
                break
            multiply(inverse[i], angular[i], weighted)
            multiply(inverse[i], coupling[i], mixed)
            _reduce(angular[i], coupling[i], linear[i], weighted, mixed, a, b, c)
            _shift_to_parent(arm[i], a, b, c, room, angular[i - 1], coupling[i - 1], linear[i - 1])
            for r in range(3):  # bias force handed to the parent: p + U inverse drive
                value, force = bias[i, r], bias[i, 3 + r]
                for s in range(3):
                    value += weighted[s, r] * drive[i, s]
                    force += mixed[s, r] * drive[i, s]
                bias[i - 1, r] += value
                bias[i - 1, 3 + r] += force
                vector[r] = force
            cross(arm[i], vector, lever)
            for r in range(3):
                bias[i - 1, r] += lever[r]
        _accelerate(start[f], start[f + 1], inverse, drive, angular, coupling, frame, arm, out)


@compiled
def _accelerate(first, last, inverse, drive, angular, coupling, frame, arm, out):
    """The way back of the recursion, from the base to the tip."""
    spin, shift, total = np.zeros(3), np.zeros(3), np.empty(3)
    vector, lever = np.empty(3), np.empty(3)
    for i in range(first, last):
        if i > first:
            cross(spin, arm[i], lever)
            for r in range(3):
                shift[r] += lever[r]
        for r in range(3):
            vector[r] = drive[i, r]
            for s in range(3):
                vector[r] -= angular[i, r, s] * spin[s] + coupling[i, r, s] * shift[s]
        apply(inverse[i], vector, total)
        apply_transposed(frame[i], total, out[i])
        for r in range(3):
            spin[r] += total[r]


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
    error, target, turned = np.empty(3), np.empty(4), np.empty(4)
    external, change, elastic = np.zeros((n, 3)), np.empty((n, 3)), np.empty(3)
    right, added, acceleration = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
    for f in range(len(start) - 1):
        first, last = start[f], start[f + 1]
        if not first_step:
            for i in range(first, last):
                for k in range(3):
                    change[i, k] = (v[i, k] - v_before[i, k]) / dt
            inertial_torque(first, last, change, mass, frame, arm, center, world_inertia, external)
            for i in range(first, last):
                for k in range(3):
                    external[i, k] -= torque[i, k]
        place_joints(first, last, q, offset, com, inertia, frame, arm, center, world_inertia)
        for i in range(first, last):
            for k in range(3):
                bend[i, k] = min(max(bend[i, k], -STOP_ANGLE), STOP_ANGLE)
            quaternion_of_rotation(bend[i], turned)
            quaternion_product(rest[i], turned, target)
            rotation_between(target, q[i], error)
            here, at_rest = elastic_torque(error, bend[i, 1], stiffness[i], stretching[i], elastic)
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
    solve_chains(start, added, right, mass, frame, arm, center, world_inertia, acceleration)
    if _brake(n, dt, v, acceleration, stiffness, torque, right, added):
        solve_chains(start, added, right, mass, frame, arm, center, world_inertia, acceleration)
    for i in range(n):
        for k in range(3):
            torque[i, k] -= added[i, k] * acceleration[i, k]
            v_before[i, k] = v[i, k]


@compiled
def rotations_from_rest(rest, q, out):
    """Rotation vector (n, 3) [rad] of each joint against its rest orientation without pressure."""
    for i in range(len(q)):
        rotation_between(rest[i], q[i], out[i])


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
