"""The palm sheet in PyBullet and the plate that carries it: a hull on a base of its own that sinks
towards the wrist under load.

Along the normal of its crown it has the stiffness of the bent sheet
(`softhand_model.hand.palm_sheet`); along and about all other axes it is rigid, and its outline does
not change. The load acts one step late, so the sheet must be heavier than what lies on it: PAD_MASS
slows its motion, but does not change where it comes to rest.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneuflex_sim.bullet import pybullet
from softhand_common.numerics.compiled import compiled
from softhand_common.numerics.rotations import from_rpy, rotate
from softhand_model.chain.hulls import COLLISION_MARGIN
from softhand_model.dynamics.spatial import minus
from softhand_model.dynamics.spatial import rotate as rotate_by
from softhand_model.hand.hand import Plate
from softhand_model.hand.palm_sheet import PalmSheet

if TYPE_CHECKING:
    from pneuflex_sim.hand.driven_bases import Bases

Array = NDArray[np.float64]

PAD_MASS = 2.0  # [kg]
PAD_ARCH_POINTS = 13


class PadSpring(NamedTuple):
    """Spring of a palm sheet, in the wrist frame: stiffness [N/m] along its outward normal axis
    (3,); place (3,) [m] of its base without load; state (2,): how far [m] and how fast [m/s] it has
    sunk.
    """

    stiffness: float
    axis: Array
    place: Array
    state: Array


NO_PAD = PadSpring(0.0, np.zeros(3), np.zeros(3), np.zeros(2))


class PalmPad:
    """A sheet, its orientation (4,) in the frame of the wrist and its spring."""

    def __init__(self, sheet: PalmSheet) -> None:
        self.sheet, self.orientation = sheet, from_rpy(sheet.rpy)
        axis = rotate(self.orientation, np.array([1.0, 0.0, 0.0]))
        place = np.array(sheet.position, float)
        self.spring = PadSpring(float(sheet.stiffness()), axis, place, np.zeros(2))

    def create(self, mass: float, client: int) -> int:
        """Create the body with a mass [kg]; returns its PyBullet id."""
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_MESH,
            vertices=pad_vertices(self.sheet, COLLISION_MARGIN).tolist(),
            physicsClientId=client,
        )
        body = pybullet.createMultiBody(mass, shape, -1, physicsClientId=client)
        pybullet.changeDynamics(body, -1, collisionMargin=COLLISION_MARGIN, physicsClientId=client)
        return int(body)


@compiled
def sink_pad(step: float, pad: PadSpring, bases: Bases, orientation: Array) -> None:
    """One implicit step [s] of the sheet's critically damped spring.

    The sheet is the last of the bases; the force on it follows from the difference between its
    velocity and the one that the last push aimed at. Its mount, whose `orientation` (4,) in the
    wrist frame is given, moves along. Does nothing without a sheet.
    """
    if pad.stiffness <= 0.0:
        return
    weight, gain = bases.resistance[-1, 0] / step, minus(bases.velocity[-1, 0], bases.pushed[-1, 0])
    force = (weight * gain[0], weight * gain[1], weight * gain[2])
    normal, state = rotate_by(orientation, pad.axis), pad.state
    push = -(force[0] * normal[0] + force[1] * normal[1] + force[2] * normal[2])
    damping = 2.0 * math.sqrt(pad.stiffness * PAD_MASS)
    inertia = PAD_MASS + step * damping + step**2 * pad.stiffness
    drive = push - pad.stiffness * (state[0] + step * state[1]) - damping * state[1]
    state[1] += step * drive / inertia
    state[0] += step * state[1]
    for k in range(3):
        bases.mount_places[-1, k] = pad.place[k] - state[0] * pad.axis[k]


def create_plate(plate: Plate, mass: float, client: int) -> int:
    """Create the body of a plate with a mass [kg], centred at its own middle; returns its PyBullet
    id.
    """
    half = [0.5 * edge for edge in plate.size]
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=half, physicsClientId=client
    )
    return int(pybullet.createMultiBody(mass, shape, -1, physicsClientId=client))


def pad_vertices(sheet: PalmSheet, margin: float) -> Array:
    """Vertices (k, 3) [m] of the hull of a sheet in its frame, eroded by a margin [m]."""
    arch = sheet.profile(PAD_ARCH_POINTS)
    arch -= margin * arch_normals(sheet, PAD_ARCH_POINTS)
    half = 0.5 * sheet.width - margin
    return np.array([[x, y, z] for x, z in arch for y in (-half, half)])


def arch_normals(sheet: PalmSheet, points: int) -> Array:
    """Outward normals (points, 2) of the arch, x and z."""
    heading = np.linspace(-0.5, 0.5, points) * sheet.angle
    return np.stack([np.cos(heading), np.sin(heading)], axis=1)
