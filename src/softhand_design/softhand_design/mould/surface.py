"""Closed surfaces out of rings: domes with slanted walls, a round edge and a back, and lids.

All rings of a surface have the points of one outline. The first and the last are closed by lids,
rows of points from one side to the other. A dome narrows towards its back, so that it leaves its
mould along z.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import manifold3d
import numpy as np
from numpy.typing import NDArray

from softhand_design.mould.plan import Along, Array, Line, Outline

SECTION_STATIONS = np.array(
    [0.0, 0.06, 0.12, 0.18, 0.5, 0.82, 0.88, 0.94, 1.0]
)  # places in rows of a lid
NUBS = (2, 6)  # those that are raised
FILLET_RINGS = 8
ROUNDS = 30  # of a fixed point that halves its error at least


@dataclass(frozen=True)
class Relief:
    """Relief of a dome, at the points (n,) of its outline: depth of grooves all around, and height
    of nubs on the back [mm].
    """

    groove: Array
    nub: Array


@dataclass(frozen=True)
class Dome:
    """Rings (r, n, 3) [mm] of a dome from its foot to its back, and its lid's inner points."""

    rings: Array
    lid: Array

    @property
    def reversed_rings(self) -> Array:
        """The rings from the back to the foot."""
        return self.rings[::-1]


def dome(
    line: Line,
    outline: Outline,
    back: Along,
    draft: float,
    fillet: float,
    foot: float,
    margin: float = 0.0,
    relief: Relief | None = None,
) -> Dome:
    """A dome over an outline in the plane z = 0, moved outwards by a margin [mm].

    back is its height [mm] along s, draft [rad] the slant of its walls, fillet [mm] the radius of
    the edge between walls and back, foot [mm] the height of the first ring. Raises ValueError where
    the round edges of both sides meet.
    """
    slope = np.tan(draft)

    def height(inset: Array) -> Array:
        return back(line.track(outline.moved(margin - inset))[:, 0])

    corner = np.zeros(len(outline.s))
    for _ in range(ROUNDS):
        corner = height(corner) * slope
    rise = (height(corner + fillet) - height(corner)) / fillet  # a secant: backs may have kinks
    arc = _fillet(slope, rise, fillet) + np.stack([corner, height(corner)], axis=-1)
    feet = np.stack([np.full_like(corner, foot * slope), np.full_like(corner, foot)], axis=-1)
    off = height(arc[-1, :, 0]) - arc[-1, :, 1]  # where the back is not straight
    arc[..., 1] += np.linspace(0.0, 1.0, len(arc))[:, None] ** 2 * off
    path = np.concatenate([feet[None], arc])  # (r, n, 2): inset and height
    _refuse_meeting(line, outline, margin - path[-1, :, 0], fillet)
    if relief is not None:
        turn = np.linspace(0.0, np.pi / 2.0, len(arc))[:, None] - draft
        path[0, :, 0] += relief.groove
        path[1:, :, 0] += relief.groove * np.maximum(np.cos(turn), 0.0)
        path[1:, :, 1] -= relief.groove * np.maximum(np.sin(turn), 0.0)
    flat = np.array([outline.moved(margin - inset) for inset in path[..., 0]])
    rings = np.concatenate([flat, path[..., 1:]], axis=-1)
    rows = lid_points(rings[-1])
    rows[..., 2] = back(line.track(rows[..., :2])[..., 0])
    if relief is not None:
        count = len(rows)
        rows[..., 2] -= relief.groove[1 : count + 1, None]
        rows[:, np.array(NUBS) - 1, 2] += relief.nub[1 : count + 1, None]
    return Dome(rings, rows)


