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
        self._numbers = struct.Struct(f"{6 * count}d")

    def reset(self, wrist: Wrist) -> None:
        """Put every base at its mount on the wrist, at rest."""
        if self.pad is not None:
            self.pad.state[:] = 0.0
            self._mount_places[-1] = self.pad.place
        mounts = (self._mount_places, self._mount_turns)
        base_kernel.place_bases(
            wrist.position, wrist.orientation, mounts, self._places, self._turns
        )
        self._pushed[:] = 0.0
        poses = zip(self.ids, self._places.tolist(), self._turns.tolist(), strict=True)
        for base, position, orientation in poses:
            pybullet.resetBasePositionAndOrientation(
                base, position, orientation, physicsClientId=self._client
            )
            pybullet.resetBaseVelocity(base, [0, 0, 0], [0, 0, 0], physicsClientId=self._client)

    def arrays(self) -> tuple[Array, ...]:
        """All that changes while stepping."""
        pad = () if self.pad is None else (self.pad.state, self._mount_places)
        return (self._places, self._turns, self._pushed, *pad)

    def drive(self, step: float, wrist: Wrist) -> None:
        """Advance the wrist by a step [s] under the load of the last one, and push the bases to
        where it goes.
        """
        client = self._client
        found = [pybullet.getBaseVelocity(base, client) for base in self.ids]
        numbers = chain.from_iterable(chain.from_iterable(found))
        self._numbers.pack_into(self._velocity, 0, *numbers)
        if self.pad is not None:
            self._sink(step, wrist, self.pad)
        self._advance(step, wrist)
        for base, (force, torque, place) in zip(self.ids, self._push.tolist(), strict=True):
            pybullet.applyExternalForce(base, -1, force, place, pybullet.WORLD_FRAME, client)
            pybullet.applyExternalTorque(base, -1, torque, pybullet.WORLD_FRAME, client)

    def _advance(self, step: float, wrist: Wrist) -> None:
        translation, rotation = wrist.springs
        base_kernel.carry_bases(
            step,
            BASE_RESISTANCE,
            self._gravity,
            self._mount_places,
            self._mount_turns,
            self._places,
            self._turns,
            self._velocity,
            self._pushed,
            self._weight,
            self._center,
            translation,
            rotation,
            wrist.target_position,
            wrist.target_orientation,
            wrist.force,
            wrist.torque,
            wrist.position,
            wrist.orientation,
            wrist.velocity,
            wrist.spin,
            self._push,
        )

    def _sink(self, step: float, wrist: Wrist, pad: PalmPad) -> None:
        """Let the palm sheet yield to what its velocity gained on the push."""
        normal = np.empty(3)
        base_kernel.rotate(wrist.orientation, pad.axis, normal)
        gained = (self._velocity[-1, 0] - self._pushed[-1, 0]) @ normal
        pad.advance(step, -BASE_MASS * float(gained) / step)
        self._mount_places[-1] = pad.mount()
