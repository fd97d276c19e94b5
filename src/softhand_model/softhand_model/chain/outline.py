"""Outline of a chain's actuators at rest: cross sections along the length, and where they sit in
the links.

Lengths along a chain run from 0 at the base of its rubber to `length` at the tip. A bone is a rigid
frame at the joint that moves it. Bone 0 carries the half segment at the base, bone i + 1 the link
of joint i of the rubber (struts are not counted).
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_model.chain.segments import arc_angle, lateral_places, mean_radius
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.hand import ChainDescription

CORNER_RADIUS = 0.1  # radius at the passive layer, as a share of height and width
BACK_POWER = (0.8, 0.6)  # of the superellipse on the back, along height and width
# unit outline of a collision hull: points of the smooth outline, by their angle on the back [rad]
HULL_BACK = (1.4, 0.7, 0.15)


def cross_section(corner_points: int = 3, back_points: int = 11) -> Array:
    """Smooth unit outline (points, 2) of a PneuFlex section, counterclockwise: flat at x = 0, the
    passive layer, with rounded corners; a superellipse around the back to x = -1; y in +-0.5.

    The chamber of an actuator without pressure is rectangular; the thesis shows only in pictures
    how much its mould rounds the back. corner_points, back_points: numbers of points on each corner
    and on the back.
    """
    angle = np.linspace(0.0, np.pi / 2.0, corner_points)
    corner = CORNER_RADIUS * np.stack([np.cos(angle) - 1.0, np.sin(angle) - 1.0], axis=1) + [
        0.0,
        0.5,
    ]
    back = _back(np.linspace(np.pi / 2.0, 0.0, (back_points + 1) // 2))
    half = np.vstack([corner, back])  # from the passive layer over +y to the middle of the back
    return np.vstack([half, mirrored(half[:-1])])


def hull_section() -> Array:
    """Unit outline (10, 2) of the collision hulls: points of the smooth outline, which form a
    convex polygon.
    """
    half = np.vstack(
        [[0.0, 0.5 - CORNER_RADIUS], [-CORNER_RADIUS, 0.5], _back(np.array(HULL_BACK))]
    )
    return np.vstack([half, mirrored(half)])


def mirrored(half: Array) -> Array:
    """The other half of an outline, mirrored, in the order in which it closes the outline."""
    return half[::-1] * [1.0, -1.0]


def _back(angle: Array) -> Array:
    """Points (n, 2) of the back at angles [rad] from its middle."""
    along, across = BACK_POWER
    return 0.5 * np.stack([-1.0 - np.cos(angle) ** along, np.sin(angle) ** across], axis=1)


class ChainOutline:
    """Sections of one chain that is divided into `segments` segments per actuator."""

    def __init__(self, description: ChainDescription, segments: int) -> None:
        self.description, self.segments = description, segments
        self.parts: list[Actuator] = list(description.actuators.values())
        self.places = lateral_places(description)

    @cached_property
    def length(self) -> float:
        """Length [m] along the middle line."""
        if self.description.turn:
            return arc_angle(self.parts) * mean_radius(self.parts)
        return self.parts[0].length

    @property
    def edge(self) -> float:
        """Length [m] of a segment."""
        return self.length / self.segments

    def joint(self, bone: int) -> float:
        """Position [m] along the chain of the joint at the origin of a bone's frame."""
        return (max(bone, 1) - 0.5) * self.edge

    def range(self, bone: int) -> tuple[float, float]:
        """Positions [m] along the chain where the rubber of a bone begins and ends."""
        edges = [0.0, *((np.arange(self.segments) + 0.5) * self.edge), self.length]
        return float(edges[bone]), float(edges[bone + 1])

    def extents(self, place: float) -> Array:
        """Height and width (actuators, 2) [m] at a position [m] along the chain."""
        share = np.clip(place / self.length, 0.0, 1.0)
        return np.array(
            [
                [part.height(share * part.length), part.width(share * part.length)]
                for part in self.parts
            ]
        )

    def section(self, bone: int, place: float) -> tuple[Array, Array]:
        """(point (3,) [m], rotation matrix (3, 3)) of the section at a position [m] along the
        chain, at rest, in the frame of a bone.
        """
        if not self.description.turn:
            return np.array([0.0, 0.0, place - self.joint(bone)]), np.eye(3)
        radius, side = mean_radius(self.parts), self.description.turn
        start = (0.5 if bone == 0 else -0.5) * arc_angle(self.parts) / self.segments
        heading = start + (place - self.joint(bone)) / radius
        across = side * (np.cos(start) - np.cos(heading))
        point = radius * np.array([0.0, across, np.sin(heading) - np.sin(start)])
        c, s = np.cos(heading), side * np.sin(heading)
        return point, np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])

    def outlines(self, place: float, unit: Array, least: float = 0.0) -> Array:
        """Outlines (actuators, points, 2) [m] at a position [m] along the chain, as x and y in the
        frame of the section.

        unit (points, 2): outline of height and width 1. least [m]: smallest height and width.
        """
        scaled = unit[None] * np.maximum(self.extents(place), least)[:, None]
        scaled[..., 1] += self.places[:, None]
        return scaled
