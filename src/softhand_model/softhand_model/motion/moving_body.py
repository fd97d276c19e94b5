"""Chains in series in time: pressures bend them, weight and the wrist's motion pull at them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_common.numerics.rotations import matrices, rotate
from softhand_model.chain.chain import ChainModel
from softhand_model.chain.segments import link_inertia
from softhand_model.chain.serial import mounted
from softhand_model.dynamics.chain import Links
from softhand_model.dynamics.joint_springs import Springs
from softhand_model.dynamics.rollout import Drive, roll_out
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_model.equilibrium.hand_statics import HandBody, Shape
from softhand_model.gas import ROOM_TEMPERATURE
from softhand_model.hand.hand import HandDescription
from softhand_model.motion.wrist_path import INVERSE_QUATERNION, WristPath


class MovingBody:
    """Chains in series, as in `HandBody`, with damping: `damping_time` [s] times their stiffness.

    at_rest: the same in equilibrium, which knows where its points are.
    """

    def __init__(
        self,
        description: HandDescription,
        models: Mapping[str, ChainModel],
        damping_time: float,
    ) -> None:
        self.at_rest = HandBody(description, models)
        self._models, self._damping_time = models, damping_time
        cut = {name: chain.segments for name, chain in models.items()}
        placed = [mounted(description, cut, name) for name in models]
        size, mass = (
            np.concatenate([getattr(part, key) for part in cut.values()])
            for key in ("body_size", "mass")
        )
        offset = np.concatenate([found for found, _ in placed])
        center = np.concatenate([part.body_center for part in cut.values()])
        whole = np.array([0, len(mass)])
        inertia = link_inertia(size, mass)
        self._links = Links(whole, offset, center, inertia, mass, np.zeros_like(inertia))
        self._frame = self.at_rest.arrays.frame
        self._rest = np.ascontiguousarray(np.concatenate([found for _, found in placed]))
        mount = description.chain(next(iter(models))).mount
        self._place, self._turn = np.array(mount.position, float), mount.quaternion

    def roll(
        self,
        path: WristPath,
        time: Array,
        pressures: Array,
        modulus: float = 1.0,
        temperature: float = ROOM_TEMPERATURE,
        gravity: float = STANDARD_GRAVITY,
    ) -> Shape:
        """The body at times (samples,) [s] under gauge pressures (actuators, samples) [Pa], between
        which they go straight, along the path of a wrist, under gravity [m/s2], at a temperature
        [K], of a rubber whose modulus is `modulus` [-] times as large. At first it rests.

        Raises NoEquilibriumError as `HandBody.settle`.
        """
        start = self.at_rest.settle(
            pressures[:, :1], gravity * path.first_down[None], modulus, np.full(1, temperature)
        )
        springs = Springs(
            self._rest,
            self.at_rest.stiffness(modulus, np.full(1, temperature)),
            self.at_rest.stretching,
            self._damping_time * self.at_rest.stiffness(modulus),
        )
        acting = np.array([np.interp(path.at, time, course) for course in pressures])
        bend = self.at_rest.free_rotations(acting, modulus, np.full(acting.shape[1], temperature))
        drive = Drive(path.duration, np.ascontiguousarray(bend), *self._base(path, gravity))
        q = _turns(start.frames[0], self._frame)
        found = np.empty((len(time), *q.shape))
        roll_out(self._links, springs, drive, path.kept, q, found)
        return self._shape(found)

    def _base(self, path: WristPath, gravity: float) -> tuple[Array, Array, Array]:
        """Spin, rate and pull of the body's base, in its own axes (steps, 3)."""
        away = self._place
        about = np.cross(path.rate, away) + np.cross(path.spin, np.cross(path.spin, away))
        to_base = self._turn * INVERSE_QUATERNION
        moved = (path.spin, path.rate, path.acceleration - gravity * path.down + about)
        spin, rate, pull = (np.ascontiguousarray(rotate(to_base, part)) for part in moved)
        return spin, rate, pull

    def _shape(self, q: Array) -> Shape:
        """Places and frames in the wrist frame at orientations (rows, n, 4) of the joints."""
        rows, joints = q.shape[:2]
        turns = np.moveaxis(matrices(q.reshape(-1, 4).T), -1, 0).reshape(rows, joints, 3, 3)
        shape = Shape(np.empty((rows, joints, 3)), np.empty((rows, joints, 3, 3)))
        place = np.broadcast_to(self._place, (rows, 3))
        frame = np.broadcast_to(self._frame, (rows, 3, 3))
        for joint in range(joints):
            place = place + frame @ self._links.offset[joint]
            frame = frame @ turns[:, joint]
            shape.places[:, joint], shape.frames[:, joint] = place, frame
        return shape


def _turns(frames: Array, base: Array) -> Array:
    """Orientations (n, 4) of joints against the link before, of frames (n, 3, 3) on a base."""
    from scipy.spatial.transform import Rotation  # here, as it takes long to load

    before = np.concatenate([base[None], frames[:-1]])
    return np.asarray(Rotation.from_matrix(before.swapaxes(1, 2) @ frames).as_quat())
