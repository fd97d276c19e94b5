"""The object's body in MuJoCo: placement, mass and forces."""

from __future__ import annotations

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from pneuflex_sim.engines.mujoco.compliance import update_constants
from pneuflex_sim.engines.mujoco.mjcf import wxyz, xyzw
from pneuflex_sim.scene.contacts import OBJECT
from pneuflex_sim.scene.object_body import Sheet
from pneuflex_sim.scene.objects import ObjectDescription
from pneuflex_sim.world import Diverged
from softhand_common.numerics.arrays import Array


class MujocoObject:
    """The object of a model, a free body; a limp sheet has strips on hinges beside it.

    Attributes:
        mass: present mass [kg].
    """

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, description: ObjectDescription
    ) -> None:
        self._model, self._data, self.description = model, data, description
        self.mass = description.mass
        joint, base = model.joint(OBJECT), model.body(OBJECT).id
        self._at, self._speed = int(joint.qposadr[0]), int(joint.dofadr[0])
        self._bodies = [k for k in range(model.nbody) if model.body_rootid[k] == base]
        self._shares = model.body_mass[self._bodies] / description.mass
        self._moments = model.body_inertia[self._bodies] / description.mass
        self._alone = self._diagonal()
        angles = Sheet(description.dimensions).angles if self.is_sheet else []
        self._angles = np.array(angles)

    @property
    def is_sheet(self) -> bool:
        """Whether it is a limp sheet."""
        return self.description.shape == "sheet"

    def set_mass(self, mass: float) -> None:
        """Set the mass [kg], with the same distribution, and remove what `resist` added."""
        model, data = self._model, self._data
        self.resist(0.0, 0.0)
        if mass == self.mass:
            return
        self.mass = mass
        model.body_mass[self._bodies] = mass * self._shares
        model.body_inertia[self._bodies] = mass * self._moments
        kind = mujoco.mjtState.mjSTATE_INTEGRATION
        state = np.empty(mujoco.mj_stateSize(model, kind))
        mujoco.mj_getState(model, data, state, kind)
        update_constants(model, data)
        mujoco.mj_setState(model, data, state, kind)
        self._alone = self._diagonal()

    def _diagonal(self) -> Array:
        """Of the mass matrix (6,) [kg], [kg m2], without what holds the object."""
        return np.array(self._model.dof_M0[self._speed : self._speed + 6])

    def resist(self, mass: float, inertia: float) -> None:
        """Set the mass [kg] and inertia [kg m2] of the holder of the object, which are added to its
        own; the weight of the added mass acts for one step."""
        model, at = self._model, slice(self._speed, self._speed + 6)
        model.dof_armature[at] = np.repeat([mass, inertia], 3)
        # of a body that moves alone MuJoCo takes the diagonal of the mass matrix from dof_M0
        model.dof_M0[at] = self._alone + model.dof_armature[at]
        if mass:
            weight = mass * self._model.opt.gravity
            self._data.xfrc_applied[self._bodies[0], :3] += weight

    def put(self, position: Array, rpy: tuple[float, ...], yaw: float = 0.0) -> None:
        """Put it at rest at a position (3,) [m] with roll, pitch, yaw (3,) [rad], turned by another
        `yaw` [rad] about the vertical.
        """
        self.put_at(position, Rotation.from_euler("xyz", (*rpy[:2], rpy[2] + yaw)))

    def put_at(self, position: Array, rotation: Rotation) -> None:
        """Put it at rest at a position (3,) [m] with an orientation."""
        pose, at, hinges = self._data.qpos, self._at, len(self._angles)
        pose[at : at + 3] = position
        pose[at + 3 : at + 7] = wxyz(rotation.as_quat())
        pose[at + 7 : at + 7 + hinges] = self._angles
        self._data.qvel[self._speed : self._speed + 6 + hinges] = 0.0

    def pose(self) -> tuple[Array, Array]:
        """Position (3,) [m] and quaternion (4,); raises Diverged when they are not finite."""
        place = self._data.qpos[self._at : self._at + 7].copy()
        if not np.isfinite(place).all():
            raise Diverged(f"the simulation diverged: the object is at {place[:3]}")
        return place[:3], xyzw(place[3:])

    def velocity(self) -> tuple[Array, Array]:
        """Velocity [m/s] and spin [rad/s] in the world."""
        speed = self._data.qvel[self._speed : self._speed + 6]
        return speed[:3].copy(), Rotation.from_quat(self.pose()[1]).apply(speed[3:])

    def push(self, force: Array, torque: Array) -> None:
        """For one step, add a force [N] at its centre of mass and a torque [N m], in world axes."""
        self._data.xfrc_applied[self._bodies[0]] += [*force, *torque]

    def pull_down(self, acceleration: float) -> None:
        """For one step, add the weight of its mass at an acceleration [m/s2]."""
        weights = acceleration * self.mass * self._shares
        self._data.xfrc_applied[self._bodies, 2] -= weights

    def let_be(self) -> None:
        """Clear the forces of the last step."""
        self._data.xfrc_applied[self._bodies] = 0.0
