"""Surfaces of hand, object and scene as triangles, coloured by pressure, and arrows of contact
forces: along the normal, and friction.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from pneuflex_sim.pictures.object_surface import object_mesh
from pneuflex_sim.pictures.render import (
    MATERIAL_COLORS,
    OBJECT_COLOR,
    TABLE_COLOR,
    Color,
    surroundings,
)
from pneuflex_sim.pictures.skin import COARSE_SKIN, HandSkin
from pneuflex_sim.scene.contacts import Contact
from pneuflex_sim.scene.mesh import Mesh, box
from pneuflex_sim.simulation import Simulation
from softhand_common.numerics.arrays import Array
from softhand_model.hand.hand import HandDescription

UNPRESSURIZED_COLOR, PRESSURE_LIMIT_COLOR = (
    (0.96, 0.86, 0.68, 1.0),
    (0.80, 0.08, 0.08, 1.0),
)  # no pressure, and the limit
ACTUATOR_OPACITY = 0.6  # of actuators: contacts lie between them and the object
METRES_PER_NEWTON = 0.02  # length of lines and arrows


class SceneSurfaces:
    """Triangles of everything visible in a simulation; the number of triangles is constant."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._skin = HandSkin(simulation.shape, COARSE_SKIN)
        self._still = {
            name: (
                _corners(box(2 * np.array(half), np.zeros(3)), np.array(place), np.array(turn)),
                TABLE_COLOR,
            )
            for name, (half, place, turn) in surroundings(simulation.scene).items()
        }
        description = simulation.object
        self._object = None if description is None else object_mesh(description)

    def now(self) -> dict[str, tuple[Array, Color]]:
        """Corners (3 t, 3) [m] of the triangles and colour of every part by name."""
        simulation = self._simulation
        filled = actuator_colors(simulation.hand, simulation.pressures())
        colors = {name: (*color[:3], ACTUATOR_OPACITY) for name, color in filled.items()}
        pose = simulation.wrist_pose()
        shown = {
            name: (_corners(mesh, *pose), colors.get(name, MATERIAL_COLORS[material]))
            for name, (material, mesh) in self._skin.parts(simulation.bodies.q).items()
        }
        if self._object is not None:
            shown["object"] = _corners(self._object, *simulation.object_pose()), OBJECT_COLOR
        return shown | self._still


def actuator_colors(hand: HandDescription, pressures: Array) -> dict[str, Color]:
    """Colour of every actuator of a hand at gauge pressures (channels,) [Pa]."""
    shares = pressures / hand.max_pressures()
    return {
        name: pressure_color(float(shares[hand.channel_of(name)])) for name in hand.actuator_names
    }


def pressure_color(share: float) -> Color:
    """Colour of rubber at a share [-] of its pressure limit: from sand to red.

    >>> pressure_color(0.5)
    (0.88, 0.47, 0.38, 1.0)
    """
    part = min(1.0, max(0.0, share))
    red, green, blue, opacity = (
        round((1.0 - part) * a + part * b, 6)
        for a, b in zip(UNPRESSURIZED_COLOR, PRESSURE_LIMIT_COLOR, strict=True)
    )
    return red, green, blue, opacity


def _corners(mesh: Mesh, position: Array, orientation: Array) -> Array:
    """Corners (3 t, 3) [m] in the world of a mesh at a pose."""
    rotation = Rotation.from_quat(orientation).as_matrix()
    return (mesh.vertices @ rotation.T + position)[mesh.indices]


def contact_line(contact: Contact) -> tuple[float, ...]:
    """Start (the contact point) and end (6,) [m] of a line along the force on the first side.

    >>> contact_line(Contact("thumb", "thumb_4", "object", (0.0, 0.0, 0.1), (0.0, 0.0, 1.0), 2.0))
    (0.0, 0.0, 0.1, 0.0, 0.0, 0.14)
    """
    (x, y, z), (fx, fy, fz) = contact.position, contact.friction
    (nx, ny, nz), force, scale = contact.normal, contact.force, METRES_PER_NEWTON
    end = (
        x + scale * (force * nx + fx),
        y + scale * (force * ny + fy),
        z + scale * (force * nz + fz),
    )
    return x, y, z, *end


def total_arrow(contacts: list[Contact]) -> Array:
    """Start and end (2, 3) [m] of the arrow of the summed force on the first side; it starts at the
    mean of the contact points, weighted by their normal forces.
    """
    weight = np.array([contact.force for contact in contacts])
    start = weight @ np.array([contact.position for contact in contacts]) / weight.sum()
    return np.stack([start, start + METRES_PER_NEWTON * _forces(contacts).sum(axis=0)])


def total_force(contacts: list[Contact]) -> float:
    """Sum of the normal forces [N] of contacts."""
    return sum(contact.force for contact in contacts)


def _forces(contacts: list[Contact]) -> Array:
    """Whole forces (k, 3) [N] on the first side."""
    return np.array(
        [contact.force * np.array(contact.normal) + contact.friction for contact in contacts]
    )
