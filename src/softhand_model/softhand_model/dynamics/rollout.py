"""Dynamics of serial chains of spherical joints on a base with prescribed motion, by an implicit
rule of second order.

A step h solves, for the accelerations a of the joints,

    (M(q') + s*D + s**2*K) a = -K e(q') - D v - b(q', v + s*a_before),   s = THETA*h,
    v <- v + h*a,   q <- q * exp(h*(v + s*a)),   q' = q * exp(s*v),

with e the rotation of the joints from their rest, and b what gravity, the base's motion and the
joints' own speeds ask for. It is the trapezoidal rule for THETA = 1/2, whose damped stiff modes
would ring from step to step; the little more makes them die.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softhand_common.numerics.compiled import compiled
from softhand_model.dynamics.chain import (
    Equation,
    Links,
    Placed,
    place_links,
    solve_chains,
)
from softhand_model.dynamics.joint_springs import Springs, elastic_torque
from softhand_model.dynamics.spatial import (
    ZERO,
    Array,
    apply,
    apply_transposed,
    cross,
    plus,
    quaternion_of_rotation,
    quaternion_product,
    rotation_between,
    rows,
    write,
)

THETA = 0.52


class Drive(NamedTuple):
    """Inputs of a chain in each step, evaluated at the share THETA of the step.

    Attributes:
        duration: (steps,) [s].
        bend: (steps, n, 3) [rad] that pressure adds to the rest of the joints.
        spin, rate: (steps, 3) [rad/s], [rad/s2] of the base, in its own axes.
        pull: (steps, 3) [m/s2] acceleration of the base's origin less that of gravity, in its axes.
    """

    duration: Array
    bend: Array
    spin: Array
    rate: Array
    pull: Array


@compiled
def bias_torque(
    v: Array, base: tuple[Array, Array, Array], links: Links, placed: Placed, out: Array
) -> None:
    """Fill `out` (n, 3) [N m], in child axes, with the torques that the placed links of one chain
    need at joint speeds v (n, 3) [rad/s] and zero joint accelerations.

    base: spin, rate and pull of one step of a `Drive`.
    """
    n = len(links.mass)
    force, moment = np.empty((n, 3)), np.empty((n, 3))
    spin, rate, pull = plus(base[0], ZERO), plus(base[1], ZERO), plus(base[2], ZERO)
    for i in range(n):
        arm = placed.arm[i]
        about = cross(spin, cross(spin, arm))
        pull = plus(pull, plus(cross(rate, arm), about))
        own = apply(rows(placed.frame[i]), v[i])
        rate = plus(rate, cross(spin, own))
        spin = plus(spin, own)
        center = placed.center[i]
        along = plus(pull, plus(cross(rate, center), cross(spin, cross(spin, center))))
        mass = links.mass[i]
        write((mass * along[0], mass * along[1], mass * along[2]), force[i])
        inertia = rows(placed.inertia[i])
        turning = plus(apply(inertia, rate), cross(spin, apply(inertia, spin)))
        write(plus(turning, cross(center, force[i])), moment[i])
    for i in range(n - 1, -1, -1):
        write(apply_transposed(rows(placed.frame[i]), moment[i]), out[i])
        if i > 0:
            handed = plus(moment[i], cross(placed.arm[i], force[i]))
            write(plus(force[i - 1], force[i]), force[i - 1])
            write(plus(moment[i - 1], handed), moment[i - 1])


@compiled
def roll_out(
    links: Links, springs: Springs, drive: Drive, kept: Array, q: Array, found: Array
) -> None:
    """Move one chain from rest at q (n, 4) through all steps of `drive`.

    kept (k,): rising numbers of steps. found (k, n, 4): is filled with the orientations of the
    joints before each of these steps; for a number equal to that of all steps, after the last one.
    """
    n = len(links.mass)
    v, before, torque = np.zeros((n, 3)), np.zeros((n, 3)), np.empty((n, 3))
    fast, ahead = np.empty((n, 3)), np.empty((n, 4))
    placed = Placed(
        np.empty((n, 3, 3)), np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3)),
        np.zeros((n, 3, 3)),
    )  # fmt: skip
    equation = Equation(np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3)))
    row = 0
    for step in range(len(drive.duration) + 1):
        while row < len(kept) and kept[row] == step:
            found[row] = q
            row += 1
        if step == len(drive.duration):
            break
        dt = drive.duration[step]
        s = THETA * dt
        for i in range(n):
            for k in range(3):
                fast[i, k] = v[i, k] + s * before[i, k]
            turn = quaternion_of_rotation((s * v[i, 0], s * v[i, 1], s * v[i, 2]))
            next_q = quaternion_product(q[i], turn)
            for k in range(4):
                ahead[i, k] = next_q[k]
        place_links(ahead, links, placed)
        base = drive.spin[step], drive.rate[step], drive.pull[step]
        bias_torque(fast, base, links, placed, torque)
        for i in range(n):
            bend = drive.bend[step, i]
            target = quaternion_product(springs.rest[i], quaternion_of_rotation(bend))
            error = rotation_between(target, ahead[i])
            elastic, here, _ = elastic_torque(
                error, bend[1], springs.stiffness[i], springs.stretching[i]
            )
            for k in range(3):
                tangent = springs.stiffness[i, k] * (here if k == 1 else 1.0)
                damping = springs.damping[i, k]
                equation.added[i, k] = s * damping + s * s * tangent
                equation.right[i, k] = elastic[k] - damping * v[i, k] - torque[i, k]
        solve_chains(equation, links, placed)
        for i in range(n):
            a = equation.acceleration[i]
            turn = quaternion_of_rotation(
                (
                    dt * (v[i, 0] + s * a[0]),
                    dt * (v[i, 1] + s * a[1]),
                    dt * (v[i, 2] + s * a[2]),
                )
            )
            next_q = quaternion_product(q[i], turn)
            for k in range(4):
                q[i, k] = next_q[k]
            for k in range(3):
                v[i, k] += dt * a[k]
                before[i, k] = a[k]
