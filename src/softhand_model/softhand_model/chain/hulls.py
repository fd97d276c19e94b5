"""Convex hulls of the links of a chain, used for contacts.

A hull follows the outline, eroded by COLLISION_MARGIN; it touches at that distance, which rounds
its edges off: the thesis shrinks its skin by 1 mm and lets it touch at a distance of 1 mm (5.1.4).
A hull reaches from joint to joint. Its faces at joints are not eroded, so that the passive layer is
continuous from link to link and neighbours overlap by the margin. Hulls meet on the axis of the
joint: bending opens no gap in the passive layer, but wedges on the back, as between boxes.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.spatial import ConvexHull, HalfspaceIntersection

from softhand_common.numerics.arrays import Array
from softhand_model.chain.outline import ChainOutline, hull_section
from softhand_model.hand.hand import ChainDescription

COLLISION_MARGIN = 0.001  # [m]
SMALLEST_EDGE = 0.006  # collision shapes are never thinner than this [m]
KEPT_HULLS = 32  # chains
MAX_TAPER_FACTOR = 2.0  # limit that keeps a section of SMALLEST_EDGE from vanishing


@lru_cache(maxsize=KEPT_HULLS)
def collision_hulls(description: ChainDescription, segments: int) -> tuple[Array, ...]:
    """Vertices (k, 3) [m] of the hull of each link, in the frame of the link, from the strut (or
    first joint) to the tip. segments: number per actuator.

    A strut's link carries the first half segment of the rubber; the strut itself has no hull. The
    base of a chain without strut is part of the body that carries it and has none either. Sections
    thinner than SMALLEST_EDGE are thickened to it, behind the passive layer. Hulls are cached, as
    each simulation of a hand needs them again; the arrays are read-only.
    """
    outline, hulls = ChainOutline(description, segments), []
    if description.strut is not None:
        lift = np.array([0.0, 0.0, description.strut.length / 2.0 + outline.edge / 2.0])
        hulls.append(_hull(outline, 0) + lift)
    hulls += [_hull(outline, bone) for bone in range(1, segments + 1)]
    for hull in hulls:
        hull.setflags(write=False)
    return tuple(hulls)


def _hull(outline: ChainOutline, bone: int) -> Array:
    """Vertices (k, 3) [m] of a bone's hull in its frame, around the sections at both ends."""
    ends = outline.range(bone)
    shapes = [
        outline.outlines(place, hull_section(), SMALLEST_EDGE).reshape(-1, 2) for place in ends
    ]
    around = ConvexHull(shapes[0]).vertices  # counterclockwise; parallel actuators share a hull
    start, stop = (shape[around] for shape in shapes)
    steepness = _slopes(start, stop, ends[1] - ends[0])
    at_tip = COLLISION_MARGIN if bone == outline.segments else 0.0
    share = at_tip / (ends[1] - ends[0])
    stop, place = (1.0 - share) * stop + share * start, ends[1] - at_tip
    rings = []
    for ring, at in ((start, ends[0]), (stop, place)):
        point, axes = outline.section(bone, at)
        flat = inset(ring, COLLISION_MARGIN * steepness)
        rings.append(point + np.column_stack([flat, np.zeros(len(flat))]) @ axes.T)
    return np.vstack(rings)


def _normals(ring: Array) -> Array:
    """Outward unit normals (n, 2) of the edges from each vertex to the next, counterclockwise."""
    edge = np.roll(ring, -1, axis=0) - ring
    normal = np.stack([edge[:, 1], -edge[:, 0]], axis=1)
    return normal / np.linalg.norm(normal, axis=1)[:, None]


def _slopes(start: Array, stop: Array, length: float) -> Array:
    """Factor (n,) [-] by which each edge must move more in the plane of the section for its tapered
    face to move by 1 along the face's normal.
    """
    normal = _normals(start)
    rise = np.einsum("ij,ij->i", normal, stop - start) / length
    return np.minimum(np.sqrt(1.0 + rise**2), MAX_TAPER_FACTOR)


def inset(ring: Array, distances: Array) -> Array:
    """Corners (k, 2) [m] of a convex polygon (n, 2) [m] after every edge is moved inwards by its
    distance (n,) [m]; edges without length vanish.

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> sorted(inset(square, np.full(4, 0.25)).tolist())
    [[0.25, 0.25], [0.25, 0.75], [0.75, 0.25], [0.75, 0.75]]
    """
    normal = _normals(ring)
    level = np.einsum("ij,ij->i", normal, ring) - distances
    halfplanes = np.column_stack([normal, -level])
    return np.unique(HalfspaceIntersection(halfplanes, ring.mean(axis=0)).intersections, axis=0)
