"""Vectors, small rotations and 3 x 3 products for the compiled kernels.

All are tuples: vectors (x, y, z), quaternions (x, y, z, w), matrices of three rows. The compiler
keeps tuples in registers, while arrays would be allocated and could overlap. Vectors and
quaternions that are only read may also be rows of arrays. `rows` reads a matrix from an array;
`write` and `write_matrix` store results into one.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from softhand_common.numerics.compiled import without_allocation
from softhand_common.numerics.triples import apply as apply
from softhand_common.numerics.triples import cross, minus, plus
from softhand_common.numerics.triples import multiply as multiply
from softhand_common.numerics.triples import transposed as transposed

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Matrix = tuple[Vector, Vector, Vector]
Row = Array | Vector | Quaternion
QuaternionRow = Array | Quaternion

ZERO = (0.0, 0.0, 0.0)
ZERO_MATRIX = (ZERO, ZERO, ZERO)
UNIT_MATRIX = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@without_allocation
def rows(a: Array) -> Matrix:
    """The matrix in an array (3, 3)."""
    return (
        (a[0, 0], a[0, 1], a[0, 2]),
        (a[1, 0], a[1, 1], a[1, 2]),
        (a[2, 0], a[2, 1], a[2, 2]),
    )


@without_allocation
def write(vector: Vector, out: Array) -> None:
    """Put a vector into an array (3,)."""
    out[0], out[1], out[2] = vector


@without_allocation
def write_matrix(a: Matrix, out: Array) -> None:
    """Put a matrix into an array (3, 3)."""
    out[0, 0], out[0, 1], out[0, 2] = a[0]
    out[1, 0], out[1, 1], out[1, 2] = a[1]
    out[2, 0], out[2, 1], out[2, 2] = a[2]


@without_allocation
def rotation_matrix(q: QuaternionRow) -> Matrix:
    """The rotation matrix of the unit quaternion `q`."""
    x, y, z, w = q[0], q[1], q[2], q[3]
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )


@without_allocation
def quaternion_product(a: QuaternionRow, b: QuaternionRow) -> Quaternion:
    """The quaternion product a * b."""
    x = a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1]
    y = a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0]
    z = a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3]
    w = a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]
    return x, y, z, w


@without_allocation
def conjugate(q: QuaternionRow) -> Quaternion:
    """The inverse of the unit quaternion `q`."""
    return -q[0], -q[1], -q[2], q[3]


@without_allocation
def quaternion_of_rotation(rotation: Row) -> Quaternion:
    """The quaternion of a rotation vector (3,) [rad]."""
    angle = math.sqrt(rotation[0] ** 2 + rotation[1] ** 2 + rotation[2] ** 2)
    scale = 0.5 - angle * angle / 48 if angle < 1e-4 else math.sin(0.5 * angle) / angle
    return scale * rotation[0], scale * rotation[1], scale * rotation[2], math.cos(0.5 * angle)


@without_allocation
def rotation_between(reference: QuaternionRow, q: QuaternionRow) -> Vector:
    """The rotation vector (3,) [rad] of reference^-1 * q, angle within (-pi, pi]."""
    rx, ry, rz, rw = reference[0], reference[1], reference[2], reference[3]
    ex = rw * q[0] - rx * q[3] - ry * q[2] + rz * q[1]
    ey = rw * q[1] + rx * q[2] - ry * q[3] - rz * q[0]
    ez = rw * q[2] - rx * q[1] + ry * q[0] - rz * q[3]
    ew = rw * q[3] + rx * q[0] + ry * q[1] + rz * q[2]
    norm = math.sqrt(ex * ex + ey * ey + ez * ez)
    factor = 2.0 if norm < 1e-9 else 2 * math.atan2(norm, abs(ew)) / norm
    if ew < 0:
        factor = -factor
    return factor * ex, factor * ey, factor * ez


@without_allocation
def apply_transposed(a: Matrix, vector: Row) -> Vector:
    """The vector a^T @ vector."""
    return (
        a[0][0] * vector[0] + a[1][0] * vector[1] + a[2][0] * vector[2],
        a[0][1] * vector[0] + a[1][1] * vector[1] + a[2][1] * vector[2],
        a[0][2] * vector[0] + a[1][2] * vector[1] + a[2][2] * vector[2],
    )


@without_allocation
def plus_matrix(a: Matrix, b: Matrix) -> Matrix:
    """The sum a + b."""
    return plus(a[0], b[0]), plus(a[1], b[1]), plus(a[2], b[2])


@without_allocation
def minus_matrix(a: Matrix, b: Matrix) -> Matrix:
    """The difference a - b."""
    return minus(a[0], b[0]), minus(a[1], b[1]), minus(a[2], b[2])


@without_allocation
def rotate_diagonal(rotation: Matrix, diagonal: Row) -> Matrix:
    """The symmetric matrix rotation @ diag(diagonal) @ rotation^T."""
    a, b, c = rotation
    xy, xz, yz = _weighted(b, diagonal, a), _weighted(c, diagonal, a), _weighted(c, diagonal, b)
    xx, yy, zz = _weighted(a, diagonal, a), _weighted(b, diagonal, b), _weighted(c, diagonal, c)
    return (xx, xy, xz), (xy, yy, yz), (xz, yz, zz)


@without_allocation
def _weighted(a: Vector, weights: Row, b: Vector) -> float:
    """The scalar product of a and b with a weight on each component."""
    return a[0] * weights[0] * b[0] + a[1] * weights[1] * b[1] + a[2] * weights[2] * b[2]


@without_allocation
def invert_symmetric(a: Matrix) -> Matrix:
    """The inverse of a symmetric positive definite matrix."""
    xx = a[1][1] * a[2][2] - a[1][2] * a[1][2]
    xy = a[0][2] * a[1][2] - a[0][1] * a[2][2]
    xz = a[0][1] * a[1][2] - a[0][2] * a[1][1]
    yy = a[0][0] * a[2][2] - a[0][2] * a[0][2]
    yz = a[0][1] * a[0][2] - a[0][0] * a[1][2]
    zz = a[0][0] * a[1][1] - a[0][1] * a[0][1]
    scale = 1.0 / (a[0][0] * xx + a[0][1] * xy + a[0][2] * xz)
    return (
        (scale * xx, scale * xy, scale * xz),
        (scale * xy, scale * yy, scale * yz),
        (scale * xz, scale * yz, scale * zz),
    )


@without_allocation
def rotate(q: QuaternionRow, vector: Row) -> Vector:
    """The vector (3,) turned by the unit quaternion `q`."""
    half = cross(q, vector)
    first = (2 * half[0], 2 * half[1], 2 * half[2])
    second = cross(q, first)
    return (
        vector[0] + q[3] * first[0] + second[0],
        vector[1] + q[3] * first[1] + second[1],
        vector[2] + q[3] * first[2] + second[2],
    )
