"""The palm sheet in PyBullet: a hull on a base of its own that sinks towards the wrist under load.

It is as stiff as the bent sheet (`softhand_model.hand.palm_sheet`) along the normal of its crown
and
rigid along and about all other axes; its outline stays what it is. The load is felt one step late,
so the sheet has to be heavier than what lies on it: MASS makes it slower than it is, at rest it
stands where the spring says.
"""

from __future__ import annotations

import math

import numpy as np
import pybullet
from numpy.typing import NDArray

from pneuflex_sim.dynamics.spatial import minus
from pneuflex_sim.dynamics.spatial import rotate as rotate_by
from pneuflex_sim.hand.collision import MARGIN
from softhand_model.hand.palm_sheet import PalmSheet
from softhand_model.numerics.compiled import compiled
from softhand_model.numerics.rotations import from_rpy, rotate

Array = NDArray[np.float64]

MASS = 2.0  # [kg]
ARCH_POINTS = 13


class PalmPad:
    """State of a sheet: how far it has sunk [m] and how fast [m/s], against its mount.

    place (3,) [m], turn (4,) and axis (3,): pose and outward normal in the frame of the wrist.
    """

    def __init__(self, sheet: PalmSheet) -> None:
        self.sheet, self.stiffness = sheet, sheet.stiffness()
        self.place, self.turn = np.array(sheet.position), from_rpy(sheet.rpy)
        self.axis = rotate(self.turn, np.array([1.0, 0.0, 0.0]))
        self.state = np.zeros(2)

    def create(self, mass: float, client: int) -> int:
        """Create the body, of a mass [kg]; its PyBullet id."""
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_MESH,
            vertices=pad_vertices(self.sheet, MARGIN).tolist(),
            physicsClientId=client,
        )
        body = pybullet.createMultiBody(mass, shape, -1, physicsClientId=client)
        pybullet.changeDynamics(body, -1, collisionMargin=MARGIN, physicsClientId=client)
        return int(body)

    @property
    def arrays(self) -> tuple[float, Array, Array, Array]:
        """What `hand_kernel` calls pad."""
        return self.stiffness, self.axis, self.place, self.state


@compiled
def advance_pad(step, stiffness, force, orientation, axis, place, state, mount):
    """One implicit step [s] of the critically damped spring under a force (3,) [N] on the sheet in
    world axes; `mount` (3,) [m] becomes its place in the frame of the wrist, whose orientation (4,)
    is given. `state` is changed in place.
    """
    normal = rotate_by(orientation, axis)
    push = -(force[0] * normal[0] + force[1] * normal[1] + force[2] * normal[2])
    damping = 2.0 * math.sqrt(stiffness * MASS)
    inertia = MASS + step * damping + step**2 * stiffness
    drive = push - stiffness * (state[0] + step * state[1]) - damping * state[1]
    state[1] += step * drive / inertia
    state[0] += step * state[1]
    for k in range(3):
        mount[k] = place[k] - state[0] * axis[k]


@compiled
def sink_pad(step, base_mass, stiffness, axis, place, state, velocity, pushed, orientation, mounts):
    """Let the sheet, the last of the bases, yield to what its velocity gained on the push; nothing
    where there is none. `mounts` (b, 3) [m] are the places of all bases in the frame of the wrist.
    """
    if stiffness > 0.0:
        weight, gain = base_mass / step, minus(velocity[-1, 0], pushed[-1, 0])
        force = (weight * gain[0], weight * gain[1], weight * gain[2])
        advance_pad(step, stiffness, force, orientation, axis, place, state, mounts[-1])


def pad_vertices(sheet: PalmSheet, margin: float) -> Array:
    """Vertices (k, 3) [m] of the hull of a sheet in its frame, eroded by a margin [m]."""
    arch = sheet.profile(ARCH_POINTS)
    arch -= margin * arch_normals(sheet, ARCH_POINTS)
    half = 0.5 * sheet.width - margin
    return np.array([[x, y, z] for x, z in arch for y in (-half, half)])


def arch_normals(sheet: PalmSheet, points: int) -> Array:
    """Outward normals (points, 2) of the arch, x and z."""
    heading = np.linspace(-0.5, 0.5, points) * sheet.angle
    return np.stack([np.cos(heading), np.sin(heading)], axis=1)
