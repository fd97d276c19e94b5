"""Smooth surface of each actuator for pictures: rings of the cross section swept along the bent
chain.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from pneuflex_sim.hand_shape import HandShape

Array = NDArray[np.float64]

RING_POINTS = 24
RINGS_A_SPAN = 5


@dataclass(frozen=True)
class Mesh:
    """Triangles of a closed surface: vertices (v, 3) [m], normals (v, 3), indices (3 t,)."""

    vertices: Array
    normals: Array
    indices: NDArray[np.int32]


def cross_section(points: int = RING_POINTS) -> Array:
    """Unit outline (points, 2) of a PneuFlex section: flat at x = 0 (the passive layer), round at x
    = -1, y in +-0.5.
    """
    angle = np.linspace(0, 2 * np.pi, points, endpoint=False)
    c, s = np.cos(angle), np.sin(angle)
    power = np.where(
        c > 0, 0.3, 0.8
    )  # nearly square towards the passive layer, rounded on the back
    return np.stack(
        [0.5 * (np.sign(c) * np.abs(c) ** power - 1), 0.5 * np.sign(s) * np.abs(s) ** 0.6], axis=1
    )


def chain_mesh(shape: HandShape, name: str, q: Array) -> Mesh:
    """Surface of one chain in the wrist frame for the joint orientations `q` (n, 4) of the whole
    hand.
    """
    positions, turns, sizes = _nodes(shape, name, q)
    centers, frames, extents = _interpolate(positions, turns, sizes)
    outline = cross_section()
    rings = centers[:, None] + np.einsum("nij,nkj->nki", frames, _rings(outline, extents))
    count, points = rings.shape[:2]
    vertices = np.vstack([rings.reshape(-1, 3), rings[0].mean(axis=0), rings[-1].mean(axis=0)])
    return Mesh(vertices, _normals(vertices, indices := _triangles(count, points)), indices)


def _rings(outline: Array, extents: Array) -> Array:
    """Outlines (n, k, 3) scaled to height and width."""
    flat = outline[None] * extents[:, None, :2]
    return np.concatenate([flat, np.zeros((*flat.shape[:2], 1))], axis=2)


def _nodes(shape: HandShape, name: str, q: Array) -> tuple[Array, Rotation, Array]:
    """Segment boundaries: base, the middle of each link between joints, tip; with their frames and
    sizes.
    """
    layout = shape.layout
    joints = layout.chain_joints[name]
    position, frame, _ = shape.frames(q)
    first, last = joints.start, joints.stop
    ends = np.vstack(
        [position[first + 1 : last], position[last - 1] + frame[last - 1] @ layout.chain_tips[name]]
    )
    middle = 0.5 * (position[first : last - 1] + ends[:-1])
    back = np.linalg.norm(layout.offset[first + 1]) / 2 if last - first > 1 else 0.01
    mount = frame[first] @ Rotation.from_quat(q[first]).as_matrix().T
    base = position[first] - min(back, np.linalg.norm(layout.offset[first]) or back) * mount[:, 2]
    points = np.vstack([base, middle, ends[-1]])
    turns = np.concatenate([mount[None], frame[first : last - 1], frame[last - 1 : last]])
    sizes = layout.size[first:last]
    taper = np.vstack([sizes[:1], sizes[:-1], sizes[-1:] * [0.75, 0.85, 1]])
    return points, Rotation.from_matrix(turns), taper


def _interpolate(points: Array, turns: Rotation, sizes: Array) -> tuple[Array, Array, Array]:
    """Cubic Hermite centre line with the frames' z axes as tangents, frames by slerp, sizes linear;
    rounded tip.
    """
    knots = np.arange(len(points), dtype=float)
    at = np.linspace(0, knots[-1], RINGS_A_SPAN * (len(points) - 1) + 1)
    span = np.minimum(at.astype(int), len(points) - 2)
    t = (at - span)[:, None]
    step = np.linalg.norm(np.diff(points, axis=0), axis=1)[span][:, None]
    tangents = turns.as_matrix()[:, :, 2]
    centers = (
        (2 * t**3 - 3 * t**2 + 1) * points[span]
        + (t**3 - 2 * t**2 + t) * step * tangents[span]
        + (3 * t**2 - 2 * t**3) * points[span + 1]
        + (t**3 - t**2) * step * tangents[span + 1]
    )
    extents = np.stack([np.interp(at, knots, sizes[:, k]) for k in range(2)], axis=1)
    tip = np.clip((at - knots[-1] + 0.8) / 0.8, 0, 1)
    extents *= np.sqrt(1 - (0.97 * tip[:, None]) ** 2)
    return centers, Slerp(knots, turns)(at).as_matrix(), extents


def _triangles(rings: int, points: int) -> NDArray[np.int32]:
    """Indices of the tube between rings and of both caps."""
    faces = []
    for r in range(rings - 1):
        for k in range(points):
            a, b = r * points + k, r * points + (k + 1) % points
            faces += [(a, a + points, b), (b, a + points, b + points)]
    base, tip, last = rings * points, rings * points + 1, (rings - 1) * points
    for k in range(points):
        faces += [(base, k, (k + 1) % points), (tip, last + (k + 1) % points, last + k)]
    return np.array(faces, dtype=np.int32).ravel()


def _normals(vertices: Array, indices: NDArray[np.int32]) -> Array:
    """Vertex normals, outward: area-weighted means of the faces'."""
    faces = indices.reshape(-1, 3)
    corner = vertices[faces]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    total = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(total, faces[:, k], normal)
    return total / np.maximum(np.linalg.norm(total, axis=1), 1e-12)[:, None]
