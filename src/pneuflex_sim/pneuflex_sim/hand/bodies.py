"""A hand as PyBullet bodies: one floating multibody per serial chain, all carried rigidly by the
wrist (see `driven_bases`).
"""

from __future__ import annotations

import math
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.hand.air import AirCoupling
from pneuflex_sim.hand.collision import (
    PALM_GROUP,
    Touch,
    collides_with,
    collision_groups,
    link_shapes,
    set_margin,
)
from pneuflex_sim.hand.driven_bases import (
    BASE_INERTIA,
    BASE_MASS,
    PALM_INERTIA,
    PALM_MASS,
    DrivenBases,
    HandWeight,
)
from pneuflex_sim.hand.kinematics import HandShape
from pneuflex_sim.hand.layout import Body, HandLayout
from pneuflex_sim.hand.palm_pad import PalmPad, create_plate
from pneuflex_sim.hand.step import Carrier, HandArrays, drive_hand, joint_torques, plain
from pneuflex_sim.hand.wrist import Wrist
from pneuflex_sim.world import World
from softhand_common.numerics.compiled import compiled
from softhand_model.dynamics.joint_springs import Joints, look_at_joints, nothing_before
from softhand_model.effects.load import STANDARD_GRAVITY

Array = NDArray[np.float64]

NO_ROTATION = (0.0, 0.0, 0.0, 1.0)
SPEED_CLAMP = 1e5  # [rad/s]; at PyBullet's 100, contacts that hold a loaded joint push too little
SPEED_LIMIT = 95.0  # [rad/s] that a joint may exceed for an instant only, after a blow
LONGEST_BLOW = 0.1  # [s]
# chosen on the clashes and blows of `bench.sim --rows holding`
CALM_STEPS = 20  # after a contact or fast motion, until a chain gets inertia back
CALM_SPEED = 15.0  # [rad/s] of a joint, above which it gets none: 100 kPa in 50 ms diverged


class JointStates:
    """Orientations and velocities of the spherical joints of some bodies, each with `counts` joints
    and no others. The arrays are allocated once.
    """

    def __init__(self, bodies: list[int], counts: list[int], client: int) -> None:
        self._bodies = [
            (body, list(range(count))) for body, count in zip(bodies, counts, strict=True)
        ]
        self._client, n = client, sum(counts)
        heavy = np.zeros(len(bodies), bool)
        self.joints = Joints(np.tile(NO_ROTATION, (n, 1)), np.zeros((n, 3)), heavy)
        self._orientations, self._q = struct.Struct(f"{4 * n}d"), self.joints.q.data
        self._velocities, self._v = struct.Struct(f"{3 * n}d"), self.joints.v.data

    def read(self) -> None:
        """Fill the arrays. Lists, struct and positional arguments are used because this runs in
        every step.
        """
        client, orientations, velocities = self._client, [], []
        for body, joints in self._bodies:
            for q, v, _, _ in pybullet.getJointStatesMultiDof(body, joints, client):
                orientations += q
                velocities += v
        self._orientations.pack_into(self._q, 0, *orientations)
        self._velocities.pack_into(self._v, 0, *velocities)

    def push(self, torque: Array) -> None:
        """Apply torques (n, 3) [N m] to the joints in the next step, in their child frames."""
        torques, first = torque.tolist(), 0
        for body, joints in self._bodies:
            last = first + len(joints)
            pybullet.setJointMotorControlMultiDofArray(
                body,
                joints,
                pybullet.TORQUE_CONTROL,
                forces=torques[first:last],
                physicsClientId=self._client,
            )
            first = last


