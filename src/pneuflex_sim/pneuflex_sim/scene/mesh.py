"""Closed triangle meshes: tubes of rings, boxes and hulls, and their STL and OBJ files."""

from __future__ import annotations

import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import QhullError

from softhand_common.documents.output_file import written_whole
from softhand_common.numerics.arrays import Array

if TYPE_CHECKING:
    import trimesh  # else in functions, as it takes long to load

CREASE_ANGLE = float(np.radians(30.0))  # between faces [rad]: a cylinder of 16 sides looks round
MESH_SUFFIXES = (".stl", ".obj")
LARGEST_MESH_FILE = 2**26  # [bytes], a binary STL of 1.3 million triangles
STL_HEAD, STL_TRIANGLE = 84, 50  # bytes of a binary file
CORNER_ZERO = re.compile(r"^f (?:.* )?0+(?:[ /]|$)", re.MULTILINE)
SHORTEST_OBJECT, LONGEST_OBJECT = 0.002, 2.0  # [m] of the longest side that can be a thing to grasp


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
    def trimesh(self) -> trimesh.Trimesh:
        """The same triangles as an object of the library trimesh."""
        import trimesh

        faces = self.indices.reshape(-1, 3)
        return trimesh.Trimesh(self.vertices, faces, vertex_normals=self.normals, process=False)

    @property
    def volume(self) -> float:
        """Enclosed volume [m3]; negative if the faces look inwards.

        >>> round(box((1.0, 2.0, 3.0), np.zeros(3)).volume, 9)
        6.0
        """
        return float(self.trimesh.volume)

    def moved(self, position: Array, rotation: Array) -> Mesh:
        """The mesh rotated by a matrix (3, 3) and shifted by a position (3,) [m]."""
        vertices = self.vertices @ rotation.T + position
        return Mesh(vertices, self.normals @ rotation.T, self.indices)


def mesh_of(vertices: Array, indices: NDArray[np.int32]) -> Mesh:
    """The mesh of these vertices (v, 3) [m] and `indices` (3 t,). The normal at a vertex is the
    mean of the normals of its triangles, weighted by their areas.
    """
    faces = indices.reshape(-1, 3)
    corner = vertices[faces]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    total = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(total, faces[:, k], normal)
    return Mesh(
        vertices, total / np.maximum(np.linalg.norm(total, axis=1), 1e-12)[:, None], indices
    )


