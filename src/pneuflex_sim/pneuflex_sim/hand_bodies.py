"""A hand as PyBullet bodies: one floating multibody per serial chain, all carried rigidly by the
wrist.

Each base is a heavy free body that is pushed to the velocity of the wrist in every step; what its
velocity gains beyond that push is the load of the chain on the wrist, at no cost. (A base that is
moved by resetting its pose has no velocity in the contact solver, and a held object would not
follow it.)
"""

from __future__ import annotations

from itertools import chain as chained
from typing import Any

import numpy as np
import pybullet
from numpy.typing import NDArray

from pneuflex_sim import base_kernel, spring_kernel
from pneuflex_sim.collision_groups import (
    COLLIDES_WITH,
    PALM,
    collision_groups,
)
from pneuflex_sim.collision_groups import (
    ENVIRONMENT as ENVIRONMENT,
)
from pneuflex_sim.hand_shape import HandShape
from pneuflex_sim.layout import Body, HandLayout
from pneuflex_sim.link_shapes import PIECES, link_shapes, set_margin
from pneuflex_sim.palm_pad import PalmPad
from pneuflex_sim.spatial import cross
from pneuflex_sim.world import World
from pneuflex_sim.wrist import Wrist
from softhand_model.effects.gravity import STANDARD_GRAVITY

Array = NDArray[np.float64]

BASE_MASS = 1000.0  # [kg]: so heavy that the chain does not move it within a step
BASE_INERTIA = 10.0  # [kg m2]
BASE_RESISTANCE = (BASE_MASS, BASE_INERTIA)
RUBBER_FRICTION = 1.0  # PyBullet multiplies the coefficients of both bodies
SPEED_CLAMP = 1e5  # [rad/s]; at PyBullet's 100, contacts that hold a loaded joint push too little
SPEED_LIMIT = 95.0  # [rad/s] that a joint may exceed for an instant only, after a blow
LONGEST_BLOW = 0.02  # [s]
IDENTITY = (0.0, 0.0, 0.0, 1.0)