class HandBodies:
    """The chains of one hand in a world; arrays have one row per joint, in the order of the layout.

    Attributes:
        q, v: orientations (n, 4) and velocities (n, 3) [rad/s] of the joints.
        rotations: (n, 3) [rad], rotation vector of each joint relative to its rest without
            pressure; y is the bend.
        torque: (n, 3) [N m] of the springs.
    """

    def __init__(
        self,
        layout: HandLayout,
        air: AirCoupling,
        world: World,
        wrist: Wrist,
        rigid: bool,
        weight_scale: float,
        touch: Touch,
    ) -> None:
        self.layout, self.world, self.rigid, self.touch = layout, world, rigid, touch
        self._by_tables = air.by_tables
        self.ids = [self._create_body(body) for body in layout.bodies]
        counts = [body.joints.stop - body.joints.start for body in layout.bodies]
        self._states = JointStates(self.ids, counts, world.client)
        self.q, self.v, self._heavy = self._states.joints
        self.rotations = np.zeros_like(self.v)
        before = nothing_before(len(self.v), len(self.ids))
        self.torque, self._calm_steps = before.torque, np.zeros(len(self.ids), int)
        self._pressing, self._chain_ends = np.zeros(len(self.ids), bool), np.cumsum(counts)
        hand = HandArrays(
            layout.links(world.step_size),
            layout.springs(),
            self._states.joints,
            air.total_gain,
            air.tables,
            air.actuation,
            before,
        )
        self._gives_back = bool(hand.links.given.any())
        self._rest, self._before, self._hand = hand.springs.rest, hand.before, plain(hand)
        self.pad = None if layout.description.sheet is None else PalmPad(layout.description.sheet)
        self.palm_ids = [] if self.pad is None else self._create_palm(self.pad)
        self.bases = self._driven_bases(weight_scale * STANDARD_GRAVITY)
        bases = self.bases
        self._carrier = plain(Carrier(bases.arrays, bases.weight, bases.pad, wrist.arm))
        self.reset(wrist)

    # ---------------------------------------------------------------- creation
    def _driven_bases(self, gravity: float) -> DrivenBases:
        layout, ids = self.layout, [*self.ids]
        mounts = [(body.position, body.orientation) for body in layout.bodies]
        resistance = [(BASE_MASS, BASE_INERTIA)] * len(ids)
        if self.pad is not None:
            ids += self.palm_ids
            mounts += self._palm_mounts(self.pad)
            resistance += [(PALM_MASS, PALM_INERTIA)] * len(self.palm_ids)
        center = HandShape(layout).center_of_mass(layout.rest)
        weight = HandWeight(gravity, float(layout.mass.sum()) * gravity, center)
        return DrivenBases(ids, mounts, resistance, self.pad, weight, self.world.client)

    def _create_body(self, body: Body) -> int:
        layout, client, joints = self.layout, self.world.client, body.joints
        count = joints.stop - joints.start
        shapes = link_shapes(layout, body, self.touch.kind, client)
        base = pybullet.createMultiBody(
            0.0 if self.rigid else BASE_MASS,
            -1,
            -1,
            linkMasses=layout.mass[joints].tolist(),
            linkCollisionShapeIndices=shapes,
            linkVisualShapeIndices=[-1] * count,
            linkPositions=layout.offset[joints].tolist(),
            linkOrientations=[NO_ROTATION] * count,
            linkInertialFramePositions=layout.center[joints].tolist(),
            linkInertialFrameOrientations=[NO_ROTATION] * count,
            linkParentIndices=list(range(count)),
            linkJointTypes=[pybullet.JOINT_SPHERICAL] * count,
            linkJointAxis=[(0, 0, 1)] * count,
            physicsClientId=client,
        )
        self._set_dynamics(base, body)
        return base

    def _create_palm(self, pad: PalmPad) -> list[int]:
        """Bodies that touch with the plate, if there is one, and with the sheet on it."""
        mass, plate = 0.0 if self.rigid else PALM_MASS, self.layout.description.plate
        palm = [create_plate(plate, mass, self.world.client)] if plate is not None else []
        palm.append(pad.create(mass, self.world.client))
        for base in palm:
            self._set_base_dynamics(base, (PALM_MASS, PALM_INERTIA))
            pybullet.changeDynamics(
                base, -1, lateralFriction=self.touch.friction, physicsClientId=self.world.client
            )
            pybullet.setCollisionFilterGroupMask(
                base, -1, PALM_GROUP, collides_with(PALM_GROUP), physicsClientId=self.world.client
            )
        return palm

    def _palm_mounts(self, pad: PalmPad) -> list[tuple[Array, Array]]:
        plate = self.layout.description.plate
        own = [] if plate is None else [(np.array(plate.position), np.array(NO_ROTATION))]
        return [*own, (pad.spring.place, pad.orientation)]

    def _set_base_dynamics(self, base: int, resistance: tuple[float, float]) -> None:
        mass, inertia = resistance
        client = self.world.client
        pybullet.changeDynamics(
            base,
            -1,
            linearDamping=0,
            angularDamping=0,
            maxJointVelocity=SPEED_CLAMP,
            physicsClientId=client,
        )
        if not self.rigid:
            pybullet.changeDynamics(
                base,
                -1,
                mass=mass,
                localInertiaDiagonal=[inertia] * 3,
                physicsClientId=client,
            )

    def _set_dynamics(self, base: int, body: Body) -> None:
        layout, client = self.layout, self.world.client
        inertia = layout.inertia(self.world.step_size)
        self._set_base_dynamics(base, (BASE_MASS, BASE_INERTIA))
        pybullet.setCollisionFilterGroupMask(base, -1, PALM_GROUP, 0, physicsClientId=client)
        groups = collision_groups(layout, body)
        for link, joint in enumerate(range(body.joints.start, body.joints.stop)):
            pybullet.changeDynamics(
                base,
                link,
                mass=layout.mass[joint],
                localInertiaDiagonal=inertia[joint].tolist(),
                linearDamping=0,
                angularDamping=0,
                jointDamping=0,
                lateralFriction=self.touch.friction,
                **self.touch.skin,
                physicsClientId=client,
            )
            set_margin(base, link, self.touch.kind, client)
            mask = collides_with(groups[link], self.touch.neighbours)
            pybullet.setCollisionFilterGroupMask(
                base, link, groups[link], mask, physicsClientId=client
            )
            pybullet.setJointMotorControlMultiDof(
                base,
                link,
                pybullet.POSITION_CONTROL,
                targetPosition=NO_ROTATION,
                positionGain=0,
                velocityGain=0,
                force=[0, 0, 0],
                physicsClientId=client,
            )

    # ---------------------------------------------------------------- state
    def reset(self, wrist: Wrist, joints: Array | None = None) -> None:
        """Put every base at the wrist and every joint at its orientation in `joints` (n, 4), by
        default at rest without pressure; all velocities are zero.
        """
        joints = self.layout.rest if joints is None else joints
        self.bases.reset(wrist)
        for body, base in zip(self.layout.bodies, self.ids, strict=True):
            for link, joint in enumerate(range(body.joints.start, body.joints.stop)):
                pybullet.resetJointStateMultiDof(
                    base, link, joints[joint].tolist(), [0, 0, 0], physicsClientId=self.world.client
                )
        self._first, self._fast_time = True, 0.0
        self.read()
        self._calm_steps[:] = CALM_STEPS  # the engine still says what touched before
        self._heavy[:] = False

    def read(self) -> None:
        """Take joint orientations and velocities from PyBullet; raises Diverged when the simulation
        has diverged.
        """
        self._states.read()
        if self._gives_back:
            self._look_for_calm()
        if not self.rigid:
            self.bases.read()
        fastest = look_at_joints(self._rest, self.q, self.v, self.rotations)
        self._fast_time = self._fast_time + self.world.step_size if fastest > SPEED_LIMIT else 0.0
        if not math.isfinite(fastest) or self._fast_time > LONGEST_BLOW:
            raise self.world.diverged(self._diverged(fastest))

    def _look_for_calm(self) -> None:
        """Which chains press on something or are fast, or did so a short time ago."""
        points = pybullet.getContactPoints(physicsClientId=self.world.client)
        pressing = {body for point in points if point[9] > 0.0 for body in point[1:3]}
        self._pressing[:] = [base in pressing for base in self.ids]
        count_calm_steps(self.v, self._chain_ends, self._pressing, self._calm_steps, self._heavy)

    def _diverged(self, fastest: float) -> str:
        """Message about a joint that stays fast; a blow may make one fast for an instant."""
        joint = self.layout.names[int(np.argmax(np.abs(self.v).max(axis=1)))]
        return (
            f"the simulation diverged: joint {joint} turns at {fastest:.0f} rad/s for "
            f"{1e3 * self._fast_time:.0f} ms (expected below {SPEED_LIMIT:.0f}); "
            "a smaller step or slower commands are needed"
        )

    def save(self) -> tuple[Any, ...]:
        """The state that is kept in Python; `BulletState` has PyBullet's own."""
        return (self._first, self._fast_time, *(array.copy() for array in self._arrays()))

    def restore(self, state: tuple[Any, ...]) -> None:
        """Return to a state of `save`; PyBullet's own state must be restored before."""
        self._first, self._fast_time = state[:2]
        for array, saved in zip(self._arrays(), state[2:], strict=True):
            array[:] = saved

    def _arrays(self) -> list[NDArray[Any]]:
        v, torque, placed, *more = self._before
        kept = [self.q, self.v, self.rotations, self._heavy, self._calm_steps]
        kept += [v, torque, *placed, *more]
        return [*kept, *self.bases.arrays, self.bases.pad.state]

    # ---------------------------------------------------------------- forces
    def drive(self, ambient: float, pressures_abs: Array, volumes: Array, wrist: Wrist) -> None:
        """Apply the torques of all joints at these absolute pressures [Pa] and volumes [m3] of the
        channels; advance the wrist under the load of the last step, and push the bases along.
        """
        step = (self.world.step_size, self._first)
        air = (self._by_tables, ambient, pressures_abs, volumes)
        if self.rigid:
            joint_torques(*step, *air, self._hand)
        else:
            drive_hand(*step, *air, self._hand, self._carrier, tuple(wrist.state))
            self.bases.push()
        self._first = False
        self._states.push(self.torque)


@compiled
def count_calm_steps(
    v: Array,
    ends: NDArray[np.int64],
    pressing: NDArray[np.bool_],
    calm_steps: NDArray[np.int64],
    heavy: NDArray[np.bool_],
) -> None:
    """Count the steps (chains,) since each chain was pressing (chains,) or fast, and mark those
    with less than CALM_STEPS as heavy (chains,).

    `v` (n, 3) [rad/s] are the velocities of the joints; the joints of chain i end before the index
    ends[i].
    """
    first = 0
    for chain in range(len(ends)):
        stirred = pressing[chain]
        for joint in range(first, ends[chain]):
            for axis in range(3):
                stirred |= abs(v[joint, axis]) > CALM_SPEED
        calm_steps[chain] = 0 if stirred else calm_steps[chain] + 1
        heavy[chain] = calm_steps[chain] < CALM_STEPS
        first = ends[chain]
