"""Surface of an object as triangles."""

from __future__ import annotations

import numpy as np

from pneuflex_sim.scene.mesh import Mesh, box, hull_mesh, tube
from pneuflex_sim.scene.objects import ObjectDescription

MOST_TRIANGLES = 5000  # of an object; above, its hull is shown
MERIDIANS, PARALLELS = 24, 12


def object_mesh(description: ObjectDescription) -> Mesh:
    """Surface of an object in its own axes; a sheet as if it were flat, a very fine mesh as its
    hull.
    """
    surface = description.geometry.surface
    if surface is not None:
        coarse = len(surface.indices) <= 3 * MOST_TRIANGLES
        return surface if coarse else hull_mesh(surface.vertices)
    half = np.array(description.half_extents)
    if description.shape in ("box", "sheet"):
        return box(2.0 * half, np.zeros(3))
    around = np.linspace(0.0, 2.0 * np.pi, MERIDIANS, endpoint=False)
    circle = np.column_stack([np.cos(around), np.sin(around)])
    if description.shape == "cylinder":
        radii, heights = np.ones(2), np.array([-1.0, 1.0])
    else:
        polar = np.linspace(np.pi, 0.0, PARALLELS + 2)[1:-1]
        radii, heights = np.sin(polar), np.cos(polar)
    rings = [
        np.column_stack([radius * circle, np.full(MERIDIANS, height)])
        for radius, height in zip(radii, heights, strict=True)
    ]
    return tube(np.array(rings) * half)
