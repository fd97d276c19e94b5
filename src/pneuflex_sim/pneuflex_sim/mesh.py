"""Closed triangle meshes: tubes of rings and boxes, and their files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

Array = NDArray[np.float64]

CREASE = float(np.radians(30.0))  # between faces [rad]: a cylinder of 16 sides still looks round
STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


@dataclass(frozen=True)
class Mesh:
    """Triangles of a closed surface: vertices (v, 3) [m], normals (v, 3), indices (3 t,)."""

    vertices: Array
    normals: Array
    indices: NDArray[np.int32]

    @property
    def corners(self) -> Array:
        """Corners (t, 3, 3) [m] of the triangles, counterclockwise seen from outside."""
        return self.vertices[self.indices.reshape(-1, 3)]

    @property
    def volume(self) -> float:
        """Enclosed volume [m3]; negative if the faces look inwards.

        >>> round(box((1.0, 2.0, 3.0), np.zeros(3)).volume, 9)
        6.0
        """
        a, b, c = np.moveaxis(self.corners, 1, 0)
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)

    def moved(self, position: Array, turn: Array) -> Mesh:
        """The mesh turned by a matrix (3, 3) and shifted by a position (3,) [m]."""
        return Mesh(self.vertices @ turn.T + position, self.normals @ turn.T, self.indices)


def mesh_of(vertices: Array, indices: NDArray[np.int32]) -> Mesh:
    """A mesh with area-weighted means of its faces' normals at the vertices."""
    faces = indices.reshape(-1, 3)
    corner = vertices[faces]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    total = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(total, faces[:, k], normal)
    return Mesh(
        vertices, total / np.maximum(np.linalg.norm(total, axis=1), 1e-12)[:, None], indices
    )


def creased(mesh: Mesh, angle: float = CREASE) -> Mesh:
    """The mesh with its vertices doubled along edges where faces meet at more than `angle` [rad],
    so that they are drawn sharp and flat faces flat.

    A corner of a face keeps the vertex of its neighbour across a smooth edge: the new vertices are
    the connected sets of corners.
    """
    faces = mesh.indices.reshape(-1, 3).astype(np.int64)
    normal = np.cross(*(mesh.corners[:, k] - mesh.corners[:, 0] for k in (1, 2)))
    unit = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-30)[:, None]
    corner = np.arange(faces.size)
    following = np.roll(corner.reshape(-1, 3), -1, axis=1).ravel()
    start, stop = faces.ravel(), faces.ravel()[following]
    side, back = start * len(mesh.vertices) + stop, stop * len(mesh.vertices) + start
    order = np.argsort(side)
    found = order[np.minimum(np.searchsorted(side, back, sorter=order), len(side) - 1)]
    smooth = np.einsum("ij,ij->i", unit[corner // 3], unit[found // 3]) > np.cos(angle)
    here = corner[(side[found] == back) & smooth]
    links = coo_array((np.ones(len(here)), (here, following[found[here]])), shape=(faces.size,) * 2)
    count, vertex = connected_components(links, directed=False)
    vertices, total = np.empty((count, 3)), np.zeros((count, 3))
    vertices[vertex] = mesh.vertices[faces.ravel()]
    np.add.at(total, vertex, normal[corner // 3])
    length = np.maximum(np.linalg.norm(total, axis=1), 1e-30)
    return Mesh(vertices, total / length[:, None], vertex.astype(np.int32))


def tube(rings: Array) -> Mesh:
    """Closed surface over rings (r, k, 3) [m] that run counterclockwise seen from the last one."""
    count, points = rings.shape[:2]
    vertices = np.vstack([rings.reshape(-1, 3), rings[0].mean(axis=0), rings[-1].mean(axis=0)])
    return mesh_of(vertices, tube_triangles(count, points))


def tube_triangles(rings: int, points: int) -> NDArray[np.int32]:
    """Indices (3 t,) of the tube between rings and of both caps, whose middles come last."""
    faces = []
    for r in range(rings - 1):
        for k in range(points):
            a, b = r * points + k, r * points + (k + 1) % points
            faces += [(a, b, a + points), (b, b + points, a + points)]
    base, tip, last = rings * points, rings * points + 1, (rings - 1) * points
    for k in range(points):
        faces += [(base, (k + 1) % points, k), (tip, last + k, last + (k + 1) % points)]
    return np.array(faces, dtype=np.int32).ravel()


def box(size: Sequence[float], center: Array) -> Mesh:
    """A box of a size (3,) [m] around a centre (3,) [m], with sharp edges."""
    square = 0.5 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    rings = np.array([np.column_stack([square, np.full(4, z)]) for z in (-0.5, 0.5)])
    found = tube(rings * np.asarray(size) + center)
    corners = found.corners
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    indices = np.arange(3 * len(corners), dtype=np.int32)
    return Mesh(corners.reshape(-1, 3), np.repeat(normal, 3, axis=0), indices)


def write_stl(path: Path, meshes: dict[str, Mesh]) -> None:
    """Write meshes into one binary STL file, in metres."""
    corners = np.concatenate([mesh.corners for mesh in meshes.values()])
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-30)[:, None]
    triangles = np.zeros(len(corners), STL_TRIANGLE)
    triangles["normal"], triangles["corners"] = normal, corners
    head = b"metres".ljust(80, b" ") + np.uint32(len(corners)).tobytes()
    path.write_bytes(head + triangles.tobytes())


def write_obj(path: Path, meshes: dict[str, Mesh]) -> None:
    """Write meshes into one OBJ file with an object a mesh, in metres, with normals."""
    lines, first = [], 1
    for name, mesh in meshes.items():
        lines.append(f"o {name}")
        lines += [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in mesh.vertices]
        lines += [f"vn {x:.4f} {y:.4f} {z:.4f}" for x, y, z in mesh.normals]
        faces = mesh.indices.reshape(-1, 3) + first
        lines += [f"f {a}//{a} {b}//{b} {c}//{c}" for a, b, c in faces]
        first += len(mesh.vertices)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
