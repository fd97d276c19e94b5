"""The engine PyBullet, with the interface of `pneuflex_sim.engines.contract`."""

from __future__ import annotations

import warnings
from functools import cache
from typing import Any

import numpy as np

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.engines.contract import Surroundings
from pneuflex_sim.hand.bodies import HandBodies
from pneuflex_sim.hand.collision import Touch
from pneuflex_sim.hand.layout import TRUE_STEP
from pneuflex_sim.hand.wrist import Wrist
from pneuflex_sim.scene.contacts import OBJECT, Contact, ContactNames
from pneuflex_sim.scene.friction import BodyFriction
from pneuflex_sim.scene.object_body import ObjectBody
from pneuflex_sim.scene.scenes import build_scene
from pneuflex_sim.world import BulletState, World
from softhand_common.numerics.arrays import Array
from softhand_model.effects.load import STANDARD_GRAVITY

FAR_PLACE = np.array([0.0, 0.0, 100.0])  # of hand and scene [m]


@cache  # once a process
def _warn_of_slow_motion(step: float) -> None:
    """RuntimeWarning that hands move too slowly at this step [s]."""
    limit = 1e3 * TRUE_STEP
    warnings.warn(
        f"step: expected at most {limit:g} ms with PyBullet where something moves or rolls, got "
        f"{1e3 * step:g} ms: fingers move too slowly at this step, so that a grasp may succeed "
        f"or fail wrongly (bodies at rest are exact); use {TRUE_STEP:g} s or the engine mujoco",
        RuntimeWarning,
        stacklevel=2,
    )


class PybulletEngine:
    """A PyBullet world that contains hand, object and scene."""

    def __init__(self, around: Surroundings) -> None:
        if around.step > TRUE_STEP and not around.scene.rigid_wrist:
            _warn_of_slow_motion(around.step)
        friction = around.friction
        self.world = World(around.step, around.gui, around.solver)
        client = self.world.client
        gravity = -STANDARD_GRAVITY * around.weight_scale
        pybullet.setGravity(0, 0, gravity, physicsClientId=client)
        self.bodies = HandBodies(
            around.layout,
            around.air,
            self.world,
            around.wrist,
            around.scene.rigid_wrist,
            around.weight_scale,
            Touch(around.collision, friction.hand, around.finger_contact),
        )
        material = around.object.material if around.object else None
        self.fixed_names = build_scene(around.scene, friction, material, client)
        self.object: ObjectBody | None = None
        if around.object is not None:
            towards_hand = friction.towards_hand(around.object.material)
            self.object = ObjectBody(around.object, towards_hand, self.world)
        self._names = self._contact_names(self.fixed_names)
        self._friction = BodyFriction(client)

    def _contact_names(self, fixed: dict[int, str]) -> ContactNames:
        layout, links = self.bodies.layout, {}
        for body, base in zip(layout.bodies, self.bodies.ids, strict=True):
            for chain in body.chains:
                joints = layout.chain_joints[chain]
                for joint in range(joints.start, joints.stop):
                    links[base, joint - body.joints.start] = (chain, layout.names[joint])
        palm = dict.fromkeys([*self.bodies.ids, *self.bodies.palm_ids], "palm_plate")
        return ContactNames(palm | fixed | {self.object_id: OBJECT}, links, self.world.client)

    @property
    def broken(self) -> bool:
        """Whether the simulation has diverged."""
        return self.world.broken

    @property
    def object_id(self) -> int:
        """PyBullet's id of the object, -1 in a scene without one."""
        return -1 if self.object is None else self.object.id

    def drive(self, ambient: float, pressures_abs: Array, volumes: Array, wrist: Wrist) -> None:
        """Apply the torques of the joints at absolute pressures [Pa] and volumes [m3] of the
        channels, and advance the wrist under the load of the last step.
        """
        self.bodies.drive(ambient, pressures_abs, volumes, wrist)

    def advance(self, wrist: Wrist) -> None:
        """Simulate one step."""
        pybullet.stepSimulation(physicsClientId=self.world.client)
        self.bodies.read()

    def contacts(self) -> list[Contact]:
        """All contact points that carry a force."""
        return self._names.contacts()

    def object_contacts(self) -> list[Contact]:
        """Contact points of the object with anything."""
        return [] if self.object is None else self._names.contacts(self.object.id)

    def touching_object(self) -> frozenset[str]:
        """Names of the bodies that press on the object."""
        return frozenset() if self.object is None else self._names.touching(self.object.id)

    def object_gaps(self, reach: float) -> dict[str, float]:
        """Distance [m] of the object from each part of the hand within a reach [m]."""
        found: dict[str, float] = {}
        for base in [*self.bodies.ids, *self.bodies.palm_ids]:
            for name, gap in self._names.gaps(base, self.object_id, reach):
                found[name] = min(gap, found.get(name, np.inf))
        return found

    def object_boxes(self) -> Array:
        """Boxes (k, 2, 3) [m] around the parts of the object."""
        body = self.object
        return self.world.boxes([] if body is None else [(body.id, k) for k in body.surfaces])

    def hand_boxes(self) -> Array:
        """Boxes (k, 2, 3) [m] around the hand's links, palm sheet and plate."""
        bodies = self.bodies
        links = [
            (base, link)
            for base, body in zip(bodies.ids, bodies.layout.bodies, strict=True)
            for link in range(body.joints.stop - body.joints.start)
        ]
        return self.world.boxes([*links, *((base, -1) for base in bodies.palm_ids)])

    def scale_friction(self, factor: float) -> None:
        """Set sliding and twisting friction of every pair of bodies to `factor` [-] times the
        initial one.
        """
        self._friction.scale(factor)

    def save(self) -> tuple[BulletState, tuple[Any, ...]]:
        """The state; its memory in PyBullet is freed with the last reference to it."""
        return BulletState(self.world), self.bodies.save()

    def restore(self, saved: tuple[BulletState, tuple[Any, ...]]) -> None:
        """Return to a state of `save`."""
        if self.object is not None:
            self._forget_contacts(self.object)
        saved[0].restore()
        self.bodies.restore(saved[1])

    def _forget_contacts(self, body: ObjectBody) -> None:
        """Drop the object's cached contact points: PyBullet keeps those that a state lacks, and an
        object that is put back where it lay would start with them.
        """
        body.put(FAR_PLACE, (0.0, 0.0, 0.0))
        pybullet.performCollisionDetection(physicsClientId=self.world.client)

    def close(self) -> None:
        """Free the physics client."""
        self.world.close()
