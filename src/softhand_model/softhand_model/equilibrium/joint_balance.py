"""Rotation of a joint under a moment, compiled: see `joint_springs`."""

from __future__ import annotations

from typing import NamedTuple

from softhand_common.numerics.arrays import Array
from softhand_common.numerics.compiled import compiled
from softhand_common.numerics.triples import (
    IDENTITY_MATRIX,
    Matrix,
    Vector,
    apply,
    coefficients,
    cross,
    dot,
    inverse,
    largest,
    left_jacobian,
    minus,
    multiply,
    plus,
    scaled,
    transposed,
)
from softhand_model.hand.joint_stiffness import rubber_terms

JOINT_STEPS = 30
JOINT_TOLERANCE = 1e-13  # of the rotation [rad]
TABLE_REACH = 2.0  # [rad] from rest, up to which a factor is tabulated; beyond it is constant
TABLE_NODES = 41  # of its table on either side
BELOW_REST, ABOVE_REST = 0, 1  # sides of the rest


class SpringArrays(NamedTuple):
    """Springs at n points for compiled kernels, see `JointSprings`.

    stiffness, rest, sine and cosine of the rest: (joints, n). sideways (joints, 2), stretching
    (joints,), coupling (n,). factor (n, joints, 2, TABLE_NODES): on the stiffness, at equal
    distances below and above the rest; it has no points if there is no factor.
    """

    isotropic: bool
    stiffness: Array
    rest: Array
    sine: Array
    cosine: Array
    sideways: Array
    stretching: Array
    coupling: Array
    factor: Array


@compiled
def joint_rotation(springs: SpringArrays, joint: int, point: int, moment: Vector) -> Vector:
    """Rotation vector [rad] of a joint under a moment [N m], in the rest frame. joint, point:
    indices.

    An isotropic spring turns about the moment; any other balances K*e = J(e)^T moment, J the left
    Jacobian.
    """
    turn = scaled(1.0 / springs.stiffness[joint, point], moment)
    if springs.isotropic:
        return turn
    lateral, twist = springs.sideways[joint, 0], springs.sideways[joint, 1]
    turn = (turn[0] / lateral, turn[1], turn[2] / twist)
    per_residual, fresh, before = IDENTITY_MATRIX, False, 1.0
    for _ in range(JOINT_STEPS):
        residual = minus(_elastic(springs, joint, point, turn), pulled(turn, moment))
        if not fresh:
            per_residual, fresh = inverse(_slope(springs, joint, point, turn, moment)), True
        step = apply(per_residual, residual)
        turn = minus(turn, step)
        size = largest(step)
        if size * min(size / before, 1.0) < JOINT_TOLERANCE:  # what the next step would be
            break
        fresh = size <= 0.1 * before
        before = size
    return turn


@compiled
def compliance(
    springs: SpringArrays, joint: int, point: int, turn: Vector, moment: Vector
) -> Matrix:
    """Derivative [rad/(N m)] of the rotation vector [rad] by the moment [N m]."""
    if springs.isotropic:
        per_moment = 1.0 / springs.stiffness[joint, point]
        return ((per_moment, 0.0, 0.0), (0.0, per_moment, 0.0), (0.0, 0.0, per_moment))
    slope = _slope(springs, joint, point, turn, moment)
    return multiply(inverse(slope), transposed(left_jacobian(turn)))


@compiled
def _elastic(springs: SpringArrays, joint: int, point: int, turn: Vector) -> Vector:
    """K*e [N m]."""
    coupling = springs.coupling[point]
    x = springs.sideways[joint, 0] * turn[0] + coupling * turn[2]
    z = springs.sideways[joint, 1] * turn[2] + coupling * turn[0]
    y, _ = bending(springs, joint, point, turn[1])
    return scaled(springs.stiffness[joint, point], (x, y, z))


