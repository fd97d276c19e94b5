"""Small rotations and 3 x 3 products for the compiled kernels (no allocation inside).

Quaternions are (x, y, z, w); matrices are row-major arrays of shape (3, 3).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from softhand_model.compiled import compiled

Array = NDArray[np.float64]


@compiled
def rotation_matrix(q: Array, out: Array) -> None:
    """Write the rotation matrix of the unit quaternion `q` (4,) into `out` (3, 3)."""
    x, y, z, w = q[0], q[1], q[2], q[3]
    out[0, 0] = 1 - 2 * (y * y + z * z)
    out[0, 1] = 2 * (x * y - z * w)
    out[0, 2] = 2 * (x * z + y * w)
    out[1, 0] = 2 * (x * y + z * w)
    out[1, 1] = 1 - 2 * (x * x + z * z)
    out[1, 2] = 2 * (y * z - x * w)
    out[2, 0] = 2 * (x * z - y * w)
    out[2, 1] = 2 * (y * z + x * w)
    out[2, 2] = 1 - 2 * (x * x + y * y)


@compiled
def quaternion_product(a: Array, b: Array, out: Array) -> None:
    """Write the quaternion product a * b into `out` (4,)."""
    x = a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1]
    y = a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0]
    z = a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3]
    w = a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]
    out[0], out[1], out[2], out[3] = x, y, z, w


@compiled
def quaternion_of_rotation(rotation: Array, out: Array) -> None:
    """Write the quaternion of a rotation vector (3,) [rad] into `out` (4,)."""
    angle = math.sqrt(rotation[0] ** 2 + rotation[1] ** 2 + rotation[2] ** 2)
    scale = 0.5 - angle * angle / 48 if angle < 1e-4 else math.sin(0.5 * angle) / angle
    for axis in range(3):
        out[axis] = scale * rotation[axis]
    out[3] = math.cos(0.5 * angle)


@compiled
def rotation_between(reference: Array, q: Array, out: Array) -> None:
    """Write the rotation vector (3,) [rad] of reference^-1 * q, angle within (-pi, pi]."""
    rx, ry, rz, rw = reference[0], reference[1], reference[2], reference[3]
    ex = rw * q[0] - rx * q[3] - ry * q[2] + rz * q[1]
    ey = rw * q[1] + rx * q[2] - ry * q[3] - rz * q[0]
    ez = rw * q[2] - rx * q[1] + ry * q[0] - rz * q[3]
    ew = rw * q[3] + rx * q[0] + ry * q[1] + rz * q[2]
    norm = math.sqrt(ex * ex + ey * ey + ez * ez)
    factor = 2.0 if norm < 1e-9 else 2 * math.atan2(norm, abs(ew)) / norm
    if ew < 0:
        factor = -factor
    out[0], out[1], out[2] = factor * ex, factor * ey, factor * ez


@compiled
def cross(a: Array, b: Array, out: Array) -> None:
    """Write a x b into `out` (3,), which must not be a or b."""
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@compiled
def multiply(a: Array, b: Array, out: Array) -> None:
    """Write the 3 x 3 product a @ b into `out`, which must not be a or b."""
    for i in range(3):
        for j in range(3):
            out[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]


@compiled
def apply(a: Array, vector: Array, out: Array) -> None:
    """Write a @ vector into `out` (3,), which must not be `vector`."""
    for i in range(3):
        out[i] = a[i, 0] * vector[0] + a[i, 1] * vector[1] + a[i, 2] * vector[2]


@compiled
def apply_transposed(a: Array, vector: Array, out: Array) -> None:
    """Write a^T @ vector into `out` (3,), which must not be `vector`."""
    for i in range(3):
        out[i] = a[0, i] * vector[0] + a[1, i] * vector[1] + a[2, i] * vector[2]


@compiled
def rotate_diagonal(rotation: Array, diagonal: Array, out: Array) -> None:
    """Write rotation @ diag(diagonal) @ rotation^T into `out` (3, 3)."""
    for i in range(3):
        for j in range(i + 1):
            value = 0.0
            for k in range(3):
                value += rotation[i, k] * diagonal[k] * rotation[j, k]
            out[i, j] = value
            out[j, i] = value


@compiled
def invert_symmetric(a: Array, out: Array) -> None:
    """Write the inverse of the symmetric positive definite 3 x 3 matrix `a` into `out`."""
    c00 = a[1, 1] * a[2, 2] - a[1, 2] * a[1, 2]
    c01 = a[0, 2] * a[1, 2] - a[0, 1] * a[2, 2]
    c02 = a[0, 1] * a[1, 2] - a[0, 2] * a[1, 1]
    scale = 1.0 / (a[0, 0] * c00 + a[0, 1] * c01 + a[0, 2] * c02)
    out[0, 0] = scale * c00
    out[0, 1] = out[1, 0] = scale * c01
    out[0, 2] = out[2, 0] = scale * c02
    out[1, 1] = scale * (a[0, 0] * a[2, 2] - a[0, 2] * a[0, 2])
    out[1, 2] = out[2, 1] = scale * (a[0, 2] * a[0, 1] - a[0, 0] * a[1, 2])
    out[2, 2] = scale * (a[0, 0] * a[1, 1] - a[0, 1] * a[0, 1])
