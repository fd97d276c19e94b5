"""Rotations by quaternions (x, y, z, w)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from softhand_model.numerics.arrays import Array


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
    """Vectors (..., 3) turned by a quaternion (4,)."""
    return np.asarray(
        Rotation.from_quat(np.asarray(quaternion, float)).apply(np.asarray(vectors, float)), float
    )


def compose(*quaternions: ArrayLike) -> Array:
    """Product of quaternions (4,) or (n, 4), the rightmost applied first."""
    product = Rotation.from_quat(np.asarray(quaternions[0], float))
    for quaternion in quaternions[1:]:
        product = product * Rotation.from_quat(np.asarray(quaternion, float))
    return np.asarray(product.as_quat(), float)


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
