"""Contacts, distances and bounding boxes of MuJoCo's geoms, with the names of hand, object and
scene."""

from __future__ import annotations

import mujoco
import numpy as np

from pneuflex_sim.engines.mujoco.world import PALM_PAD, PLATE_OF_PALM
from pneuflex_sim.hand.layout import HandLayout
from pneuflex_sim.scene.contacts import OBJECT, Contact
from softhand_common.numerics.arrays import Array

PALM_NAME = "palm_plate"


class Touches:
    """The geoms of a model by their names: a chain and its segment, `palm_plate`, `object`,
    `table`, `wall`.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, layout: HandLayout) -> None:
        self._model, self._data = model, data
        chain_of = {
            layout.names[joint]: chain
            for chain, joints in layout.chain_joints.items()
            for joint in range(joints.start, joints.stop)
        }
        self._names = [self._name(model.geom(k).name, chain_of) for k in range(model.ngeom)]
        indices = range(model.ngeom)
        hand = {*chain_of, PALM_PAD, PLATE_OF_PALM}
        self.of_object = [k for k in indices if self._names[k][0] == OBJECT]
        self.of_hand = [k for k in indices if model.geom(k).name in hand]

    @staticmethod
    def _name(geom: str, chain_of: dict[str, str]) -> tuple[str, str]:
        if geom in chain_of:
            return chain_of[geom], geom
        if geom in (PALM_PAD, PLATE_OF_PALM):
            return PALM_NAME, ""
        return (OBJECT if geom.startswith(OBJECT) else geom), ""

    def contacts(self, only_object: bool = False) -> list[Contact]:
        """Contact points that carry a force: all, or only those of the object.

        The first body of a contact is an actuator of the hand if one takes part, else the body
        that the object touches.
        """
        data, found = self._data, []
        geoms, first_row = data.contact.geom, data.contact.efc_address
        for k in range(data.ncon):
            row = first_row[k]
            if row < 0 or not data.efc_force[row] > 0.0:
                continue
            names = [self._names[geom] for geom in geoms[k]]
            if only_object and OBJECT not in (names[0][0], names[1][0]):
                continue
            axes = data.contact.frame[k].reshape(3, 3)
            force, normal, sideways = data.efc_force[row : row + 3], -axes[0], 1.0
            (first, segment), (second, other) = names
            if first == OBJECT or (other and not segment):
                first, segment, second, normal, sideways = second, other, first, axes[0], -1.0
            # the force acts on the second geom along the frame, and back on the first
            friction = -sideways * (force[1] * axes[1] + force[2] * axes[2])
            place = tuple(data.contact.pos[k].tolist())
            found.append(
                Contact(
                    first,
                    segment,
                    second,
                    place,
                    tuple(normal.tolist()),
                    float(force[0]),
                    tuple(friction.tolist()),
                )
            )
        return found

    def touching_object(self) -> frozenset[str]:
        """Names of the bodies that press on the object."""
        data = self._data
        if not data.ncon:
            return frozenset()
        rows = data.contact.efc_address
        found = set()
        for (first, second), row in zip(data.contact.geom.tolist(), rows.tolist(), strict=True):
            if row >= 0 and data.efc_force[row] > 0.0:
                pair = {self._names[first][0], self._names[second][0]}
                if OBJECT in pair:
                    found |= pair
        return frozenset(found - {OBJECT})

    def gaps(self, reach: float) -> dict[str, float]:
        """Distance [m] of the object from each part of the hand within a reach [m], below zero
        where they overlap.
        """
        model, margins = self._model, self._model.geom_margin
        mujoco.mj_kinematics(model, self._data)
        found: dict[str, float] = {}
        for part in self.of_hand:
            name = self._names[part][0]
            for other in self.of_object:
                inflated = margins[part] + margins[other]
                far = mujoco.mj_geomDistance(model, self._data, part, other, reach + inflated, None)
                if far < reach + inflated:
                    found[name] = min(far - inflated, found.get(name, np.inf))
        return found

    def boxes(self, geoms: list[int]) -> Array:
        """Boxes (k, 2, 3) [m] around geoms, along the world's axes."""
        model, data = self._model, self._data
        mujoco.mj_kinematics(model, data)
        axes = data.geom_xmat[geoms].reshape(-1, 3, 3)
        box = model.geom_aabb.reshape(-1, 6)[geoms]
        middle = data.geom_xpos[geoms] + np.einsum("kij,kj->ki", axes, box[:, :3])
        half = np.einsum("kij,kj->ki", np.abs(axes), box[:, 3:])
        half += model.geom_margin[geoms][:, None]
        return np.stack([middle - half, middle + half], axis=1)
