"""Geometry of an actuator for its mould: sizes in mm along its line, and closed outlines in the
plane of the passive layer.

Along the line runs s [mm] from the base, y [mm] lies across it in the plane, towards the centre of
an arc. In the plane x leaves the base along the actuator: the mould ends, and is filled, at x = 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from softhand_common.numerics.arrays import Array
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.profile import Profile

Along = Callable[[Array], Array]

MILLI = 1e-3
NOSE = 5.0  # length of a rounded end [mm] where half the width is not less
SHARPEST = 3.0  # radius of a rounded end [mm], which slant and round edges take from, as above
NOSE_POINTS = 20
SPACING = 0.8  # of stations along the sides [mm]
APART = 0.1  # at least, from those that are asked for [mm]


class Line:
    """Sizes of an actuator [mm] at positions s [mm] along it, and its centre line, straight or an
    arc, in the plane of the mould.
    """

    def __init__(self, actuator: Actuator) -> None:
        self.name = actuator.name
        self.length = actuator.length / MILLI
        self.radius = None if actuator.arc_radius is None else actuator.arc_radius / MILLI
        self.height = _in_mm(actuator.height)
        self.width = _in_mm(actuator.width)
        self.wall = _in_mm(actuator.wall)
        self.side_wall = _in_mm(actuator.side_wall)

    def roof(self, s: Array) -> Array:
        """Height [mm] of the chamber at s."""
        return self.height(s) - self.wall(s)

    def half_room(self, s: Array) -> Array:
        """Half the width [mm] of the chamber at the passive layer."""
        return self.width(s) / 2.0 - self.side_wall(s)

    def half_width(self, s: Array) -> Array:
        """Half the width [mm] of the actuator at the passive layer."""
        return self.width(s) / 2.0

    def place(self, s: ArrayLike, y: ArrayLike) -> Array:
        """Points (..., 2) [mm] of the plane at s and y [mm]."""
        s, y = np.broadcast_arrays(np.asarray(s, float), np.asarray(y, float))
        if self.radius is None:
            return np.stack([s, y], axis=-1)
        angle, left = s / self.radius, self.radius - y
        return np.stack([left * np.sin(angle), self.radius - left * np.cos(angle)], axis=-1)

    def track(self, points: Array) -> Array:
        """s and y (..., 2) [mm] of points of the plane."""
        if self.radius is None:
            return np.array(points, float)
        x, left = points[..., 0], self.radius - points[..., 1]
        angle = np.arctan2(x, left)
        return np.stack([self.radius * angle, self.radius - np.hypot(x, left)], axis=-1)


def _in_mm(profile: Profile) -> Along:
    """A profile [m] along x [m] as a profile [mm] along s [mm]."""
    return lambda s: profile(np.asarray(s, float) * MILLI) / MILLI


@dataclass(frozen=True)
class Outline:
    """A closed curve: points (n, 2) [mm], first the half at y > 0 from base to tip, then its mirror
    image back; outward normals (n, 2), of such lengths that edges stay parallel when moved along
    them; s (n,) [mm].
    """

    points: Array
    normals: Array
    s: Array

    def moved(self, distance: ArrayLike) -> Array:
        """Points (n, 2) [mm] of the outline, moved along its outward normals by one distance [mm],
        or by one for each point (n,).
        """
        return self.points + np.asarray(distance, float)[..., None] * self.normals


def nose_length(half_width: float) -> float:
    """Length [mm] of the half ellipse that ends an outline of half a width [mm]."""
    return min(half_width, max(NOSE, np.sqrt(SHARPEST * half_width)))


def outline(line: Line, half_width: Along, start: float, stop: float, extra: Array) -> Outline:
    """The outline of half a width along s, with rounded ends at start and stop [mm] and more
    stations `extra` [mm] along its sides.
    """
    first, last = (nose_length(float(half_width(np.array(end)))) for end in (start, stop))
    side = np.arange(start + first, stop - last, SPACING)[1:]
    inside = extra[(extra > start + first) & (extra < stop - last)]
    side = side[np.abs(side[:, None] - inside).min(axis=1, initial=np.inf) > APART]
    side = np.sort(np.concatenate([side, inside]))
    angle = np.linspace(0.0, np.pi / 2.0, NOSE_POINTS + 1)
    bulge, across = np.sin(angle), np.cos(angle)
    across[-1] = 0.0
    s = np.concatenate([start + first * (1.0 - bulge[::-1]), side, stop - last * (1.0 - bulge)])
    share = np.concatenate([across[::-1], np.ones(len(side)), across])
    y = half_width(s) * share
    both = np.concatenate([s, s[-2:0:-1]]), np.concatenate([y, -y[-2:0:-1]])
    points = line.place(*both)
    return Outline(points, _normals(points), both[0])


def _normals(points: Array) -> Array:
    """Outward normals of the corners of a closed curve that runs clockwise: those of both edges in
    the mean, the shorter one counting more, which on a circle is exact.
    """
    edge = np.roll(points, -1, axis=0) - points
    length = np.linalg.norm(edge, axis=1)[:, None]
    normal = np.stack([-edge[:, 1], edge[:, 0]], axis=1) / length
    before, shorter = np.roll(normal, 1, axis=0), np.roll(length, 1, axis=0)
    mean = (normal * shorter + before * length) / (length + shorter)
    mean /= np.linalg.norm(mean, axis=1)[:, None]
    half_turn = np.sqrt((1.0 + np.sum(normal * before, axis=1)) / 2.0)
    return mean / half_turn[:, None]
