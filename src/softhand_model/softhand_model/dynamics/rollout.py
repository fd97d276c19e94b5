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

from softhand_common.numerics.compiled import compiled, without_allocation
from softhand_model.dynamics.chain import (
    Equation,
    Folded,
    Links,
    Placed,
    not_folded,
    place_links,
    solve_in,
)
from softhand_model.dynamics.joint_springs import Springs, elastic_torque
from softhand_model.dynamics.spatial import (
    ZERO,
    Array,
    Quaternion,
    QuaternionRow,
    Row,
    Vector,
    apply,
    apply_transposed,
    conjugate,
    cross,
    plus,
    quaternion_of_rotation,
    quaternion_product,
    rotation_between,
    rows,
    write,
)

THETA = 0.52
SERIES_ANGLE = 0.5  # [rad] of a rotation up to which series are exact to the last digits,
SERIES_TANGENT = 0.1  # and tangent of half an angle


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


class Working(NamedTuple):
    """Arrays that a step fills: speeds, accelerations of the step before, torques, forces and
    moments (n, 3), and orientations (n, 4), all of joints.
    """

    v: Array
    before: Array
    fast: Array
    torque: Array
    force: Array
    moment: Array
    ahead: Array


@without_allocation
def turn_of(rotation: Row) -> Quaternion:
    """As `quaternion_of_rotation`, by series where the angle is small, as it is in each step."""
    square = rotation[0] * rotation[0] + rotation[1] * rotation[1] + rotation[2] * rotation[2]
    if square > SERIES_ANGLE * SERIES_ANGLE:
        return quaternion_of_rotation(rotation)
    s = 0.25 * square  # of half the angle
    sine = 1.0 - s / 6.0 * (
        1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0 * (1.0 - s / 110.0)))
    )
    cosine = 1.0 - s / 2.0 * (
        1.0 - s / 12.0 * (1.0 - s / 30.0 * (1.0 - s / 56.0 * (1.0 - s / 90.0 * (1.0 - s / 132.0))))
    )
    scale = 0.5 * sine
    return scale * rotation[0], scale * rotation[1], scale * rotation[2], cosine


@without_allocation
def error_from(reference: QuaternionRow, q: QuaternionRow) -> Vector:
    """As `rotation_between`, by a series where the angle is small."""
    e = quaternion_product(conjugate(reference), q)
    square = e[0] * e[0] + e[1] * e[1] + e[2] * e[2]
    if square > (SERIES_TANGENT * e[3]) ** 2:
        return rotation_between(reference, q)
    s = square / (e[3] * e[3])
    rest = 1 / 9 - s * (1 / 11 - s * (1 / 13 - s / 15))
    factor = 2.0 / e[3] * (1.0 - s * (1 / 3 - s * (1 / 5 - s * (1 / 7 - s * rest))))
    return factor * e[0], factor * e[1], factor * e[2]


@without_allocation
def bias_torque(
    v: Array,
    base: tuple[Array, Array, Array],
    links: Links,
    placed: Placed,
    force: Array,
    moment: Array,
    out: Array,
) -> None:
    """Fill `out` (n, 3) [N m], in child axes, with the torques that the placed links of one chain
    need at joint speeds v (n, 3) [rad/s] and zero joint accelerations.

    base: spin, rate and pull of one step of a `Drive`. force, moment (n, 3): are overwritten.
    """
    n = len(links.mass)
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
    placed = Placed(
        np.empty((n, 3, 3)), np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3)),
        np.zeros((n, 3, 3)),
    )  # fmt: skip
    equation = Equation(np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3)))
    now, out = np.zeros((2, n, 3)), np.empty((4, n, 3))
    working = Working(now[0], now[1], out[0], out[1], out[2], out[3], np.empty((n, 4)))
    folded = not_folded(n)
    _steps(links, springs, drive, kept, q, found, placed, equation, folded, working)


@without_allocation
def _steps(
    links: Links,
    springs: Springs,
    drive: Drive,
    kept: Array,
    q: Array,
    found: Array,
    placed: Placed,
    equation: Equation,
    folded: Folded,
    working: Working,
) -> None:
    """The steps of `roll_out`, which allocate nothing."""
    n, v, before, fast, ahead = (
        len(links.mass), working.v, working.before, working.fast, working.ahead
    )  # fmt: skip
    torque, row = working.torque, 0
    for step in range(len(drive.duration) + 1):
        while row < len(kept) and kept[row] == step:
            for i in range(n):
                for k in range(4):
                    found[row, i, k] = q[i, k]
            row += 1
        if step == len(drive.duration):
            break
        dt = drive.duration[step]
        s = THETA * dt
        for i in range(n):
            for k in range(3):
                fast[i, k] = v[i, k] + s * before[i, k]
            turn = turn_of((s * v[i, 0], s * v[i, 1], s * v[i, 2]))
            next_q = quaternion_product(q[i], turn)
            for k in range(4):
                ahead[i, k] = next_q[k]
        place_links(ahead, links, placed)
        base = drive.spin[step], drive.rate[step], drive.pull[step]
        bias_torque(fast, base, links, placed, working.force, working.moment, torque)
        for i in range(n):
            bend = drive.bend[step, i]
            target = quaternion_product(springs.rest[i], turn_of(bend))
            error = error_from(target, ahead[i])
            elastic, here, _ = elastic_torque(
                error, bend[1], springs.stiffness[i], springs.stretching[i]
            )
            for k in range(3):
                tangent = springs.stiffness[i, k] * (here if k == 1 else 1.0)
                damping = springs.damping[i, k]
                equation.added[i, k] = s * damping + s * s * tangent
                equation.right[i, k] = elastic[k] - damping * v[i, k] - torque[i, k]
        solve_in(folded, equation, links, placed)
        for i in range(n):
            a = equation.acceleration[i]
            turn = turn_of(
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
