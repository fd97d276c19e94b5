"""Implicit joint springs of serial chains of spherical joints, in a number of operations linear in
the joints.

One step solves, for each chain,

    (M(q) + dt D + dt^2 (K + G)) a = -K (e + dt v) - (D + dt G) v + f_ext
    torque = -K (e + dt (v + dt a)) - (D + dt G) (v + dt a)

with e the rotation vector of rest^-1 q, K and D the stiffness and damping about the axes of each
joint's child frame, G the stiffness of enclosed gas (it acts only on the motion within the step:
the pressure at the start of the step is already in `rest`), and f_ext all else that acted on the
joints in the step before, observed as M_prev (v - v_prev)/dt - torque_prev. At rest a = 0 and
torque = -K e whatever dt.

A joint meets a stiff stop before it could turn over into its opposite, and no pressure turns its
rest beyond that stop. Fingers that fold so far meet themselves, which the model leaves out.

The solve is the articulated-body recursion with E = dt D + dt^2 (K + G) added to each joint's own
inertia. Vectors are written in the axes of the chain's base and referred to the origin of each
joint, so that the motion subspace of a spherical joint is the identity and no six-dimensional
transform is needed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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
def _shift_to_parent(r, a, b, c, angular, coupling, linear):
    """Add the spatial inertia [a b; b^T c] of a joint origin at `r` to (angular, coupling, linear)
    at the parent's origin.
    """
    hat = np.zeros((3, 3))
    hat[0, 1], hat[0, 2], hat[1, 2] = -r[2], r[1], -r[0]
    hat[1, 0], hat[2, 0], hat[2, 1] = r[2], -r[1], r[0]
    shifted = np.empty((3, 3))
    for i in range(3):  # b'' = b + hat c
        for j in range(3):
            shifted[i, j] = (
                b[i, j] + hat[i, 0] * c[0, j] + hat[i, 1] * c[1, j] + hat[i, 2] * c[2, j]
            )
    for i in range(3):  # a'' = a - b'' hat + hat b^T
        for j in range(3):
            value = a[i, j]
            for k in range(3):
                value += hat[i, k] * b[j, k] - shifted[i, k] * hat[k, j]
            angular[i, j] += value
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
def solve_chain(first, last, added, right, mass, frame, arm, center, world_inertia, out):
    """Solve (M + diag(added)) out = right for the placed joints; added, right and out (n, 3) in
    child axes.
    """
    n = last - first
    angular, coupling, linear = np.zeros((n, 3, 3)), np.zeros((n, 3, 3)), np.zeros((n, 3, 3))
    inverse, drive, bias = np.empty((n, 3, 3)), np.empty((n, 3)), np.zeros((n, 6))
    stiff, weighted, mixed = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    a, b, c = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    vector, lever = np.empty(3), np.empty(3)
    for k in range(n - 1, -1, -1):
        i = first + k
        _link_inertia(mass[i], center[i], world_inertia[i], angular[k], coupling[k], linear[k])
        rotate_diagonal(frame[i], added[i], stiff)
        for r in range(3):
            for s in range(3):
                stiff[r, s] += angular[k, r, s]
        invert_symmetric(stiff, inverse[k])
        apply(frame[i], right[i], vector)
        for r in range(3):
            drive[k, r] = vector[r] - bias[k, r]
        if k == 0:
            break
        multiply(inverse[k], angular[k], weighted)
        multiply(inverse[k], coupling[k], mixed)
        for r in range(3):
            for s in range(3):
                a[r, s], b[r, s], c[r, s] = angular[k, r, s], coupling[k, r, s], linear[k, r, s]
                for t in range(3):
                    a[r, s] -= angular[k, r, t] * weighted[t, s]
                    b[r, s] -= angular[k, r, t] * mixed[t, s]
                    c[r, s] -= coupling[k, t, r] * mixed[t, s]
        _shift_to_parent(arm[i], a, b, c, angular[k - 1], coupling[k - 1], linear[k - 1])
        for r in range(3):  # bias force handed to the parent: p + U inverse drive
            value, force = bias[k, r], bias[k, 3 + r]
            for s in range(3):
                value += weighted[s, r] * drive[k, s]
                force += mixed[s, r] * drive[k, s]
            bias[k - 1, r] += value
            bias[k - 1, 3 + r] += force
            vector[r] = force
        cross(arm[i], vector, lever)
        for r in range(3):
            bias[k - 1, r] += lever[r]
    spin, shift, total = np.zeros(3), np.zeros(3), np.empty(3)
    for k in range(n):
        i = first + k
        if k > 0:
            cross(spin, arm[i], lever)
            for r in range(3):
                shift[r] += lever[r]
        for r in range(3):
            vector[r] = drive[k, r]
            for s in range(3):
                vector[r] -= angular[k, r, s] * spin[s] + coupling[k, r, s] * shift[s]
        apply(inverse[k], vector, total)
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
def spring_torques(
    dt,
    first_step,
    start,
    q,
    v,
    rest,
    bend,
    stiffness,
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
    (n,). `bend` is the rotation added to `rest` by actuation [rad]. Kept between steps and updated
    in place: v_before (n, 3), frame (n, 3, 3), arm (n, 3), center (n, 3), world_inertia (n, 3, 3),
    torque (n, 3) [N m], which is the result.
    """
    n = len(mass)
    error, target, turned = np.empty(3), np.empty(4), np.empty(4)
    external, change = np.zeros((n, 3)), np.empty((n, 3))
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
            for k in range(3):
                slack = damping[i, k] + dt * gas_stiffness[i, k]
                torque[i, k] = -stiffness[i, k] * (error[k] + dt * v[i, k]) - slack * v[i, k]
                added[i, k] = dt * (slack + dt * stiffness[i, k])
                over = _beyond_stop(bend[i, k] + error[k] + dt * v[i, k])
                if over != 0.0:
                    torque[i, k] -= STOP_SHARE * stiffness[i, k] * over
                    added[i, k] += dt * dt * STOP_SHARE * stiffness[i, k]
                right[i, k] = torque[i, k] + external[i, k]
        solve_chain(
            first, last, added, right, mass, frame, arm, center, world_inertia, acceleration
        )
        for i in range(first, last):
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
