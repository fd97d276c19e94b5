"""The bases of a hand's bodies, which follow the wrist. Their deviation from the commanded velocity
gives the load of the hand on the wrist.

Each base is a free body. (A base that is moved by resetting its pose has no velocity in the contact
solver, and a held object would not follow it.) The bases of chains are so heavy that the chain does
not move them. The bases that touch by themselves, palm sheet and plate, weigh less than the arm.
The arm feels what stops them, such as a table, one step late; with less mass this load cannot
exceed what the arm can give.
"""

from __future__ import annotations

import struct
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.hand.palm_pad import NO_PAD, PalmPad
from pneuflex_sim.hand.wrist import Arm, Wrist, WristState, advance_wrist
from softhand_common.numerics.compiled import compiled
from softhand_model.dynamics.spatial import (
    Vector,
    conjugate,
    cross,
    minus,
    plus,
    quaternion_product,
    rotate,
    write,
)

Array = NDArray[np.float64]

BASE_MASS = 1000.0  # [kg]: so heavy that the chain does not move it within a step
BASE_INERTIA = 10.0  # [kg m2]
PALM_MASS = 1.0  # [kg] of a base that touches by itself
PALM_INERTIA = 0.02  # [kg m2]


class Bases(NamedTuple):
    """Bases (b,) of a hand.

    Attributes:
        mount_places, mount_orientations: poses of the mounts in the wrist frame, (b, 3) [m] and
            (b, 4).
        places, orientations: poses in the world, (b, 3) [m] and (b, 4).
        velocity: (b, 2, 3) [m/s, rad/s], as measured.
        pushed: (b, 2, 3) [m/s, rad/s], to which the last push should have brought them.
        push: (b, 3, 3): force [N], torque [N m], and the point [m] where they act.
        resistance: (b, 2): mass [kg] and inertia [kg m2].
    """

    mount_places: Array
    mount_orientations: Array
    places: Array
    orientations: Array
    velocity: Array
    pushed: Array
    push: Array
    resistance: Array


class HandWeight(NamedTuple):
    """Gravity [m/s2] on the bases, and the weight `force` [N] of the resting hand at its `center`
    (3,) [m] of mass in the wrist frame; the arm compensates this weight.
    """

    gravity: float
    force: float
    center: Array


@compiled
def carry_bases(
    step: float, bases: Bases, weight: HandWeight, reaction: Array, arm: Arm, wrist: WristState
) -> None:
    """One step [s] of wrist and bases: compute the load, advance the wrist under it, compute the
    push. The bases' poses become those to reach. `reaction` (chains, 3) [N m], in world axes, are
    the torques that the additional inertia of the links (`HandLayout.inertia`) took from their
    bases.
    """
    feel_load(step, bases, weight, wrist)
    for b in range(len(reaction)):
        for k in range(3):
            wrist.torque[k] += reaction[b, k]
    advance_wrist(step, arm, wrist)
    next_places, next_orientations = np.empty_like(bases.places), np.empty_like(bases.orientations)
    place_bases(wrist, bases, next_places, next_orientations)
    push_bases(step, bases, weight.gravity, next_places, next_orientations)
    bases.places[:] = next_places
    bases.orientations[:] = next_orientations


@compiled
def place_bases(wrist: WristState, bases: Bases, places: Array, orientations: Array) -> None:
    """Fill the poses (b, 3) [m] and (b, 4) of the mounts on the wrist at its present pose."""
    for b in range(len(places)):
        mount = rotate(wrist.orientation, bases.mount_places[b])
        write(plus(mount, wrist.position), places[b])
        quaternion = quaternion_product(wrist.orientation, bases.mount_orientations[b])
        for k in range(4):
            orientations[b, k] = quaternion[k]


@compiled
def feel_load(step: float, bases: Bases, weight: HandWeight, wrist: WristState) -> None:
    """Compute and store the wrench of the hand on the wrist, from the differences between the
    actual and the commanded velocities of the bases. The weight of the resting hand is not
    included.
    """
    down = (0.0, 0.0, -weight.force)
    about = cross(rotate(wrist.orientation, weight.center), down)
    for k in range(3):
        wrist.force[k], wrist.torque[k] = -down[k], -about[k]
    for b in range(len(bases.places)):
        pull = _gained(step, bases.velocity[b, 0], bases.pushed[b, 0], bases.resistance[b, 0])
        twist = _gained(step, bases.velocity[b, 1], bases.pushed[b, 1], bases.resistance[b, 1])
        lever = cross(minus(bases.places[b], wrist.position), pull)
        for k in range(3):
            wrist.force[k] += pull[k]
            wrist.torque[k] += lever[k] + twist[k]