class HandBodies:
    """The chains of one hand in a world; all arrays have one row a joint, in the order of the
    layout.
    """

    def __init__(
        self,
        layout: HandLayout,
        world: World,
        wrist: Wrist,
        rigid: bool,
        weight_scale: float,
        collision: str = PIECES,
    ) -> None:
        self.layout, self.world, self.rigid = layout, world, rigid
        self.collision = collision
        self.weight_scale = weight_scale
        self._create()
        n = len(layout.mass)
        self.q, self.v = np.tile(IDENTITY, (n, 1)), np.zeros((n, 3))
        self.torque = np.zeros((n, 3))
        self._fixed = (np.ascontiguousarray(layout.rest), np.ascontiguousarray(layout.stiffness))
        self._body_data = (
            layout.offset,
            layout.center,
            layout.inertia(world.step_size),
            layout.mass,
        )
        self._carried = (
            np.zeros((n, 3)),
            np.zeros((n, 3, 3)),
            np.zeros((n, 3)),
            np.zeros((n, 3)),
            np.zeros((n, 3, 3)),
        )
        self._starts, self._damping = layout.starts, layout.damping
        places = [body.position for body in layout.bodies]
        turns = [body.orientation for body in layout.bodies]
        if self.pad is not None:
            places, turns = [*places, self.pad.place], [*turns, self.pad.turn]
        self._mounts = np.array(places), np.array(turns)
        self._pushed = np.zeros((len(self._bases_ids), 2, 3))
        self._mass = float(layout.mass.sum())
        self._center_of_mass = HandShape(layout).center_of_mass(layout.rest)
        self.reset(wrist)

    # ---------------------------------------------------------------- creation
    def _create(self) -> None:
        self.ids = [self._create_body(body) for body in self.layout.bodies]
        sheet = self.layout.description.sheet
        self.pad = None if sheet is None else PalmPad(sheet)
        self._bases_ids = self.ids if self.pad is None else [*self.ids, self._create_pad(self.pad)]
        self._joints = [
            list(range(body.joints.stop - body.joints.start)) for body in self.layout.bodies
        ]

    def _create_body(self, body: Body) -> int:
        layout, client, joints = self.layout, self.world.client, body.joints
        count = joints.stop - joints.start
        shapes = link_shapes(layout, body, self.collision, client)
        base = pybullet.createMultiBody(
            0.0 if self.rigid else BASE_MASS,
            -1,
            -1,
            linkMasses=layout.mass[joints].tolist(),
            linkCollisionShapeIndices=shapes,
            linkVisualShapeIndices=[-1] * count,
            linkPositions=layout.offset[joints].tolist(),
            linkOrientations=[IDENTITY] * count,
            linkInertialFramePositions=layout.center[joints].tolist(),
            linkInertialFrameOrientations=[IDENTITY] * count,
            linkParentIndices=list(range(count)),
            linkJointTypes=[pybullet.JOINT_SPHERICAL] * count,
            linkJointAxis=[(0, 0, 1)] * count,
            physicsClientId=client,
        )
        self._set_dynamics(base, body)
        return base

    @property
    def pad_id(self) -> int | None:
        """PyBullet id of the palm sheet, None for a hand without one."""
        return None if self.pad is None else self._bases_ids[-1]

    def _create_pad(self, pad: PalmPad) -> int:
        client = self.world.client
        base = pad.create(0.0 if self.rigid else BASE_MASS, client)
        self._set_base_dynamics(base)
        pybullet.changeDynamics(base, -1, lateralFriction=RUBBER_FRICTION, physicsClientId=client)
        pybullet.setCollisionFilterGroupMask(
            base, -1, PALM, COLLIDES_WITH[PALM], physicsClientId=client
        )
        return base

    def _set_base_dynamics(self, base: int) -> None:
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
                mass=BASE_MASS,
                localInertiaDiagonal=[BASE_INERTIA] * 3,
                physicsClientId=client,
            )

    def _set_dynamics(self, base: int, body: Body) -> None:
        layout, client = self.layout, self.world.client
        inertia = layout.inertia(self.world.step_size)
        self._set_base_dynamics(base)
        pybullet.setCollisionFilterGroupMask(base, -1, PALM, 0, physicsClientId=client)
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
                lateralFriction=RUBBER_FRICTION,
                physicsClientId=client,
            )
            set_margin(base, link, self.collision, client)
            pybullet.setCollisionFilterGroupMask(
                base, link, groups[link], COLLIDES_WITH[groups[link]], physicsClientId=client
            )
            pybullet.setJointMotorControlMultiDof(
                base,
                link,
                pybullet.POSITION_CONTROL,
                targetPosition=IDENTITY,
                positionGain=0,
                velocityGain=0,
                force=[0, 0, 0],
                physicsClientId=client,
            )

    # ---------------------------------------------------------------- state
    def reset(self, wrist: Wrist, joints: Array | None = None) -> None:
        """Put every base at the wrist and every joint at its orientation in `joints` (n, 4), or at
        rest without pressure; nothing moves.
        """
        joints = self.layout.rest if joints is None else joints
        self._release_pad()
        self._bases = self._base_poses(wrist)
        for base, position, orientation in zip(self._bases_ids, *self._bases, strict=True):
            pybullet.resetBasePositionAndOrientation(
                base, position.tolist(), orientation.tolist(), physicsClientId=self.world.client
            )
            pybullet.resetBaseVelocity(
                base, [0, 0, 0], [0, 0, 0], physicsClientId=self.world.client
            )
        for body, base in zip(self.layout.bodies, self.ids, strict=True):
            for link, joint in enumerate(range(body.joints.start, body.joints.stop)):
                pybullet.resetJointStateMultiDof(
                    base,
                    link,
                    joints[joint].tolist(),
                    [0, 0, 0],
                    physicsClientId=self.world.client,
                )
        self._first, self._fast_time = True, 0.0
        self._pushed[:] = 0.0
        self.read()

    def read(self) -> None:
        """Take joint orientations and velocities from PyBullet; raises RuntimeError when the run
        has diverged.
        """
        client = self.world.client
        states = [
            state
            for base, joints in zip(self.ids, self._joints, strict=True)
            for state in pybullet.getJointStatesMultiDof(base, joints, physicsClientId=client)
        ]
        n = len(states)
        self.q = np.fromiter(chained.from_iterable([s[0] for s in states]), float, 4 * n).reshape(
            n, 4
        )
        self.v = np.fromiter(chained.from_iterable([s[1] for s in states]), float, 3 * n).reshape(
            n, 3
        )
        self._watch_speeds()

    def _watch_speeds(self) -> None:
        """A blow may make a joint fast for an instant; one that stays fast has diverged."""
        fastest = np.abs(self.v).max()
        self._fast_time = self._fast_time + self.world.step_size if fastest > SPEED_LIMIT else 0.0
        if not np.isfinite(fastest) or self._fast_time > LONGEST_BLOW:
            joint = self.layout.names[int(np.argmax(np.abs(self.v).max(axis=1)))]
            raise RuntimeError(
                f"the simulation diverged: joint {joint} turns at {fastest:.0f} rad/s for "
                f"{1e3 * self._fast_time:.0f} ms (expected below {SPEED_LIMIT:.0f}); "
                "a smaller step or slower commands are needed"
            )

    def rotations(self) -> Array:
        """Rotation vector (n, 3) [rad] of each joint against its rest without pressure; y is the
        bend.
        """
        out = np.empty_like(self.v)
        spring_kernel.rotations_from_rest(self._fixed[0], self.q, out)
        return out

    def save(self) -> tuple[Any, ...]:
        """The Python side of the state; PyBullet's own is saved by the world."""
        return (
            self._first,
            self._bases,
            self._fast_time,
            *(array.copy() for array in self._arrays()),
        )

    def restore(self, state: tuple[Any, ...]) -> None:
        """Return to a saved state, after PyBullet has been restored."""
        self._first, self._bases, self._fast_time = state[:3]
        for array, saved in zip(self._arrays(), state[3:], strict=True):
            array[:] = saved

    def _arrays(self) -> tuple[Array, ...]:
        pad = () if self.pad is None else (self.pad.state, self._mounts[0])
        return (self.q, self.v, self.torque, self._pushed, *self._carried, *pad)

    # ---------------------------------------------------------------- forces
    def apply_springs(self, bend: Array, gas_stiffness: Array) -> None:
        """Compute and apply joint torques for a rest orientation turned by `bend` (n, 3) [rad]."""
        rest, stiffness = self._fixed
        offset, com, inertia, mass = self._body_data
        spring_kernel.spring_torques(
            self.world.step_size,
            self._first,
            self._starts,
            self.q,
            self.v,
            rest,
            bend,
            stiffness,
            gas_stiffness,
            self._damping,
            offset,
            com,
            inertia,
            mass,
            *self._carried,
            self.torque,
        )
        self._first = False
        torques = self.torque.tolist()
        for body, base, joints in zip(self.layout.bodies, self.ids, self._joints, strict=True):
            pybullet.setJointMotorControlMultiDofArray(
                base,
                joints,
                pybullet.TORQUE_CONTROL,
                forces=torques[body.joints],
                physicsClientId=self.world.client,
            )

    def drive_bases(self, wrist: Wrist) -> None:
        """Advance the wrist under the load of the last step, and push the bases along."""
        if self.rigid:
            return
        client, step = self.world.client, self.world.step_size
        velocity = np.array(
            [pybullet.getBaseVelocity(base, physicsClientId=client) for base in self._bases_ids]
        )
        poses = self._bases
        self._sink_pad(wrist, velocity)
        base_kernel.feel_load(
            step,
            velocity,
            self._pushed,
            BASE_RESISTANCE,
            poses[0],
            self._weight(wrist),
            wrist.position,
            wrist.force,
            wrist.torque,
        )
        wrist.advance(step)
        self._bases = self._base_poses(wrist)
        push, lift = np.empty_like(velocity), self.weight_scale * STANDARD_GRAVITY
        base_kernel.push_bases(
            step, BASE_RESISTANCE, lift, poses, self._bases, velocity, self._pushed, push
        )
        places = poses[0].tolist()
        for base, place, (force, torque) in zip(
            self._bases_ids, places, push.tolist(), strict=True
        ):
            pybullet.applyExternalForce(
                base, -1, force, place, pybullet.WORLD_FRAME, physicsClientId=client
            )
            pybullet.applyExternalTorque(
                base, -1, torque, pybullet.WORLD_FRAME, physicsClientId=client
            )

    def _sink_pad(self, wrist: Wrist, velocity: Array) -> None:
        """Let the palm sheet yield to what its velocity (bases, 2, 3) [m/s] gained on the push."""
        if self.pad is None:
            return
        normal = np.empty(3)
        base_kernel.rotate(wrist.orientation, self.pad.axis, normal)
        gained = (velocity[-1, 0] - self._pushed[-1, 0]) @ normal
        self.pad.advance(self.world.step_size, -BASE_MASS * float(gained) / self.world.step_size)
        self._mounts[0][-1] = self.pad.mount()

    def _release_pad(self) -> None:
        if self.pad is not None:
            self.pad.state[:] = 0.0
            self._mounts[0][-1] = self.pad.place

    def _base_poses(self, wrist: Wrist) -> tuple[Array, Array]:
        """Positions (b, 3) [m] and quaternions (b, 4) of all bases for this wrist."""
        count = len(self._bases_ids)
        places, turns = np.empty((count, 3)), np.empty((count, 4))
        base_kernel.place_bases(wrist.position, wrist.orientation, self._mounts, places, turns)
        return places, turns

    def _weight(self, wrist: Wrist) -> Array:
        """Force and torque (2, 3) of the resting hand's weight on the wrist: an arm carries the
        tool that it knows.
        """
        weight, arm = np.zeros((2, 3)), np.empty(3)
        weight[0, 2] = -self.weight_scale * STANDARD_GRAVITY * self._mass
        base_kernel.rotate(wrist.orientation, self._center_of_mass, arm)
        cross(arm, weight[0], weight[1])
        return weight
