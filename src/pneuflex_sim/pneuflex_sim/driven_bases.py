"""The bases of a hand's bodies, pushed along with the wrist; what they gain beyond that push is the
hand's load on it, at no cost.
"""

from __future__ import annotations

import struct
from itertools import chain

import numpy as np
import pybullet
from numpy.typing import NDArray

from pneuflex_sim import base_kernel
from pneuflex_sim.palm_pad import PalmPad
from pneuflex_sim.wrist import Wrist
from softhand_model.effects.gravity import STANDARD_GRAVITY

Array = NDArray[np.float64]

BASE_MASS = 1000.0  # [kg]: so heavy that the chain does not move it within a step
BASE_INERTIA = 10.0  # [kg m2]
BASE_RESISTANCE = (BASE_MASS, BASE_INERTIA)
NO_PAD = (0.0, np.zeros(3), np.zeros(3), np.zeros(2))


class DrivenBases:
    """Heavy free bodies at mounts on the wrist: places (b, 3) [m], turns (b, 4); the palm sheet,
    where there is one, is the last.

    `weight` [N] is that of the hand, which the arm knows and carries, at `center` (3,) [m] in the
    frame of the wrist; `gravity` [m/s2] pulls at the bases.
    """

    def __init__(
        self,
        ids: list[int],
        places: Array,
        turns: Array,
        pad: PalmPad | None,
        mass: float,
        center: Array,
        gravity_scale: float,
        client: int,
    ) -> None:
        self.ids, self.pad, self._client = ids, pad, client
        self._mount_places, self._mount_turns = np.array(places), np.array(turns)
        self._places, self._turns = self._mount_places.copy(), self._mount_turns.copy()
        self._gravity = gravity_scale * STANDARD_GRAVITY
        self._weight, self._center = mass * self._gravity, center
        count = len(ids)
        self._velocity, self._pushed = np.zeros((count, 2, 3)), np.zeros((count, 2, 3))
        self._push = np.zeros((count, 3, 3))
        self.constants = (BASE_RESISTANCE, self._gravity, self._weight)
        self.kernel_arrays = (
            self._mount_places,
            self._mount_turns,
            self._places,
            self._turns,
            self._velocity,
            self._pushed,
            self._center,
            self._push,
        )
        self.pad_arrays = NO_PAD if pad is None else pad.arrays
        self._numbers = struct.Struct(f"{6 * count}d")

    def reset(self, wrist: Wrist) -> None:
        """Put every base at its mount on the wrist, at rest."""
        if self.pad is not None:
            self.pad.state[:] = 0.0
            self._mount_places[-1] = self.pad.place
        mounts, poses = (self._mount_places, self._mount_turns), (self._places, self._turns)
        base_kernel.place_bases(wrist.position, wrist.orientation, *mounts, *poses)
        self._pushed[:] = self._velocity[:] = 0.0
        poses = zip(self.ids, self._places.tolist(), self._turns.tolist(), strict=True)
        for base, position, orientation in poses:
            pybullet.resetBasePositionAndOrientation(
                base, position, orientation, physicsClientId=self._client
            )
            pybullet.resetBaseVelocity(base, [0, 0, 0], [0, 0, 0], physicsClientId=self._client)

    def arrays(self) -> tuple[Array, ...]:
        """All that changes while stepping."""
        pad = () if self.pad is None else (self.pad.state, self._mount_places)
        return (self._places, self._turns, self._velocity, self._pushed, *pad)

    def read(self) -> None:
        """Take the velocities from PyBullet."""
        client = self._client
        found = [pybullet.getBaseVelocity(base, client) for base in self.ids]
        numbers = chain.from_iterable(chain.from_iterable(found))
        self._numbers.pack_into(self._velocity, 0, *numbers)

    def push(self) -> None:
        """Apply the push of the step, which `hand_kernel.drive_hand` has found."""
        force, torque, frame = (
            pybullet.applyExternalForce,
            pybullet.applyExternalTorque,
            pybullet.WORLD_FRAME,
        )
        client = self._client
        for base, (along, about, place) in zip(self.ids, self._push.tolist(), strict=True):
            force(base, -1, along, place, frame, client)
            torque(base, -1, about, frame, client)