@compiled
def _gained(step: float, velocity: Array, pushed: Array, resistance: float) -> Vector:
    """Force or torque that explains the difference of a base's velocity from the one pushed to."""
    gain = minus(velocity, pushed)
    return gain[0] * resistance / step, gain[1] * resistance / step, gain[2] * resistance / step


@compiled
def push_bases(
    step: float, bases: Bases, gravity: float, next_places: Array, next_orientations: Array
) -> None:
    """Compute the forces that move the bases to their next poses within a step and compensate
    gravity [m/s2]; `bases.pushed` becomes the commanded velocity.

    A difference between the measured velocity and the one that the last push aimed at has displaced
    the bases; the push compensates this displacement.
    """
    velocity, pushed, push = bases.velocity, bases.pushed, bases.push
    for b in range(len(pushed)):
        change = quaternion_product(next_orientations[b], conjugate(bases.orientations[b]))
        sign = 2.0 if change[3] >= 0 else -2.0
        for k in range(3):
            way = next_places[b, k] - bases.places[b, k]
            for part in range(2):
                moved = velocity[b, part, k] - pushed[b, part, k]
                pushed[b, part, k] = (way if part == 0 else sign * change[k]) / step - moved
                gain = (pushed[b, part, k] - velocity[b, part, k]) / step
                push[b, part, k] = bases.resistance[b, part] * gain
            push[b, 2, k] = bases.places[b, k]
        push[b, 0, 2] += bases.resistance[b, 0] * gravity


class DrivenBases:
    """The actuators' bases: free bodies in PyBullet that are driven along with the wrist. The palm
    sheet, if there is one, is the last and yields on a spring.

    Args:
        ids: PyBullet ids of the bodies.
        mounts: place (3,) [m] and orientation (4,) of each in the wrist frame.
        resistance: mass [kg] and moment of inertia [kg m2] that drive each.
        pad: spring of the palm sheet, or None.
        weight: weight of the hand, which the wrist carries.
        client: id of the PyBullet client.
    """

    def __init__(
        self,
        ids: list[int],
        mounts: list[tuple[Array, Array]],
        resistance: list[tuple[float, float]],
        pad: PalmPad | None,
        weight: HandWeight,
        client: int,
    ) -> None:
        self.ids, self.weight, self._client = ids, weight, client
        self.pad = NO_PAD if pad is None else pad.spring
        places, orientations = (np.array(part, float) for part in zip(*mounts, strict=True))
        velocity, pushed, push = (np.zeros((len(ids), rows, 3)) for rows in (2, 2, 3))
        self.arrays = Bases(
            places,
            orientations,
            places.copy(),
            orientations.copy(),
            velocity,
            pushed,
            push,
            np.array(resistance, float),
        )
        self._velocities = self.arrays.velocity.data
        self._numbers = struct.Struct(f"{6 * len(ids)}d")

    def reset(self, wrist: Wrist) -> None:
        """Put every base at its mount on the wrist, at rest."""
        bases = self.arrays
        if self.pad is not NO_PAD:
            self.pad.state[:] = 0.0
            bases.mount_places[-1] = self.pad.place
        place_bases(wrist.state, bases, bases.places, bases.orientations)
        bases.pushed[:] = bases.velocity[:] = 0.0
        poses = zip(self.ids, bases.places.tolist(), bases.orientations.tolist(), strict=True)
        for base, position, orientation in poses:
            pybullet.resetBasePositionAndOrientation(
                base, position, orientation, physicsClientId=self._client
            )
            pybullet.resetBaseVelocity(base, [0, 0, 0], [0, 0, 0], physicsClientId=self._client)

    def read(self) -> None:
        """Read the velocities from PyBullet."""
        client = self._client
        found = [pybullet.getBaseVelocity(base, client) for base in self.ids]
        numbers = chain.from_iterable(chain.from_iterable(found))
        self._numbers.pack_into(self._velocities, 0, *numbers)

    def push(self) -> None:
        """Apply the push that `carry_bases` has computed."""
        force, torque, frame = (
            pybullet.applyExternalForce,
            pybullet.applyExternalTorque,
            pybullet.WORLD_FRAME,
        )
        client, pushes = self._client, self.arrays.push.tolist()
        for base, (along, about, place) in zip(self.ids, pushes, strict=True):
            force(base, -1, along, place, frame, client)
            torque(base, -1, about, frame, client)
