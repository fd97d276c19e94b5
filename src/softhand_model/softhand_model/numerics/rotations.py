"""Vectors and rotations, single ones and at many points at once.

Quaternions are (x, y, z, w). At many points vectors are (3, n), k vectors a point (3, k, n) and
matrices (3, 3, n): the points lie last, so that each operation runs along contiguous memory.
"""

from __future__ import annotations

import math
from math import factorial

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from softhand_model.numerics.arrays import Array
from softhand_model.numerics.compiled import compiled


def from_rpy(rpy: ArrayLike) -> Array:
    """Quaternion (4,) of roll, pitch, yaw [rad] about fixed x, y, z, as in URDF.

    >>> from_rpy([0.0, 0.0, np.pi]).round(3).tolist()
    [0.0, 0.0, 1.0, 0.0]
    """
    return np.asarray(Rotation.from_euler("xyz", np.asarray(rpy, float)).as_quat(), float)


def about_x(angle: float) -> Array:
    """Quaternion (4,) of a rotation by `angle` [rad] about x."""
    return np.array([np.sin(angle / 2.0), 0.0, 0.0, np.cos(angle / 2.0)])


def rotate(quaternion: ArrayLike, vectors: ArrayLike) -> Array:
    """Vectors (..., 3) turned by a quaternion (4,); raises ValueError when that is zero."""
    turned = np.asarray(vectors, float)
    return _rotated(_unit(_rows(quaternion))[0], turned.reshape(-1, 3)).reshape(turned.shape)


def compose(*quaternions: ArrayLike) -> Array:
    """Product of quaternions (4,) or (n, 4), the rightmost applied first, of unit length; raises
    ValueError when one is zero.
    """
    product = _unit(_rows(quaternions[0]))
    for quaternion in quaternions[1:]:
        product = _composed(product, _unit(_rows(quaternion)))
    return product if any(np.ndim(q) == 2 for q in quaternions) else product[0]


def _rows(quaternions: ArrayLike) -> Array:
    return np.ascontiguousarray(quaternions, dtype=float).reshape(-1, 4)


@compiled
def _unit(quaternions: Array) -> Array:
    """Quaternions (n, 4) of length 1."""
    result = np.empty_like(quaternions)
    for i in range(len(quaternions)):
        x, y, z, w = quaternions[i]
        length = math.sqrt(x * x + y * y + z * z + w * w)
        if length == 0.0:
            raise ValueError("quaternion: expected one that is not zero")
        for k in range(4):
            result[i, k] = quaternions[i, k] / length
    return result


@compiled
def _rotated(quaternion: Array, vectors: Array) -> Array:
    """v + 2 w (u x v) + 2 u x (u x v) with the quaternion's vector u, for vectors (n, 3)."""
    ux, uy, uz, w = quaternion
    result = np.empty_like(vectors)
    for i in range(len(vectors)):
        x, y, z = vectors[i]
        tx, ty, tz = 2.0 * (uy * z - uz * y), 2.0 * (uz * x - ux * z), 2.0 * (ux * y - uy * x)
        result[i, 0] = x + w * tx + (uy * tz - uz * ty)
        result[i, 1] = y + w * ty + (uz * tx - ux * tz)
        result[i, 2] = z + w * tz + (ux * ty - uy * tx)
    return result


@compiled
def _composed(first: Array, second: Array) -> Array:
    """Products of quaternions (n, 4), (m, 4), with n and m equal, or one of them 1."""
    n, m = len(first), len(second)
    if n != m and n != 1 and m != 1:
        raise ValueError("quaternions: expected one, or as many of each")
    result = np.empty((max(n, m), 4))
    for i in range(len(result)):
        x1, y1, z1, w1 = first[i if n > 1 else 0]
        x2, y2, z2, w2 = second[i if m > 1 else 0]
        result[i, 0] = w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2
        result[i, 1] = w1 * y2 + y1 * w2 + z1 * x2 - x1 * z2
        result[i, 2] = w1 * z2 + z1 * w2 + x1 * y2 - y1 * x2
        result[i, 3] = w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2
    return result


SMALL_SQUARE = 0.5  # [rad2] below which the coefficients come from their series
TERMS = 8  # of the series: exact to rounding
# (TERMS, 2, 1): of b and c
COEFFICIENTS = np.array(
    [[[(-1) ** k / factorial(2 * k + more)] for more in (2, 3)] for k in range(TERMS)]
)
# largest square (TERMS - 1,) for which 1, 2, ... terms are exact to rounding
ENOUGH = np.array([(1e-17 * factorial(2 * k + 2) / 2) ** (1 / k) for k in range(1, TERMS)])


def cross(first: Array, second: Array) -> Array:
    """Cross product along the first axis; the others broadcast.

    >>> cross(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])).tolist()
    [0.0, 0.0, 1.0]
    """
    (ax, ay, az), (bx, by, bz) = first, second
    result = np.empty((3, *np.broadcast_shapes(first.shape[1:], second.shape[1:])))
    terms = ((ay, bz, az, by), (az, bx, ax, bz), (ax, by, ay, bx))
    for index, (p, q, r, s) in enumerate(terms):
        out = result[index, ...]
        np.multiply(p, q, out=out)
        out -= r * s
    return result


