"""Poses in space, positions and quaternions (x, y, z, w), and smooth motion between two of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_common.numerics.rotations import compose, rotate

IDENTITY_QUATERNION = np.array([0.0, 0.0, 0.0, 1.0])
_PARALLEL = 1.0 - 1e-9  # cosine above which slerp is a straight line to within rounding
PEAK_TO_MEAN = 1.875  # greatest over mean speed of a minimum-jerk motion, at half its duration


def inverse(quaternion: Array) -> Array:
    """The inverse rotation of a unit quaternion (4,)."""
    x, y, z, w = quaternion
    return np.array([-x, -y, -z, w])


def angle_between(first: Array, second: Array) -> float:
    """Angle of the shortest rotation from one unit quaternion to the other [rad], 0 to pi."""
    x, y, z, w = compose(inverse(first), second)
    return 2.0 * math.atan2(math.sqrt(x * x + y * y + z * z), abs(w))


def slerp(first: Array, second: Array, fraction: float) -> Array:
    """Quaternion (4,) at a `fraction` [-] of the shortest rotation from `first` to `second`.

    >>> from softhand_common.numerics.rotations import from_rpy
    >>> half = slerp(IDENTITY_QUATERNION, from_rpy([0.0, 0.0, 1.0]), 0.5)
    >>> round(angle_between(IDENTITY_QUATERNION, half), 6)
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
    """The rotation about the vertical in a unit quaternion (4,), q = heading * tilt (swing-twist).

    For a tilt of 180 deg the heading is undefined, and the identity is returned.
    """
    z, w = float(quaternion[2]), float(quaternion[3])
    norm = math.hypot(z, w)
    return np.array([0.0, 0.0, z / norm, w / norm]) if norm > 1e-6 else IDENTITY_QUATERNION


@dataclass(frozen=True)
class Pose:
    """A frame in another: position (3,) [m] and unit quaternion (4,)."""

    position: Array
    orientation: Array

    def compose(self, inner: Pose) -> Pose:
        """Pose in the outer frame of the frame that has the pose `inner` in this one."""
        return Pose(
            self.position + rotate(self.orientation, inner.position),
            compose(self.orientation, inner.orientation),
        )

    def place(self, point: Array) -> Array:
        """Coordinates (3,) [m] in the outer frame of a point given in this frame."""
        return self.position + rotate(self.orientation, point)

    def shifted(self, point: Array) -> Pose:
        """The frame with its origin moved to a point (3,) [m] of its own axes."""
        return Pose(self.place(point), self.orientation)

    def locate(self, point: Array) -> Array:
        """Coordinates (3,) [m] in this frame of a point given in the outer frame."""
        return rotate(inverse(self.orientation), point - self.position)


def minimum_jerk(fraction: float) -> float:
    """Progress [-] of a rest-to-rest motion of least jerk, 10 s^3 - 15 s^4 + 6 s^5.

    `fraction` s [-] is the share of the duration, clipped to 0..1. Source: Flash and Hogan,
    J. Neuroscience 5 (1985), 1688.

    >>> [minimum_jerk(s) for s in (-1.0, 0.0, 0.5, 1.0, 2.0)]
    [0.0, 0.0, 0.5, 1.0, 1.0]
    """
    s = min(1.0, max(0.0, fraction))
    return s**3 * (10.0 + s * (6.0 * s - 15.0))


@dataclass(frozen=True)
class Motion:
    """Minimum-jerk motion from `start` to `goal` in `duration` [s].

    The orientation follows a slerp with the same progress. The point that moves on a straight line
    is `pivot` (3,) [m] in the moving frame's axes; None: the frame's origin.
    """

    start: Pose
    goal: Pose
    duration: float
    pivot: Array | None = None

    def at(self, elapsed: float) -> Pose:
        """Pose `elapsed` [s] after the start; the goal from `duration` on."""
        progress = minimum_jerk(elapsed / self.duration) if self.duration > 0 else 1.0
        orientation = slerp(self.start.orientation, self.goal.orientation, progress)
        if self.pivot is None:
            first, last = self.start.position, self.goal.position
            return Pose(first + progress * (last - first), orientation)
        first, last = self.start.place(self.pivot), self.goal.place(self.pivot)
        return Pose(first + progress * (last - first), orientation).shifted(-self.pivot)


def duration_at_speed(
    start: Pose, goal: Pose, speed: float, turn_speed: float, pivot: Array | None = None
) -> float:
    """Duration [s] of a `Motion` whose peak speeds stay within limits: `speed` [m/s] of the pivot
    (None: the frame's origin) and `turn_speed` [rad/s] of the rotation.
    """
    point = np.zeros(3) if pivot is None else pivot
    distance = float(sum((goal.place(point) - start.place(point)) ** 2) ** 0.5)
    angle = angle_between(start.orientation, goal.orientation)
    return PEAK_TO_MEAN * max(distance / speed, angle / turn_speed)
