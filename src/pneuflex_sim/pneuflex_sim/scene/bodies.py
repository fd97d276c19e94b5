"""Bodies of a mesh: its connected parts, and their union."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from pneuflex_sim.scene.mesh import Mesh, mesh_of

NEAR = 1e-6  # share of a length or volume that counts as none
CHEAPER = "or give `pieces: hull`"


def bodies_of(mesh: Mesh) -> list[Mesh]:
    """The connected parts of a mesh; the mesh itself where one of them is a hollow in another."""
    parts = _parts(mesh)
    whole = len(parts) < 2 or any(volume <= 0.0 for _, volume in parts)
    return [mesh] if whole else [part for part, _ in parts]


def without_overlap(mesh: Mesh) -> Mesh:
    """A closed mesh whose bodies do not overlap: the mesh itself, or the surface around all that
    its bodies fill, so that their volumes do not count twice where they overlap.

    Raises ValueError where bodies overlap, or may, and the union cannot be made: one of them has a
    hollow, surfaces are not those of solids, or manifold3d is not installed.
    """
    parts = _parts(mesh)
    filled = [part for part, volume in parts if volume > 0.0]
    if not _boxes_overlap(filled):
        return mesh
    if find_spec("manifold3d") is None:
        raise ValueError(
            "surface: expected one body, got several whose bounds overlap, which "
            f"manifold3d has to join: `pip install manifold3d`, {CHEAPER}"
        )
    union = _union(filled)
    if union.volume >= (1.0 - NEAR) * sum(volume for _, volume in parts if volume > 0.0):
        return mesh
    if len(filled) < len(parts):
        raise ValueError(
            "surface: expected bodies without hollows where they overlap, got hollows; join the "
            f"bodies in the program that made them, {CHEAPER}"
        )
    return union


def _parts(mesh: Mesh) -> list[tuple[Mesh, float]]:
    """The connected parts of a mesh with their volumes [m3], negative for hollows."""
    parts = mesh.trimesh.split(only_watertight=False)
    meshes = [mesh_of(part.vertices, part.faces.astype(np.int32).ravel()) for part in parts]
    with np.errstate(invalid="ignore", divide="ignore"):  # the centre of what encloses nothing
        return [(part, part.volume) for part in meshes]


def _boxes_overlap(bodies: Sequence[Mesh]) -> bool:
    """Whether the bounds of two bodies overlap by more than rounding."""
    if len(bodies) < 2:
        return False
    low = np.array([body.vertices.min(axis=0) for body in bodies])
    high = np.array([body.vertices.max(axis=0) for body in bodies])
    low += NEAR * (high - low).max()
    return any(
        np.all((low[k] < high[k + 1 :]) & (low[k + 1 :] < high[k]), axis=1).any()
        for k in range(len(bodies) - 1)
    )


def _union(bodies: Sequence[Mesh]) -> Mesh:
    library = import_module("manifold3d")
    whole = library.Manifold.batch_boolean(
        [_solid(library, body) for body in bodies], library.OpType.Add
    )
    found = whole.to_mesh64()
    return mesh_of(found.vert_properties[:, :3], found.tri_verts.astype(np.int32).ravel())


def _solid(library: Any, body: Mesh) -> Any:
    faces = body.indices.reshape(-1, 3).astype(np.uint64)
    solid = library.Manifold(library.Mesh64(np.ascontiguousarray(body.vertices), faces))
    if solid.status() != library.Error.NoError:
        raise ValueError(
            "surface: expected a closed surface of each body, as the bodies may overlap, got "
            f"{solid.status().name}; join the bodies in the program that made them, {CHEAPER}"
        )
    return solid
