"""Reading closed triangle meshes from STL (binary or ASCII) and OBJ files."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pneuflex_sim.mesh import STL_TRIANGLE, Mesh, mesh_of

Array = NDArray[np.float64]

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
