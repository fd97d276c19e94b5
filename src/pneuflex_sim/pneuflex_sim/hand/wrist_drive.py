"""The bases of a hand's bodies, pushed along with the wrist; what they gain beyond that push is
the hand's load.

The bases of a hand's bodies, pushed along with the wrist; what they gain beyond that push is the
hand's load on it, at no cost.
"""

from __future__ import annotations

import struct
from itertools import chain

import numpy as np
import pybullet
from numpy.typing import NDArray

from pneuflex_sim.dynamics.spatial import (
    conjugate,
    cross,
    minus,
    plus,
    quaternion_product,
    rotate,
    write,
)
from pneuflex_sim.hand.palm_pad import PalmPad
from pneuflex_sim.hand.wrist import Wrist, advance_wrist
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_model.numerics.compiled import compiled


@compiled
def place_bases(position, orientation, mount_places, mount_turns, places, turns):
    """Poses (b, 3) [m] and (b, 4) of the mounts on a wrist at this pose."""
    for b in range(len(places)):
        turn = quaternion_product(orientation, mount_turns[b])
        write(plus(rotate(orientation, mount_places[b]), position), places[b])
        turns[b, 0], turns[b, 1], turns[b, 2], turns[b, 3] = turn


@compiled
def feel_load(step, velocity, pushed, resistance, places, weight, wrist_position, force, torque):
    """Wrench of the hand on the wrist from what the bases' velocities (b, 2, 3) gained on the push.

    `resistance` is (mass, inertia) of a base; `weight` is the force and the torque of the resting
    hand's weight on the wrist, which the arm carries.
    """
    for k in range(3):
        force[k], torque[k] = -weight[0][k], -weight[1][k]
    for b in range(len(places)):
        pull = _gained(step, velocity[b, 0], pushed[b, 0], resistance[0])
        turning = _gained(step, velocity[b, 1], pushed[b, 1], resistance[1])
        lever = cross(minus(places[b], wrist_position), pull)
        for k in range(3):
            force[k] += pull[k]
            torque[k] += lever[k] + turning[k]


@compiled
def _gained(step, velocity, pushed, resistance):
    """Force or torque that has changed a base's velocity against what it was pushed to."""
    gain = minus(velocity, pushed)
    return gain[0] * resistance / step, gain[1] * resistance / step, gain[2] * resistance / step


@compiled
def push_bases(
    step, resistance, lift, places, turns, next_places, next_turns, velocity, pushed, push
):
    """Forces and torques (b, 2, 3) that bring the bases from one pose to the next within a step.

    `velocity` (b, 2, 3) is what the bases have, `pushed` what they should have had: the difference
    has moved them, and that is made up for. `pushed` becomes the velocity to reach; `lift` [m/s2]
    holds a base against gravity.
    """
    for b in range(len(pushed)):
        change = quaternion_product(next_turns[b], conjugate(turns[b]))
        sign = 2.0 if change[3] >= 0 else -2.0
        for k in range(3):
            way = next_places[b, k] - places[b, k]
            for part in range(2):
                moved = velocity[b, part, k] - pushed[b, part, k]
                pushed[b, part, k] = (way if part == 0 else sign * change[k]) / step - moved
                gain = (pushed[b, part, k] - velocity[b, part, k]) / step
                push[b, part, k] = resistance[part] * gain
        push[b, 0, 2] += resistance[0] * lift


@compiled
def carry_bases(
    step,
    resistance,
    lift,
    mount_places,
    mount_turns,
    places,
    turns,
    velocity,
    pushed,
    hand_weight,
    center_of_mass,
    translation,
    rotation,
    target_position,
    target_orientation,
    force,
    torque,
    position,
    orientation,
    speed,
    spin,
    push,
):
    """One step of wrist and bases: feel the load, advance the wrist under it, find the push.

    places (b, 3) [m] and turns (b, 4) are the bases' poses, and become those to reach;
    `hand_weight` [N] acts at `center_of_mass` (3,) of the resting hand in the wrist frame. push
    (b, 3, 3) becomes force, torque and the place where they act.
    """
    down = (0.0, 0.0, -hand_weight)
    weight = (down, cross(rotate(orientation, center_of_mass), down))
    feel_load(step, velocity, pushed, resistance, places, weight, position, force, torque)
    state = (position, orientation, speed, spin)
    target = (target_position, target_orientation)
    advance_wrist(step, translation, rotation, target, (force, torque), state)
    next_places, next_turns = np.empty_like(places), np.empty_like(turns)
    place_bases(position, orientation, mount_places, mount_turns, next_places, next_turns)
    push_bases(
        step, resistance, lift, places, turns, next_places, next_turns, velocity, pushed, push
    )
    for b in range(len(places)):
        for k in range(3):
            push[b, 2, k] = places[b, k]
    places[:] = next_places
    turns[:] = next_turns


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
        place_bases(wrist.position, wrist.orientation, *mounts, *poses)
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
