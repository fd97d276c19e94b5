"""Pictures without PyBullet: triangles are drawn from the farthest to the nearest by matplotlib.

Coarser than PyBullet's: no shadows, and where surfaces pierce each other the border is ragged.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from softhand_common.numerics.arrays import Array

if TYPE_CHECKING:
    from pneuflex_sim.pictures.render import Camera, Color
Shown = tuple[Array, "Color"]  # corners (t, 3, 3) [m] in the world, and colour

NEAREST = 0.02  # [m] before the camera; what is nearer is left out
AMBIENT_LIGHT, DIFFUSE_LIGHT = 0.55, 0.45  # shares of light
DOTS_AN_INCH = 100.0
WIDE_EDGE, FINE_EDGE = 0.04, 0.015  # [m] longest of a triangle that is drawn, behind and before
SEAM_WIDTH = 0.4  # [points] of the lines that close gaps between triangles


def paint(
    behind: Sequence[Shown], before: Sequence[Shown], camera: Camera, size: tuple[int, int]
) -> NDArray[np.uint8]:
    """Picture (height, width, 3) of triangles; those in `behind` are drawn first, under all others.
    `size` is (width, height) [pixels].
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

    width, height = size
    figure = Figure((width / DOTS_AN_INCH, height / DOTS_AN_INCH), dpi=DOTS_AN_INCH)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0, width), ylim=(0, height))
    axes.axis("off")
    for layer, longest in ((behind, WIDE_EDGE), (before, FINE_EDGE)):
        if not layer:
            continue
        tiled = [(tiles(_facing(found, camera), longest), color) for found, color in layer]
        corners = np.concatenate([found for found, _ in tiled])
        colors = np.concatenate([np.tile(color, (len(found), 1)) for found, color in tiled])
        colors[:, :3] *= shades(corners, camera)[:, None]
        places, depth = project(corners, camera, size)
        order = np.argsort(-depth.mean(axis=1))
        order = order[depth.min(axis=1)[order] > NEAREST]
        drawn = colors[order]
        axes.add_collection(
            PolyCollection(places[order], facecolors=drawn, edgecolors=drawn, linewidths=SEAM_WIDTH)
        )
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()


def tiles(corners: Array, longest: float) -> Array:
    """Corners (t, 3, 3) [m] of triangles cut until no edge is longer than `longest` [m]: small
    triangles can be sorted by their distance.
    """
    from trimesh.remesh import subdivide_to_size

    if not len(corners):
        return corners
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    vertices, found = subdivide_to_size(corners.reshape(-1, 3), faces, longest, max_iter=20)
    return np.asarray(vertices[found])


def _facing(corners: Array, camera: Camera) -> Array:
    """Those triangles (t, 3, 3) [m] whose outer side the camera sees."""
    ahead = _axes(camera)[1]
    eye = np.array(camera.target) - camera.distance * ahead
    normals = _normals(corners)
    return np.asarray(corners[np.sum(normals * (corners[:, 0] - eye), axis=1) < 0.0])


def _normals(corners: Array) -> Array:
    edges = np.diff(corners, axis=1)
    return np.cross(edges[:, 0], edges[:, 1])


def _axes(camera: Camera) -> Array:
    """Directions (3, 3) in the world to the right, ahead and up, a row each."""
    turn = Rotation.from_euler("ZX", [camera.yaw, camera.pitch], degrees=True)
    return np.asarray(turn.as_matrix().T)


def project(points: Array, camera: Camera, size: tuple[int, int]) -> tuple[Array, Array]:
    """Places (..., 2) [pixels] from the lower left, and depths (...) [m], of points (..., 3) [m] of
    the world in a picture of `size` (width, height). A camera at yaw and pitch 0 looks along y.
    """
    width, height = size
    right, ahead, up = _axes(camera)
    seen = points - np.array(camera.target)
    depth = seen @ ahead + camera.distance
    scale = 0.5 * height / np.tan(0.5 * np.radians(camera.view_angle))
    across = np.stack([seen @ right, seen @ up], axis=-1)
    middle = 0.5 * np.array([width, height])
    return middle + scale * across / np.maximum(depth, NEAREST)[..., None], depth


def shades(corners: Array, camera: Camera) -> Array:
    """Brightness (t,) [-] of triangles: ambient light, and the light that falls on the visible
    side.
    """
    normals = _normals(corners)
    lengths = np.maximum(np.linalg.norm(normals, axis=1), 1e-30)
    light = np.array(camera.light) / np.linalg.norm(camera.light)
    return np.asarray(AMBIENT_LIGHT + DIFFUSE_LIGHT * np.clip(normals @ light / lengths, 0.0, 1.0))