def turned(matrix: Array, vector: Array) -> Array:
    """Matrix (3, 3, n) times vectors (3, n) or (3, k, n)."""
    if vector.ndim > matrix.ndim - 1:
        matrix = matrix[:, :, None]
    return matrix[:, 0] * vector[0] + matrix[:, 1] * vector[1] + matrix[:, 2] * vector[2]


def turned_back(matrix: Array, vector: Array) -> Array:
    """Transpose of a matrix (3, 3, n) times vectors (3, n)."""
    return matrix[0] * vector[0] + matrix[1] * vector[1] + matrix[2] * vector[2]


def product(first: Array, second: Array) -> Array:
    """Product of matrices (3, 3, n)."""
    return (
        first[:, 0, None] * second[None, 0]
        + first[:, 1, None] * second[None, 1]
        + first[:, 2, None] * second[None, 2]
    )


def transposed(matrix: Array) -> Array:
    """Transpose of matrices (3, 3, n)."""
    return np.swapaxes(matrix, 0, 1)


def identity(points: int) -> Array:
    """Identity matrices (3, 3, n)."""
    return np.repeat(np.eye(3)[:, :, None], points, axis=2)


def cross_matrix(vector: Array) -> Array:
    """Matrices (3, 3, n) of the cross product by vectors (3, n)."""
    x, y, z = vector
    zero = np.zeros_like(x)
    return np.stack([np.stack([zero, -z, y]), np.stack([z, zero, -x]), np.stack([-y, x, zero])])


def inverse(matrix: Array) -> Array:
    """Inverse of matrices (3, 3, n)."""
    rows = np.stack([cross(matrix[1], matrix[2]), cross(matrix[2], matrix[0])])
    cofactors = np.concatenate([rows, cross(matrix[0], matrix[1])[None]])
    determinant = np.sum(matrix[0] * cofactors[0], axis=0)
    return transposed(cofactors) / determinant


def exponentials(vector: Array) -> tuple[Array, Array]:
    """Rotations (3, 3, n) of rotation vectors (3, n) [rad], and their left Jacobians.

    With J the Jacobian, exp(v + dv) = exp(J dv) exp(v) to first order: J = 1 + b*[v] + c*[v]**2.
    """
    square = np.sum(vector * vector, axis=0)
    b, c = jacobian_coefficients(square)
    return _quadratic(vector, square, 1.0 - square * c, b), _quadratic(vector, square, b, c)


def rotations(vector: Array) -> Array:
    """Rotations (3, 3, n) of rotation vectors (3, n) [rad]."""
    square = np.sum(vector * vector, axis=0)
    b, c = jacobian_coefficients(square)
    return _quadratic(vector, square, 1.0 - square * c, b)


def jacobian_coefficients(square: Array) -> tuple[Array, Array]:
    """b = (1 - cos t)/t**2 and c = (t - sin t)/t**3 of squared angles t**2 (n,) [rad2]."""
    largest = square.max(initial=0.0)
    if largest < SMALL_SQUARE:
        b, c = _series(square, int(np.searchsorted(ENOUGH, largest)) + 1)
        return b, c
    angle = np.sqrt(np.maximum(square, SMALL_SQUARE))
    sine, cosine = np.sin(angle), np.cos(angle)
    small = square < SMALL_SQUARE
    near = _series(np.where(small, square, 0.0), TERMS)
    b = np.where(small, near[0], (1.0 - cosine) / angle**2)
    c = np.where(small, near[1], (angle - sine) / angle**3)
    return b, c


def _series(square: Array, terms: int) -> Array:
    """Series (2, n) of b and c: 1/2 - t**2/24 + ... and 1/6 - t**2/120 + ..."""
    total = np.empty((2, *square.shape))
    total[:] = COEFFICIENTS[terms - 1]
    for coefficients in COEFFICIENTS[terms - 2 :: -1] if terms > 1 else ():
        total *= square
        total += coefficients
    return total


def _quadratic(vector: Array, square: Array, first: Array, second: Array) -> Array:
    """1 + first*[v] + second*[v]**2, with [v] the matrix of the cross product by v."""
    x, y, z = first * vector
    matrix = second * vector[:, None] * vector[None, :]
    diagonal = 1.0 - second * square
    matrix[0, 0] += diagonal
    matrix[1, 1] += diagonal
    matrix[2, 2] += diagonal
    matrix[0, 1] -= z
    matrix[1, 0] += z
    matrix[0, 2] += y
    matrix[2, 0] -= y
    matrix[1, 2] -= x
    matrix[2, 1] += x
    return matrix


def rotation_vectors(matrix: Array) -> Array:
    """Rotation vectors (3, n) [rad] of rotations (3, 3, n), below half a turn."""
    sine = 0.5 * np.stack(
        [matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1]]
    )
    length = np.sqrt(np.sum(sine * sine, axis=0))
    cosine = 0.5 * (matrix[0, 0] + matrix[1, 1] + matrix[2, 2] - 1.0)
    small = length < 1e-8
    scale = np.where(small, 1.0, np.arctan2(length, cosine) / np.where(small, 1.0, length))
    return scale * sine


def matrices(quaternion: Array) -> Array:
    """Rotations (3, 3, n) of quaternions (4, n), x y z w, of any length but 0."""
    x, y, z, w = quaternion / np.sqrt(np.sum(quaternion * quaternion, axis=0))
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)]),
            np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)]),
            np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]),
        ]
    )
