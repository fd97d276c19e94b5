"""Rotations as quaternions (x, y, z, w)."""

from __future__ import annotations

import math
import warnings

import numpy as np
from numpy.typing import ArrayLike

from softhand_common.numerics.arrays import Array
from softhand_common.numerics.compiled import compiled


def from_rpy(rpy: ArrayLike) -> Array:
    """Quaternion (4,) of roll, pitch, yaw [rad] about fixed x, y, z, as in URDF.

    >>> from_rpy([0.0, 0.0, np.pi]).round(3).tolist()
    [0.0, 0.0, 1.0, 0.0]
    """
    (sr, cr), (sp, cp), (sy, cy) = (
        (math.sin(0.5 * angle), math.cos(0.5 * angle)) for angle in np.asarray(rpy, float).tolist()
    )
    x, y, z, w = cp * sr, sp * cr, -sp * sr, cp * cr  # about x, then about y
    return np.array([cy * x - sy * y, cy * y + sy * x, cy * z + sy * w, cy * w - sy * z])


def to_rpy(quaternion: ArrayLike) -> Array:
    """Roll, pitch, yaw (3,) [rad] about fixed x, y, z of a quaternion (4,). At a pitch of +-pi/2,
    where roll and yaw turn about the same axis, yaw is 0.
    """
    from scipy.spatial.transform import Rotation  # here, as it takes long to load

    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Gimbal lock")
        return np.asarray(Rotation.from_quat(quaternion).as_euler("xyz"), float)


def about_x(angle: float) -> Array:
    """Quaternion (4,) of a rotation by `angle` [rad] about x."""
    return np.array([np.sin(angle / 2.0), 0.0, 0.0, np.cos(angle / 2.0)])


def rotate(quaternion: ArrayLike, vectors: ArrayLike) -> Array:
    """Vectors (..., 3) rotated by a quaternion (4,); raises ValueError for a zero quaternion."""
    turned = np.asarray(vectors, float)
    return _rotated(_unit(_rows(quaternion))[0], turned.reshape(-1, 3)).reshape(turned.shape)


def compose(*quaternions: ArrayLike) -> Array:
    """Normalized product of quaternions, each (4,) or (n, 4) with the same n; the last one is
    applied first. Raises ValueError for a zero quaternion, and for different n.
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
        raise ValueError(
            "quaternions: expected arrays (4,) or (n, 4) with the same n, got different n"
        )
    result = np.empty((max(n, m), 4))
    for i in range(len(result)):
        x1, y1, z1, w1 = first[i if n > 1 else 0]
        x2, y2, z2, w2 = second[i if m > 1 else 0]
        result[i, 0] = w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2
        result[i, 1] = w1 * y2 + y1 * w2 + z1 * x2 - x1 * z2
        result[i, 2] = w1 * z2 + z1 * w2 + x1 * y2 - y1 * x2
        result[i, 3] = w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2
    return result


def matrices(quaternion: Array) -> Array:
    """Rotation matrices (3, 3, n) of quaternions x, y, z, w (4, n), which are normalized first."""
    x, y, z, w = quaternion / np.sqrt(np.sum(quaternion * quaternion, axis=0))
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)]),
            np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)]),
            np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]),
        ]
    )
