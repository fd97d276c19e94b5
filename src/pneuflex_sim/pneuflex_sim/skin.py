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
    """Surface of a chain's rubber in the wrist frame for the joint orientations `q` (n, 4)."""
    return _sweep(*_interpolate(*_nodes(shape, name, q), rounded=True), cross_section())


def strut_mesh(shape: HandShape, name: str, q: Array) -> Mesh | None:
    """Surface of a chain's strut in the wrist frame, None for a chain without one."""
    strut = shape.layout.description.chain(name).strut
    if strut is None:
        return None
    joint = shape.layout.chain_joints[name].start
    position, frame, _ = shape.frames(q)
    mount = frame[joint] @ Rotation.from_quat(q[joint]).as_matrix().T
    half = 0.5 * strut.length
    ends = [position[joint] - half * mount[:, 2], position[joint] + half * frame[joint][:, 2]]
    turns = Rotation.from_matrix(np.stack([mount, frame[joint]]))
    sizes = np.tile([strut.thickness, strut.width], (2, 1))
    return _sweep(*_interpolate(np.array(ends), turns, sizes, rounded=False), cross_section())


def _sweep(centers: Array, frames: Array, extents: Array, outline: Array) -> Mesh:
    """Closed surface of an outline carried along a centre line."""
    rings = centers[:, None] + np.einsum("nij,nkj->nki", frames, _rings(outline, extents))
    count, points = rings.shape[:2]
    vertices = np.vstack([rings.reshape(-1, 3), rings[0].mean(axis=0), rings[-1].mean(axis=0)])
    indices = _triangles(count, points)
    return Mesh(vertices, _normals(vertices, indices), indices)


def _rings(outline: Array, extents: Array) -> Array:
    """Outlines (n, k, 3) scaled to height and width."""
    flat = outline[None] * extents[:, None, :2]
    return np.concatenate([flat, np.zeros((*flat.shape[:2], 1))], axis=2)


def _nodes(shape: HandShape, name: str, q: Array) -> tuple[Array, Rotation, Array]:
    """Segment boundaries of the rubber: base, middle of each link between joints, tip; with their
    frames and sizes.
    """
    layout = shape.layout
    joints = layout.chain_joints[name]
    first = joints.start + (layout.description.chain(name).strut is not None)
    last = joints.stop
    position, frame, _ = shape.frames(q)
    tip = position[last - 1] + frame[last - 1] @ layout.chain_tips[name]
    middle = 0.5 * (position[first : last - 1] + position[first + 1 : last])
    before = frame[first] @ Rotation.from_quat(q[first]).as_matrix().T
    half = np.linalg.norm(layout.chain_tips[name])
    points = np.vstack([position[first] - half * before[:, 2], middle, tip])
    turns = np.concatenate([before[None], frame[first : last - 1], frame[last - 1 : last]])
    sizes = layout.size[first:last, :2]
    taper = np.vstack([sizes[:1], sizes[:-1], sizes[-1:]])
    return points, Rotation.from_matrix(turns), taper


def _interpolate(
    points: Array, turns: Rotation, sizes: Array, rounded: bool
) -> tuple[Array, Array, Array]:
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
    if not rounded:
        return centers, Slerp(knots, turns)(at).as_matrix(), extents
    tip = np.clip((at - knots[-1] + 0.8) / 0.8, 0, 1)
    extents *= np.sqrt(1 - (0.97 * tip[:, None]) ** 2)
    return centers, Slerp(knots, turns)(at).as_matrix(), extents


def _triangles(rings: int, points: int) -> NDArray[np.int32]:
    """Indices of the tube between rings and of both caps."""
    faces = []
    for r in range(rings - 1):
        for k in range(points):
            a, b = r * points + k, r * points + (k + 1) % points
            faces += [(a, b, a + points), (b, b + points, a + points)]
    base, tip, last = rings * points, rings * points + 1, (rings - 1) * points
    for k in range(points):
        faces += [(base, (k + 1) % points, k), (tip, last + k, last + (k + 1) % points)]
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
