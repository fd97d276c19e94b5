"""Dynamics of serial chains of spherical joints, with a number of operations linear in the joints.

The solver is the articulated-body algorithm. Vectors are written in the axes of the chain's base
and referred to the origin of each joint, so that the motion subspace of a spherical joint is the
identity and no six-dimensional transform is needed. A spatial inertia is three matrices, angular A,
coupling B and linear C, in [A B; B^T C].
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softhand_common.numerics.compiled import compiled, without_allocation
from softhand_model.dynamics.spatial import (
    UNIT_MATRIX,
    ZERO,
    ZERO_MATRIX,
    Array,
    IntArray,
    Matrix,
    Row,
    Vector,
    apply,
    apply_transposed,
    cross,
    invert_symmetric,
    minus,
    minus_matrix,
    multiply,
    plus,
    plus_matrix,
    rotate_diagonal,
    rotation_matrix,
    rows,
    transposed,
    write,
    write_matrix,
)


class Links(NamedTuple):
    """The links of serial chains, one row per joint; chain f has the joints start[f]..start[f+1]-1.

    Attributes:
        start: (chains + 1,) index of the first joint of each chain.
        offset: (n, 3) [m] from the joint before, in the axes of the link before.
        center: (n, 3) [m] of mass from the joint, in the axes of the link.
        inertia: (n, 3) [kg m2], principal, about the centre of mass in the axes of the link.
        mass: (n,) [kg].
        given: (n, 3) [kg m2], the part of the inertia that is given back, see `give_back`.
    """

    start: IntArray
    offset: Array
    center: Array
    inertia: Array
    mass: Array
    given: Array


class Placed(NamedTuple):
    """Links placed by the orientations of their joints, in the axes of their chain's base.

    Attributes:
        frame: rotation matrices (n, 3, 3).
        arm: (n, 3) [m] from the joint before.
        center: (n, 3) [m] of mass from the joint.
        inertia: (n, 3, 3) [kg m2].
        given: (n, 3, 3) [kg m2], the part of it that is given back.
    """

    frame: Array
    arm: Array
    center: Array
    inertia: Array
    given: Array


class Equation(NamedTuple):
    """(M + diag(added)) acceleration = right, each (n, 3) in the joints' child axes; M is without
    the inertia that is given back.
    """

    added: Array
    right: Array
    acceleration: Array


class Folded(NamedTuple):
    """Articulated-body quantities of each joint after the pass from tip to base.

    Attributes:
        angular, coupling: (n, 3, 3), parts of the articulated inertia.
        inverse: (n, 3, 3), of the angular part plus the added inertia.
        torque: (n, 3) that remains for the joint.
    """

    angular: Array
    coupling: Array
    inverse: Array
    torque: Array


def not_placed(joints: int) -> Placed:
    """Empty arrays for `place_links` to fill."""
    turns, lines = np.zeros((3, joints, 3, 3)), np.zeros((2, joints, 3))
    return Placed(turns[0], lines[0], lines[1], turns[1], turns[2])


@without_allocation
def place_links(q: Array, links: Links, placed: Placed) -> None:
    """Forward kinematics: fill `placed` for orientations q (n, 4) of the joints, quaternions x, y,
    z, w.
    """
    for f in range(len(links.start) - 1):
        frame = UNIT_MATRIX
        for i in range(links.start[f], links.start[f + 1]):
            write(apply(frame, links.offset[i]), placed.arm[i])
            frame = multiply(frame, rotation_matrix(q[i]))
            write_matrix(frame, placed.frame[i])
            write(apply(frame, links.center[i]), placed.center[i])
            write_matrix(rotate_diagonal(frame, links.inertia[i]), placed.inertia[i])
            write_matrix(rotate_diagonal(frame, links.given[i]), placed.given[i])


@compiled
def give_back(
    rate: Array, base_rate: Array, links: Links, placed: Placed, out: Array, reaction: Array
) -> None:
    """Add to `out` (n, 3) the torques that accelerate the given inertia of the links at angular
    accelerations of the joints, (n, 3) in child axes, and of the chains' bases, (chains, 3)
    [rad/s2]; fill `reaction` (chains, 3) with the torques that the links take from their bases.

    Rates of absolute spin count: a link turns with its base and with all joints before it.
    """
    spins = np.empty(rate.shape)
    for f in range(len(links.start) - 1):
        first, last = links.start[f], links.start[f + 1]
        spin = (base_rate[f, 0], base_rate[f, 1], base_rate[f, 2])
        for i in range(first, last):
            spin = plus(spin, apply(rows(placed.frame[i]), rate[i]))
            write(spin, spins[i])
        moment = ZERO
        for i in range(last - 1, first - 1, -1):
            moment = plus(moment, apply(rows(placed.given[i]), spins[i]))
            own = apply_transposed(rows(placed.frame[i]), moment)
            for k in range(3):
                out[i, k] += own[k]
        write(moment, reaction[f])


@compiled
def inertial_torque(rate: Array, links: Links, placed: Placed, out: Array) -> None:
    """M @ rate of all chains, with rate and out (n, 3) in child axes, at joint velocities of
    zero.
    """
    force, moment = np.empty(rate.shape), np.empty(rate.shape)
    for f in range(len(links.start) - 1):
        first, last = links.start[f], links.start[f + 1]
        _load_links(first, last, rate, links.mass, placed, force, moment)
        for i in range(last - 1, first - 1, -1):
            write(apply_transposed(rows(placed.frame[i]), moment[i]), out[i])
            if i > first:
                handed = plus(moment[i], cross(placed.arm[i], force[i]))
                write(plus(force[i - 1], force[i]), force[i - 1])
                write(plus(moment[i - 1], handed), moment[i - 1])


@without_allocation
def _load_links(
    first: int, last: int, rate: Array, mass: Array, placed: Placed, force: Array, moment: Array
) -> None:
    """Fill force and moment (n, 3), about its joint, that each link of a chain needs for these
    rates.
    """
    spin, linear = ZERO, ZERO
    for i in range(first, last):
        own = apply(rows(placed.frame[i]), rate[i])
        if i > first:
            linear = plus(linear, cross(spin, placed.arm[i]))
            own = plus(own, spin)
        spin = own
        along = plus(linear, cross(spin, placed.center[i]))
        pull = (mass[i] * along[0], mass[i] * along[1], mass[i] * along[2])
        write(pull, force[i])
        of_spin = apply(rows(placed.inertia[i]), spin)
        write(plus(of_spin, cross(placed.center[i], pull)), moment[i])


@compiled
def not_folded(n: int) -> Folded:
    """Empty arrays of n joints for `solve_in` to fill."""
    return Folded(np.empty((n, 3, 3)), np.empty((n, 3, 3)), np.empty((n, 3, 3)), np.empty((n, 3)))


@compiled
def solve_chains(equation: Equation, links: Links, placed: Placed) -> None:
    """Solve an `Equation` for the acceleration of the placed links of all chains."""
    solve_in(not_folded(len(links.mass)), equation, links, placed)


@without_allocation
def solve_in(folded: Folded, equation: Equation, links: Links, placed: Placed) -> None:
    """As `solve_chains`, in arrays that are there."""
    for f in range(len(links.start) - 1):
        first, last = links.start[f], links.start[f + 1]
        _fold(first, last, equation, links.mass, placed, folded)
        accelerate(first, last, placed, folded, equation.acceleration)


@without_allocation
def _fold(
    first: int, last: int, equation: Equation, mass: Array, placed: Placed, folded: Folded
) -> None:
    """The pass of the algorithm from the tip to the base."""
    a, b, c = ZERO_MATRIX, ZERO_MATRIX, ZERO_MATRIX
    moment, force = ZERO, ZERO  # that the joints further out need
    for i in range(last - 1, first - 1, -1):
        light = minus_matrix(rows(placed.inertia[i]), rows(placed.given[i]))
        a, b, c = _add_link(mass[i], placed.center[i], light, a, b, c)
        frame, arm = rows(placed.frame[i]), placed.arm[i]
        s = invert_symmetric(plus_matrix(rotate_diagonal(frame, equation.added[i]), a))
        left = minus(apply(frame, equation.right[i]), moment)
        write_matrix(a, folded.angular[i])
        write_matrix(b, folded.coupling[i])
        write_matrix(s, folded.inverse[i])
        write(left, folded.torque[i])
        if i > first:
            sa, sb = multiply(s, a), multiply(s, b)
            force = plus_transposed(force, sb, left)
            moment = plus(plus_transposed(moment, sa, left), cross(arm, force))
            a, b, c = (
                minus_matrix(a, multiply(a, sa)),
                minus_matrix(b, multiply(a, sb)),
                minus_matrix(c, multiply(transposed(b), sb)),
            )
            a, b = shift_to_parent(arm, a, b, c)


@without_allocation
def plus_transposed(start: Vector, a: Matrix, vector: Vector) -> Vector:
    """start + a^T @ vector, summed in this order."""
    return (
        start[0] + a[0][0] * vector[0] + a[1][0] * vector[1] + a[2][0] * vector[2],
        start[1] + a[0][1] * vector[0] + a[1][1] * vector[1] + a[2][1] * vector[2],
        start[2] + a[0][2] * vector[0] + a[1][2] * vector[1] + a[2][2] * vector[2],
    )


@without_allocation
def _add_link(
    mass: float, com: Row, own: Matrix, a: Matrix, b: Matrix, c: Matrix
) -> tuple[Matrix, Matrix, Matrix]:
    """The spatial inertia [a b; b^T c] plus that of one link about its joint origin."""
    (axx, axy, axz), (ayx, ayy, ayz), (azx, azy, azz) = a
    (bxx, bxy, bxz), (byx, byy, byz), (bzx, bzy, bzz) = b
    (cxx, cxy, cxz), (cyx, cyy, cyz), (czx, czy, czz) = c
    square = mass * (com[0] * com[0] + com[1] * com[1] + com[2] * com[2])
    x, y, z = mass * com[0], mass * com[1], mass * com[2]
    about = ((axx + square, axy, axz), (ayx, ayy + square, ayz), (azx, azy, azz + square))
    shifted = (
        _minus_scaled(own[0], x, com),
        _minus_scaled(own[1], y, com),
        _minus_scaled(own[2], z, com),
    )
    return (
        plus_matrix(about, shifted),
        ((bxx, bxy - z, bxz + y), (byx + z, byy, byz - x), (bzx - y, bzy + x, bzz)),
        ((cxx + mass, cxy, cxz), (cyx, cyy + mass, cyz), (czx, czy, czz + mass)),
    )


@without_allocation
def _minus_scaled(row: Vector, factor: float, vector: Row) -> Vector:
    """row - factor * vector."""
    return row[0] - factor * vector[0], row[1] - factor * vector[1], row[2] - factor * vector[2]


@without_allocation
def shift_to_parent(r: Row, a: Matrix, b: Matrix, c: Matrix) -> tuple[Matrix, Matrix]:
    """Angular and coupling parts of the inertia [a b; b^T c], which is given about a joint at `r`,
    about the origin of its parent; the linear part stays c.

    With R the cross-product matrix of r: b'' = b + R c, a'' = a - b'' R + R b^T.
    """
    coupling = _plus_crossed(b, r, c)
    angular = _plus_crossed(a, r, transposed(b))
    crossed = (cross(coupling[0], r), cross(coupling[1], r), cross(coupling[2], r))
    return minus_matrix(angular, crossed), coupling


@without_allocation
def _plus_crossed(a: Matrix, r: Row, b: Matrix) -> Matrix:
    """a + R b, R the cross-product matrix of r."""
    return (
        _plus_two(a[0], -r[2], b[1], r[1], b[2]),
        _plus_two(a[1], r[2], b[0], -r[0], b[2]),
        _plus_two(a[2], -r[1], b[0], r[0], b[1]),
    )


@without_allocation
def _plus_two(row: Vector, f: float, a: Vector, g: float, b: Vector) -> Vector:
    """row + f * a + g * b."""
    return (
        row[0] + f * a[0] + g * b[0],
        row[1] + f * a[1] + g * b[1],
        row[2] + f * a[2] + g * b[2],
    )


@without_allocation
def accelerate(first: int, last: int, placed: Placed, folded: Folded, out: Array) -> None:
    """The pass of the algorithm from the base to the tip: fill `out` (n, 3) [rad/s2] with the
    accelerations of the joints from `first` to before `last`, in child axes.
    """
    torque, angular, coupling = folded.torque, folded.angular, folded.coupling
    spin, shift = ZERO, ZERO
    for i in range(first, last):
        if i > first:
            shift = plus(shift, cross(spin, placed.arm[i]))
        left = (
            _left(torque[i, 0], angular[i, 0], coupling[i, 0], spin, shift),
            _left(torque[i, 1], angular[i, 1], coupling[i, 1], spin, shift),
            _left(torque[i, 2], angular[i, 2], coupling[i, 2], spin, shift),
        )
        total = apply(rows(folded.inverse[i]), left)
        write(apply_transposed(rows(placed.frame[i]), total), out[i])
        spin = plus(spin, total)


@without_allocation
def _left(torque: float, angular: Array, coupling: Array, spin: Vector, shift: Vector) -> float:
    """A torque minus what the motion of the joints before takes of it; one row of both inertias."""
    for s in range(3):
        torque -= angular[s] * spin[s] + coupling[s] * shift[s]
    return torque
