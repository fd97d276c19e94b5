"""How far an object has slid in the hand, computed from its contacts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from pneuflex_sim.simulation import Simulation
from thesis.frame import Array


@dataclass(frozen=True)
class Touching:
    """Contact points of an object at one instant: place (k, 3) [m], normal (k, 3) [-], force (k,)
    [N]; and the frames of the object and of the parts that touch it: place [m] and axes, (3,) and
    (3, 3), (k, 3) and (k, 3, 3).
    """

    place: Array
    normal: Array
    force: Array
    object_place: Array
    object_axes: Array
    part_place: Array
    part_axes: Array


def slid(
    before: Touching, after_object: tuple[Array, Array], after_parts: tuple[Array, Array]
) -> float:
    """Mean distance [m], weighted by the normal forces, by which the object has slid along the
    surfaces that touched it, between one instant and a later pose; 0 where nothing touched.
    """
    if not before.force.sum() > 0.0:
        return 0.0
    own = _carried(before.place, before.object_place, before.object_axes, *after_object)
    theirs = _carried(before.place, before.part_place, before.part_axes, *after_parts)
    way = own - theirs
    way -= np.sum(way * before.normal, axis=1, keepdims=True) * before.normal
    return float(before.force @ np.linalg.norm(way, axis=1) / before.force.sum())


def _carried(point: Array, place: Array, axes: Array, new_place: Array, new_axes: Array) -> Array:
    """Where points (k, 3) fixed to frames get to when these move."""
    local = np.einsum("...ji,...j->...i", axes, point - place)
    return new_place + np.einsum("...ij,...j->...i", new_axes, local)


class SlipMeter:
    """Sums up how far [m] the object of a simulation has slid in the hand between calls of `look`.

    Wrist and palm sheet are assumed not to move.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._joint = {name: k for k, name in enumerate(simulation.bodies.layout.names)}
        self.way = 0.0
        self._touching, self._joints = self._now()

    def look(self) -> float:
        """Distance [m] slid since the meter was made; call it every few milliseconds."""
        before, joints = self._touching, self._joints
        self._touching, self._joints = self._now()
        self.way += slid(before, self._object(), self._frames(joints))
        return self.way

    def _object(self) -> tuple[Array, Array]:
        place, quaternion = self._simulation.object_pose()
        return place - self._origin(), Rotation.from_quat(quaternion).as_matrix()

    def _origin(self) -> Array:
        return np.array(self._simulation.scene.wrist_position)

    def _frames(self, joints: list[int]) -> tuple[Array, Array]:
        """Place (k, 3) [m] and axes (k, 3, 3) of links by their joints; -1 is the wrist."""
        simulation = self._simulation
        place, axes, _ = simulation.shape.frames(simulation.bodies.q)
        place = np.vstack([place, np.zeros(3)])
        axes = np.concatenate([axes, np.eye(3)[None]])
        return place[joints], axes[joints]

    def _now(self) -> tuple[Touching, list[int]]:
        contacts = self._simulation.object_contacts()
        joints = [self._joint.get(contact.segment, -1) for contact in contacts]
        touching = Touching(
            np.array([contact.position for contact in contacts]).reshape(-1, 3) - self._origin(),
            np.array([contact.normal for contact in contacts]).reshape(-1, 3),
            np.array([contact.force for contact in contacts]),
            *self._object(),
            *self._frames(joints),
        )
        return touching, joints
