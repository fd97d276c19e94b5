"""Collision pieces: one convex hull a link, eroded by MARGIN, which the engine dilates again.

The thesis shrinks its skin by 1 mm and lets it touch at a distance of 1 mm (5.1.4), which rounds
edges off. Here the engine's collision margin does the second half. A piece reaches from joint to
joint; faces at joints are not eroded, so that the passive layer runs on from link to link and
neighbours overlap by the margin. They meet on the axis of the joint, so on bending no gap opens in
the passive layer; wedges open on the back, as they do between boxes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, HalfspaceIntersection

from pneuflex_sim.layout import SMALLEST_EDGE
from pneuflex_sim.outline import ChainOutline, piece_section
from softhand_model.hands import ChainDescription

Array = NDArray[np.float64]

MARGIN = 0.001  # [m]
STEEPEST = 2.0  # with it, a section of SMALLEST_EDGE is never used up


def chain_pieces(description: ChainDescription, segments: int) -> list[Array]:
    """Vertices (k, 3) [m] of each joint's piece in its link's frame, from a strut's to the tip's.

    A strut's link carries the half segment at the base of the rubber; the strut itself has no
    piece. The base of a chain without strut is part of what carries it and has none either.
    Sections thinner than SMALLEST_EDGE count as that thick, behind the passive layer.
    """
    outline, pieces = ChainOutline(description, segments), []
    if description.strut is not None:
        lift = np.array([0.0, 0.0, description.strut.length / 2.0 + outline.edge / 2.0])
        pieces.append(_piece(outline, 0) + lift)
    return pieces + [_piece(outline, bone) for bone in range(1, segments + 1)]


def _piece(outline: ChainOutline, bone: int) -> Array:
    """Vertices (k, 3) [m] of a bone's piece in its frame: hull of the sections at both ends."""
    ends = outline.range(bone)
    shapes = [np.vstack(outline.outlines(place, piece_section(), SMALLEST_EDGE)) for place in ends]
    around = ConvexHull(shapes[0]).vertices  # counterclockwise; parallel actuators share a piece
    start, stop = (shape[around] for shape in shapes)
    steepness = _slopes(start, stop, ends[1] - ends[0])
    at_tip = MARGIN if bone == outline.segments else 0.0
    share = at_tip / (ends[1] - ends[0])
    stop, place = (1.0 - share) * stop + share * start, ends[1] - at_tip
    rings = []
    for ring, at in ((start, ends[0]), (stop, place)):
        point, turn = outline.section(bone, at)
        flat = inset(ring, MARGIN * steepness)
        rings.append(point + np.column_stack([flat, np.zeros(len(flat))]) @ turn.T)
    return np.vstack(rings)


def _normals(ring: Array) -> Array:
    """Outward unit normals (n, 2) of the edges from each vertex to the next, counterclockwise."""
    edge = np.roll(ring, -1, axis=0) - ring
    normal = np.stack([edge[:, 1], -edge[:, 0]], axis=1)
    return normal / np.linalg.norm(normal, axis=1)[:, None]


def _slopes(start: Array, stop: Array, length: float) -> Array:
    """By how much more (n,) [-] each edge must move in the plane of the section for its tapered
    face to move by 1 along the face's normal.
    """
    normal = _normals(start)
    rise = np.einsum("ij,ij->i", normal, stop - start) / length
    return np.minimum(np.sqrt(1.0 + rise**2), STEEPEST)


def inset(ring: Array, distances: Array) -> Array:
    """Corners (k, 2) of a convex polygon (n, 2) with every edge moved inwards by its distance (n,)
    [m]; edges that are used up vanish.

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> sorted(inset(square, np.full(4, 0.25)).tolist())
    [[0.25, 0.25], [0.25, 0.75], [0.75, 0.25], [0.75, 0.75]]
    """
    normal = _normals(ring)
    level = np.einsum("ij,ij->i", normal, ring) - distances
    halfplanes = np.column_stack([normal, -level])
    return np.unique(HalfspaceIntersection(halfplanes, ring.mean(axis=0)).intersections, axis=0)