def _fillet(slope: float, rise: Array, radius: float) -> Array:
    """Arcs (rings, n, 2) from wall to back around corners (n,) at the origin: inset and height.

    The wall comes up along (slope, 1), the back leaves along (1, rise).
    """
    wall = np.broadcast_to(np.array([slope, 1.0]) / np.hypot(slope, 1.0), (len(rise), 2))
    back = np.stack([np.ones_like(rise), rise], axis=1) / np.hypot(1.0, rise)[:, None]
    angle = np.arccos(-np.sum(wall * back, axis=1))
    tangent = (radius / np.tan(angle / 2.0))[:, None]
    middle = (back - wall) / np.linalg.norm(back - wall, axis=1)[:, None]
    centre = middle * (radius / np.sin(angle / 2.0))[:, None]
    start, end = -tangent * wall - centre, tangent * back - centre
    sweep, share = np.pi - angle, np.linspace(0.0, 1.0, FILLET_RINGS + 1)[:, None]
    first, second = np.sin((1.0 - share) * sweep), np.sin(share * sweep)
    blended = first[..., None] * start + second[..., None] * end
    return centre + blended / np.sin(sweep)[None, :, None]


def _refuse_meeting(line: Line, outline: Outline, moved: Array, fillet: float) -> None:
    """Refuse a back without a flat part: there both sides would cross."""
    y = line.track(outline.moved(moved))[:, 1]
    half = len(y) // 2
    left = float((y[1:half] - y[:half:-1]).min())
    if left <= 0.0:
        raise ValueError(
            f"fillet: expected at most {fillet + left / 2.0:.2g} mm for the width and slant of "
            f"{line.name}, got {fillet:g}"
        )


def lid_points(ring: Array) -> Array:
    """Points (rows, inner, 3) that lie in rows across the opening of a ring; the ends of the rows,
    which are points of the ring, are left out.
    """
    half = len(ring) // 2
    left, right = ring[1:half], ring[:half:-1]
    share = SECTION_STATIONS[1:-1, None]
    return left[:, None] * (1.0 - share) + right[:, None] * share


def closed(rings: Sequence[Array], first: Array, last: Array) -> manifold3d.Manifold:
    """The solid inside rings (n, 3) [mm] and the inner points of the lids on both ends."""
    stacked = np.array(rings)
    count, points = stacked.shape[:2]
    inner = [lid.reshape(-1, 3) for lid in (first, last)]
    vertices = np.concatenate([stacked.reshape(-1, 3), *inner])
    begin = count * points
    faces = np.concatenate(
        [
            _tube(count, points),
            _lid(points, 0, begin)[:, ::-1],
            _lid(points, begin - points, begin + len(inner[0])),
        ]
    )
    corners = vertices[faces]
    if np.sum(np.linalg.det(corners)) < 0.0:
        faces = faces[:, ::-1]
    return solid_of(vertices, faces)


def solid_of(vertices: Array, faces: NDArray[np.int64]) -> manifold3d.Manifold:
    """A solid of triangles; raises ValueError where they do not close."""
    mesh = manifold3d.Mesh64(
        np.ascontiguousarray(vertices, np.float64), np.ascontiguousarray(faces, np.uint64)
    )
    found = manifold3d.Manifold(mesh)
    if found.status() != manifold3d.Error.NoError:
        raise ValueError(f"mould: expected closed surfaces, got {found.status().name}")
    return found


def _tube(rings: int, points: int) -> NDArray[np.int64]:
    ring, point = np.meshgrid(np.arange(rings - 1), np.arange(points), indexing="ij")
    a = (ring * points + point).ravel()
    b = (ring * points + (point + 1) % points).ravel()
    return np.concatenate(
        [np.stack([a, b, b + points], axis=1), np.stack([a, b + points, a + points], axis=1)]
    )


def _lid(points: int, ring: int, inner: int) -> NDArray[np.int64]:
    """Triangles of the lid on the ring that begins at a vertex, its inner points at another."""
    half, width = points // 2, len(SECTION_STATIONS)
    grid = np.empty((half + 1, width), np.int64)
    grid[:, 0] = ring + np.arange(half + 1)
    grid[:, -1] = ring + (-np.arange(half + 1)) % points
    grid[[0, -1]] = ring + np.array([[0], [half]])
    grid[1:-1, 1:-1] = inner + np.arange((half - 1) * (width - 2)).reshape(half - 1, width - 2)
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    faces = np.concatenate(
        [np.stack([i.ravel(), j.ravel(), k.ravel()], axis=1) for i, j, k in ((a, c, b), (a, d, c))]
    )
    distinct = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    return faces[distinct]
