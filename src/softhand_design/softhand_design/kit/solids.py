"""Boxes, room around solids, and whether solids meet; all in mm."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product
from typing import TypeAlias

import manifold3d
import numpy as np

Solid: TypeAlias = manifold3d.Manifold

TOUCHING_VOLUME = 1e-3  # [mm3], below which solids only touch
COARSE_SHARE = 0.05  # by which the room around a solid may be off, over the gap [-]


def box(low: Iterable[float], high: Iterable[float]) -> Solid:
    """The box [mm] between two corners (3,)."""
    first, last = np.array(list(low)), np.array(list(high))
    return Solid.cube(tuple(last - first)).translate(tuple(first))


def joined(parts: Iterable[Solid]) -> Solid:
    """All parts as one solid."""
    return Solid.batch_boolean(list(parts), manifold3d.OpType.Add)


def grown(solid: Solid, gap: float) -> Solid:
    """The solid with what is up to a gap [mm] away along each of its axes; thinner parts than the
    gap leave holes.
    """
    coarse = COARSE_SHARE * gap
    found = solid.simplify(coarse)
    for axis in gap * np.eye(3):
        found = joined([found, found.translate(tuple(axis)), found.translate(tuple(-axis))])
    return found.simplify(coarse)


def hull_around(solid: Solid, gap: float) -> Solid:
    """The convex hull of the solid with a gap [mm] to all sides; nothing around nothing."""
    if solid.is_empty():
        return solid
    corners = gap * np.array(list(product((-1.0, 1.0), repeat=3)))
    return Solid.batch_hull([solid.translate(tuple(corner)) for corner in corners])


def overlap(one: Solid, other: Solid) -> float:
    """Volume [mm3] that two solids share; without computing where their boxes are apart."""
    first, second = (np.reshape(solid.bounding_box(), (2, 3)) for solid in (one, other))
    if (first[0] > second[1]).any() or (second[0] > first[1]).any():
        return 0.0
    return float((one ^ other).volume())


def meets(one: Solid, others: Iterable[Solid]) -> bool:
    """Whether a solid overlaps one of others by more than where they touch."""
    return any(overlap(one, other) > TOUCHING_VOLUME for other in others)