@compiled
def _slope(springs: SpringArrays, joint: int, point: int, turn: Vector, moment: Vector) -> Matrix:
    """Derivative of K*e - J^T moment by e."""
    stiffness, coupling = springs.stiffness[joint, point], springs.coupling[point]
    _, tangent = bending(springs, joint, point, turn[1])
    less = pulled_slope(turn, moment)
    x, z = springs.sideways[joint, 0], springs.sideways[joint, 1]
    return (
        minus(scaled(stiffness, (x, 0.0, coupling)), less[0]),
        minus(scaled(stiffness, (0.0, tangent, 0.0)), less[1]),
        minus(scaled(stiffness, (coupling, 0.0, z)), less[2]),
    )


@compiled
def bending(springs: SpringArrays, joint: int, point: int, bend: float) -> tuple[float, float]:
    """Moment over stiffness [rad] at a bend [rad] from rest, and its slope [-]."""
    moment, tangent = bend, 1.0
    gain = springs.stretching[joint]
    if gain > 0.0:
        rest = springs.rest[joint, point]
        here, slope = rubber_terms(1.0 + gain * (rest + bend))
        there, _ = rubber_terms(1.0 + gain * rest)
        moment, tangent = (here - there) / (2.0 * gain), 0.5 * slope
    if len(springs.factor) == 0:
        return moment, tangent
    factor, rise = _factor(
        springs.factor[point, joint, ABOVE_REST if bend >= 0.0 else BELOW_REST], bend
    )
    return moment * factor, tangent * factor + moment * rise


@compiled
def _factor(table: Array, bend: float) -> tuple[float, float]:
    """Factor [-] at a bend [rad] from rest and its slope [1/rad], by the cubic through four nodes
    of its side.
    """
    place = min(abs(bend) / TABLE_REACH, 1.0) * (TABLE_NODES - 1)
    if not place < TABLE_NODES - 1:  # or not a number
        return table[TABLE_NODES - 1], 0.0
    first = min(max(int(place) - 1, 0), TABLE_NODES - 4)
    a, b, c, d = table[first], table[first + 1], table[first + 2], table[first + 3]
    s = place - first
    linear, square, cube = b - a, 0.5 * (c - 2.0 * b + a), (d - 3.0 * c + 3.0 * b - a) / 6.0
    factor = a + s * (linear + (s - 1.0) * (square + (s - 2.0) * cube))
    rise = linear + (2.0 * s - 1.0) * square + (3.0 * s * s - 6.0 * s + 2.0) * cube
    return factor, rise * (TABLE_NODES - 1) / TABLE_REACH * (1.0 if bend >= 0.0 else -1.0)


@compiled
def pulled(turn: Vector, moment: Vector) -> Vector:
    """J(e)^T m, J the left Jacobian of rotation vectors: m - b*(e x m) + c*e x (e x m)."""
    b, c = coefficients(dot(turn, turn))
    across = cross(turn, moment)
    return plus(minus(moment, scaled(b, across)), scaled(c, cross(turn, across)))


@compiled
def pulled_slope(turn: Vector, moment: Vector) -> Matrix:
    """Derivative of J(e)^T m by e, with b and c as at e = 0 but for the first order.

    d(e x m) = -[m] de; d(e x (e x m)) = (e.m + e m^T - 2 m e^T) de; db = -e.de/12.
    """
    e, m, along, across = turn, moment, dot(turn, moment) / 6.0, cross(turn, moment)
    x, y, z = scaled(0.5, m)
    return (
        plus(_row(0, e, m, across), (along, -z, y)),
        plus(_row(1, e, m, across), (z, along, -x)),
        plus(_row(2, e, m, across), (-y, x, along)),
    )


@compiled
def _row(row: int, e: Vector, m: Vector, across: Vector) -> Vector:
    """A row of the terms of second order in the rotation."""
    by_moment, by_turn = e[row] / 6.0, across[row] / 12.0 - m[row] / 3.0
    return plus(scaled(by_moment, m), scaled(by_turn, e))
