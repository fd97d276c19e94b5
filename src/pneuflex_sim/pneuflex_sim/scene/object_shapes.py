"""Geometry of the objects: collision shapes, mass properties, and drawn surfaces."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pneuflex_sim.scene.bodies import without_overlap
from pneuflex_sim.scene.mesh import (
    Mesh,
    box,
    creased,
    hull_mesh,
    merged,
    open_edges,
    read_mesh,
    tube,
)
from pneuflex_sim.scene.solids import (
    Solid,
    box_solid,
    convex_pieces,
    cylinder_solid,
    ellipsoid_solid,
    eroded,
    hull_solid,
    joined,
    mesh_solid,
)
from softhand_common.numerics.arrays import Array
from softhand_model.chain.hulls import COLLISION_MARGIN

Dimensions = Mapping[str, Any]

CUP_STAVES = 16  # of a cup's wall
ELLIPSOID_POINTS = 24  # points around an ellipsoid


@dataclass(frozen=True)
class Geometry:
    """A shape about its centre of mass.

    Attributes:
        solid: mass properties.
        pieces: vertices (k, 3) [m] of the convex pieces used in collision, eroded by
            COLLISION_MARGIN, which the engine adds again; empty for the engine's own shapes.
        surface: the mesh that is drawn; None for the engine's own shapes.
    """

    solid: Solid
    pieces: tuple[Array, ...] = ()
    surface: Mesh | None = None


def geometry(shape: str, dimensions: Dimensions) -> Geometry:
    """Geometry of a shape named in `SHAPE_GEOMETRIES`.

    Raises ValueError for a mesh that cannot be used.
    """
    return SHAPE_GEOMETRIES[shape](dimensions)


def _of_pieces(outlines: Sequence[Array], solid: Solid, surface: Mesh) -> Geometry:
    """Pieces, solid and surface moved so that the centre of mass is the origin."""
    center = solid.center
    return Geometry(
        Solid(solid.volume, np.zeros(3), solid.inertia),
        tuple(eroded(outline, COLLISION_MARGIN) - center for outline in outlines),
        surface.moved(-center, np.eye(3)),
    )


def _cylinder(dimensions: Dimensions) -> Geometry:
    return Geometry(cylinder_solid(dimensions["diameter"], dimensions["length"]))


def _box(dimensions: Dimensions) -> Geometry:
    return Geometry(box_solid(dimensions["size"]))


def _sphere(dimensions: Dimensions) -> Geometry:
    return Geometry(ellipsoid_solid([dimensions["diameter"]] * 3))


def _sheet(dimensions: Dimensions) -> Geometry:
    return Geometry(box_solid(dimensions["size"]))


def _boxes(dimensions: Dimensions) -> Geometry:
    meshes = [box(part["size"], np.array(part["position"])) for part in dimensions["boxes"]]
    outlines = [np.unique(mesh.vertices, axis=0) for mesh in meshes]
    return _of_pieces(outlines, joined([hull_solid(points) for points in outlines]), merged(meshes))


def _ellipsoid(dimensions: Dimensions) -> Geometry:
    """The neck, if there is one, is a cylinder along x at the ellipsoid's end, without mass."""
    size = np.array(dimensions["size"])
    directions = _directions()
    normals = directions / size
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    outline = 0.5 * size * directions
    pieces, meshes = [outline - COLLISION_MARGIN * normals], [hull_mesh(outline)]
    if "neck" in dimensions:
        neck = _neck(dimensions["neck"], 0.5 * size[0])
        pieces.append(eroded(neck, COLLISION_MARGIN))
        meshes.append(hull_mesh(neck))
    return Geometry(ellipsoid_solid(size), tuple(pieces), merged(meshes))


def _directions() -> Array:
    """Unit vectors (k, 3) over the sphere, both poles of z among them."""
    around = 2.0 * np.pi * np.arange(ELLIPSOID_POINTS) / ELLIPSOID_POINTS
    height = np.pi * np.arange(1, ELLIPSOID_POINTS // 2) / (ELLIPSOID_POINTS // 2)
    azimuth, polar = (grid.ravel() for grid in np.meshgrid(around, height))
    across = np.sin(polar)
    rings = np.stack([np.cos(azimuth) * across, np.sin(azimuth) * across, np.cos(polar)], -1)
    return np.vstack([rings, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])


def _neck(neck: Dimensions, start: float) -> Array:
    """Corners of a slender prism from a start [m] along x; it overlaps the body a little."""
    ring = 0.5 * neck["diameter"] * _circle(8)
    ends = (start - neck["diameter"], start + neck["length"])
    return np.array([[x, *point] for x in ends for point in ring])


def _circle(points: int) -> Array:
    around = 2.0 * np.pi * np.arange(points) / points
    return np.stack([np.cos(around), np.sin(around)], axis=1)


def _cup(dimensions: Dimensions) -> Geometry:
    """Staves and a bottom of the wall's thickness; open at the top. Raises ValueError for a wall
    that leaves no room.
    """
    wall, length = dimensions["wall"], dimensions["length"]
    if not 2.0 * wall < min(dimensions["base_diameter"], dimensions["diameter"], length):
        raise ValueError(f"cup: expected a wall below half its diameters and length, got {wall:g}")
    radii = 0.5 * dimensions["base_diameter"], 0.5 * dimensions["diameter"]
    outer = [_ring(radius, z) for radius, z in zip(radii, (0.0, length), strict=True)]
    inner = [_ring(radius - wall, z) for radius, z in zip(radii, (0.0, length), strict=True)]
    staves = [
        np.array([ring[k] for ring in (*outer, *inner) for k in (start, start - 1)])
        for start in range(CUP_STAVES)
    ]
    bottom = np.vstack([_ring(radii[0] - wall, z) for z in (0.0, wall)])
    outlines = [*staves, bottom]
    surface = tube(np.array([*outer, *inner[::-1], _ring(radii[0] - wall, wall)]))
    return _of_pieces(outlines, joined([hull_solid(points) for points in outlines]), surface)


def _ring(radius: float, z: float) -> Array:
    return np.column_stack([radius * _circle(CUP_STAVES), np.full(CUP_STAVES, z)])


def _mesh(dimensions: Dimensions) -> Geometry:
    """An open mesh has no volume of its own and can only be used by its hull. If the hull is used,
    it is also what is drawn.
    """
    path, whole = Path(dimensions["file"]), dimensions.get("pieces") != "hull"
    surface = read_mesh(path, dimensions.get("scale", 1.0))
    try:
        return _of_surface(surface, whole)
    except ValueError as reason:
        raise ValueError(f"{path}: {reason}") from reason


def _of_surface(surface: Mesh, whole: bool) -> Geometry:
    gaps = open_edges(surface)
    if gaps and whole:
        raise ValueError(
            f"expected a closed surface, got {gaps} open edges; close it, or give `pieces: hull`"
        )
    if not whole:
        hull = creased(hull_mesh(surface.vertices))
        return _of_pieces([surface.vertices], hull_solid(surface.vertices), hull)
    solid = mesh_solid(without_overlap(surface))
    return _of_pieces(convex_pieces(surface), solid, creased(surface))


SHAPE_GEOMETRIES: dict[str, Callable[[Dimensions], Geometry]] = {
    "cylinder": _cylinder,
    "box": _box,
    "sphere": _sphere,
    "boxes": _boxes,
    "ellipsoid": _ellipsoid,
    "cup": _cup,
    "sheet": _sheet,
    "mesh": _mesh,
}