def creased(mesh: Mesh, angle: float = CREASE_ANGLE) -> Mesh:
    """The mesh with vertices doubled along edges where faces meet at more than `angle` [rad], so
    that these edges are drawn sharp and flat faces flat.

    Corners of faces that share a smooth edge share a vertex: the new vertices are the connected
    sets of corners. (trimesh's `smooth_shade` splits between smooth patches only, so an edge that
    is sharp within a patch is drawn smooth.)
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    faces = mesh.indices.reshape(-1, 3).astype(np.int64)
    corners = mesh.corners
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
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


def hull_mesh(points: Array) -> Mesh:
    """The convex hull of points (k, 3) [m]; raises ValueError for points in one plane."""
    import trimesh

    try:
        return _mesh_of_library(trimesh.convex.convex_hull(points))
    except (QhullError, ImportError) as reason:  # a flat hull asks for another package to mend it
        raise ValueError("surface: expected a volume, got points in one plane") from reason


def _mesh_of_library(found: trimesh.Trimesh) -> Mesh:
    return mesh_of(np.asarray(found.vertices), found.faces.astype(np.int32).ravel())


def merged(meshes: Sequence[Mesh]) -> Mesh:
    """Several meshes as one."""
    starts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes[:-1]])
    return Mesh(
        np.vstack([mesh.vertices for mesh in meshes]),
        np.vstack([mesh.normals for mesh in meshes]),
        np.concatenate(
            [mesh.indices + np.int32(start) for mesh, start in zip(meshes, starts, strict=True)]
        ),
    )


def tube(rings: Array) -> Mesh:
    """Closed surface over rings (r, k, 3) [m] that run counterclockwise seen from the last one."""
    count, points = rings.shape[:2]
    vertices = np.vstack([rings.reshape(-1, 3), rings[0].mean(axis=0), rings[-1].mean(axis=0)])
    return mesh_of(vertices, tube_triangles(count, points))


def tube_triangles(rings: int, points: int) -> NDArray[np.int32]:
    """Indices (3 t,) of the triangles of a tube of `rings` rings with `points` points each, and of
    its two caps; the middles of the caps are the last two vertices.
    """
    faces = []
    for r in range(rings - 1):
        for k in range(points):
            a, b = r * points + k, r * points + (k + 1) % points
            faces += [(a, b, a + points), (b, b + points, a + points)]
    base, tip, last = rings * points, rings * points + 1, (rings - 1) * points
    for k in range(points):
        faces += [(base, (k + 1) % points, k), (tip, last + k, last + (k + 1) % points)]
    return np.array(faces, dtype=np.int32).ravel()


def box(size: ArrayLike, center: Array) -> Mesh:
    """A box of a size (3,) [m] around a centre (3,) [m], with sharp edges."""
    square = 0.5 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    rings = np.array([np.column_stack([square, np.full(4, z)]) for z in (-0.5, 0.5)])
    found = tube(rings * np.asarray(size) + center)
    corners = found.corners
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    indices = np.arange(3 * len(corners), dtype=np.int32)
    return Mesh(corners.reshape(-1, 3), np.repeat(normal, 3, axis=0), indices)


def write_meshes(path: Path, meshes: Mapping[str, Mesh]) -> None:
    """Write meshes into one STL or OBJ file, in metres; an OBJ file has one object per mesh, with
    normals.
    """
    import trimesh

    surfaces: dict[str, trimesh.parent.Geometry] = {n: mesh.trimesh for n, mesh in meshes.items()}
    scene = trimesh.Scene(surfaces)
    of_obj = {"include_normals": True, "header": "metres"} if path.suffix == ".obj" else {}
    with written_whole(path) as file:
        scene.export(file, **of_obj)


def read_mesh(path: Path, scale: float = 1.0) -> Mesh:
    """The surface in an STL or OBJ file, in metres after multiplying by `scale`, faces outwards.

    Vertices at one place are joined; groups and materials are ignored. Raises ValueError for a file
    that cannot be read, a length that hints at other units, or too few triangles.
    """
    import trimesh

    if path.suffix.lower() not in MESH_SUFFIXES:
        raise ValueError(
            f"{path}: expected a file {' or '.join(MESH_SUFFIXES)}, got {path.suffix!r}"
        )
    try:
        file, kind = _content(path)
        with np.errstate(invalid="ignore"):  # numbers that are not finite are refused below
            found = trimesh.load_mesh(file, file_type=kind, process=False)
    except (OSError, ValueError, IndexError, KeyError) as reason:
        raise ValueError(f"{path}: expected a mesh, got {reason}") from reason
    found.vertices = scale * found.vertices
    three = found.vertices.shape[1:] == (3,)
    if len(found.faces) < 4 or not (three and np.isfinite(found.vertices).all()):
        raise ValueError(
            f"{path}: expected 4 triangles or more whose corners are three finite numbers, "
            f"got {len(found.faces)} triangles or numbers that are not finite"
        )
    longest = float(np.ptp(found.triangles.reshape(-1, 3), axis=0).max())
    if not SHORTEST_OBJECT <= longest <= LONGEST_OBJECT:
        raise ValueError(
            f"{path}: expected a longest side of {SHORTEST_OBJECT:g} to {LONGEST_OBJECT:g} m, "
            f"got {longest:g} m; for a file in millimetres, give `scale: 0.001`"
        )
    found.merge_vertices(merge_tex=True, merge_norm=True)
    found.update_faces(np.diff(np.sort(found.faces)).all(axis=1))  # of three corners
    with np.errstate(invalid="ignore", divide="ignore"):  # the centre of what encloses nothing
        inwards = found.volume < 0
    if inwards:
        found.invert()
    return _mesh_of_library(found)


def _content(path: Path) -> tuple[io.BytesIO | io.StringIO, str]:
    """Content of a file, and the library's name for its format. Text is decoded here, since the
    library needs another package to guess an encoding other than UTF-8.
    """
    with path.open("rb") as opened:
        data, kind = opened.read(LARGEST_MESH_FILE + 1), path.suffix.lower()[1:]
    if len(data) > LARGEST_MESH_FILE:
        raise ValueError(f"more than {LARGEST_MESH_FILE} bytes; use fewer triangles")
    count = int.from_bytes(data[STL_HEAD - 4 : STL_HEAD], "little")
    if kind == "stl" and len(data) == STL_HEAD + count * STL_TRIANGLE:
        return io.BytesIO(data), kind
    text = data.decode("utf-8", "replace").replace("\t", " ")
    if kind == "stl":
        lower = text.lower()
        if lower.lstrip().startswith("solid") and "endsolid" not in lower:
            text += "\nendsolid"  # some leave it out, and the library gives nothing then
        return io.StringIO(text), "stl_ascii"
    if CORNER_ZERO.search(text):
        raise ValueError("a face with a corner number 0; OBJ files count corners from 1")
    return io.StringIO(text), kind


def open_edges(mesh: Mesh) -> int:
    """How many sides of triangles lack a neighbour, or have several; 0 for a closed surface."""
    faces = mesh.indices.reshape(-1, 3)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)
    count = len(mesh.vertices)
    there, back = edges @ [count, 1], edges @ [1, count]
    return len(np.setdiff1d(there, back)) + len(there) - len(np.unique(there))
