"""Closed triangle meshes: tubes of rings and boxes, and their STL and OBJ files.

Reading closed triangle meshes from STL (binary or ASCII) and OBJ files.
"""

from __future__ import annotations

import itertools
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


SUFFIXES = (".stl", ".obj")
SMALLEST, LARGEST = 0.002, 2.0  # [m] of the longest side that can be a thing to grasp
STL_HEAD = 84  # bytes before the triangles


def read_mesh(path: Path, scale: float = 1.0) -> Mesh:
    """The surface in an STL or OBJ file, in metres after multiplying by `scale`, faces outwards.

    Vertices at one place are joined; groups and materials do not matter. Raises ValueError for a
    file that cannot be read, a length that hints at other units, or too few triangles.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise ValueError(f"{path}: expected a file {' or '.join(SUFFIXES)}, got {path.suffix!r}")
    try:
        corners = _stl(path) if path.suffix.lower() == ".stl" else _obj(path)
    except (OSError, ValueError, IndexError) as reason:
        raise ValueError(f"{path}: expected a mesh, got {reason}") from reason
    if len(corners) < 4 or not np.isfinite(corners).all():
        raise ValueError(
            f"{path}: expected 4 triangles or more of finite numbers, got {len(corners)}"
        )
    corners = scale * corners
    longest = float(np.ptp(corners.reshape(-1, 3), axis=0).max())
    if not SMALLEST <= longest <= LARGEST:
        raise ValueError(
            f"{path}: expected a longest side of {SMALLEST:g} to {LARGEST:g} m, got {longest:g} m; "
            "of a file in millimetres, give `scale: 0.001`"
        )
    return _joined(corners)


def open_edges(mesh: Mesh) -> int:
    """How many sides of triangles lack a neighbour, or have several; 0 for a closed surface."""
    faces = mesh.indices.reshape(-1, 3)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)
    count = len(mesh.vertices)
    there, back = edges @ [count, 1], edges @ [1, count]
    return len(np.setdiff1d(there, back)) + len(there) - len(np.unique(there))


def _joined(corners: Array) -> Mesh:
    """A mesh of triangles (t, 3, 3) whose equal corners are one vertex; none without an area."""
    vertices, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    faces = index.reshape(-1, 3)
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)].astype(np.int32)
    mesh = mesh_of(vertices, faces.ravel())
    return mesh if mesh.volume >= 0 else mesh_of(vertices, faces[:, ::-1].ravel())


def _stl(path: Path) -> Array:
    data = path.read_bytes()
    count = int.from_bytes(data[STL_HEAD - 4 : STL_HEAD], "little")
    if len(data) >= STL_HEAD and len(data) == STL_HEAD + count * STL_TRIANGLE.itemsize:
        return np.frombuffer(data, STL_TRIANGLE, count, STL_HEAD)["corners"].astype(float)
    words = [line.split() for line in data.decode("ascii", "replace").splitlines()]
    found = [[float(x) for x in line[1:4]] for line in words if line[:1] == ["vertex"]]
    return np.array(found).reshape(-1, 3, 3)


def _obj(path: Path) -> Array:
    """Faces with more than three corners are cut into a fan."""
    vertices: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        kind, *words = line.split() or [""]
        if kind == "v":
            vertices.append([float(x) for x in words[:3]])
        elif kind == "f":
            corner = [int(word.split("/")[0]) for word in words]
            corner = [k - 1 if k > 0 else len(vertices) + k for k in corner]
            triangles += [(corner[0], b, c) for b, c in itertools.pairwise(corner[1:])]
    return np.array(vertices)[np.array(triangles, int)]
