"""Poses in space: positions and quaternions (x, y, z, w), as far as a moving wrist needs them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softhand_model.rotation import compose, rotate

Array = NDArray[np.float64]

IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])
_PARALLEL = 1.0 - 1e-9  # cosine above which slerp is a straight line to within rounding


def inverse(quaternion: Array) -> Array:
    """The opposite rotation of a unit quaternion (4,)."""
    x, y, z, w = quaternion
    return np.array([-x, -y, -z, w])


def angle_between(first: Array, second: Array) -> float:
    """Angle of the shortest rotation from one unit quaternion to the other [rad], 0 to pi."""
    x, y, z, w = compose(inverse(first), second)
    return 2.0 * math.atan2(math.sqrt(x * x + y * y + z * z), abs(w))


def slerp(first: Array, second: Array, fraction: float) -> Array:
    """Rotation a `fraction` of the shortest way from `first` to `second`, about one axis.

    >>> from softhand_model.rotation import from_rpy
    >>> half = slerp(IDENTITY, from_rpy([0.0, 0.0, 1.0]), 0.5)
    >>> round(angle_between(IDENTITY, half), 6)
    0.5
    """
    cosine = float(first @ second)
    nearest = second if cosine >= 0 else -second
    cosine = abs(cosine)
    if cosine > _PARALLEL:
        mixed = first + fraction * (nearest - first)
    else:
        angle = math.acos(cosine)
        mixed = math.sin((1 - fraction) * angle) * first + math.sin(fraction * angle) * nearest
    return np.asarray(mixed / np.linalg.norm(mixed))


def heading(quaternion: Array) -> Array:
    """The part of a rotation about the vertical: q = heading * (rest without a vertical part).

    A rotation that tips the object over by half a turn has no heading; the identity is returned for
    it.
    """
    z, w = float(quaternion[2]), float(quaternion[3])
    norm = math.hypot(z, w)
    return np.array([0.0, 0.0, z / norm, w / norm]) if norm > 1e-6 else IDENTITY


@dataclass(frozen=True)
class Pose:
    """A frame in another: position (3,) [m] and unit quaternion (4,)."""

    position: Array
    orientation: Array

    def compose(self, inner: Pose) -> Pose:
        """Pose in the outer frame of a frame known in this one."""
        return Pose(
            self.position + rotate(self.orientation, inner.position),
            compose(self.orientation, inner.orientation),
        )

    def locate(self, point: Array) -> Array:
        """Coordinates (3,) [m] in this frame of a point given in the outer frame."""
        return rotate(inverse(self.orientation), point - self.position)
