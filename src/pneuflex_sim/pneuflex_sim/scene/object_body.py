"""The body of an object in PyBullet: creation, placement, mass and forces. A limp sheet is modelled
as strips on hinges.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.hand.collision import ENVIRONMENT_GROUP
from pneuflex_sim.scene.objects import ObjectDescription
from pneuflex_sim.scene.solids import box_solid
from pneuflex_sim.world import World
from softhand_common.documents.output_file import write_file
from softhand_common.numerics.arrays import Array

# [rad] by which strips stand up and down at first: a flat sheet would not buckle
HINGE_WAVE_ANGLE = 0.1
NO_ROTATION = (0.0, 0.0, 0.0, 1.0)
SHEET_SIDES = (1, -1)
MAX_ROTATION_PER_STEP = 1.0  # [rad] by which an object may rotate in one step


class Sheet:
    """A limp sheet of strips along y. The middle strip is the base; a chain of strips hangs on
    either side of it.

    `strip_moments` (3,): principal moments per mass [m2] of a strip.
    """

    def __init__(self, dimensions: Mapping[str, Any]) -> None:
        length, width, thickness = dimensions["size"]
        self.strips: int = dimensions["strips"]
        self.friction: float = dimensions["hinge_friction"]
        self.pitch = length / self.strips
        self.size = np.array([self.pitch, width, dimensions["contact_thickness"]])
        self.strip_moments = np.diag(box_solid([self.pitch, width, thickness]).inertia)

    @property
    def angles(self) -> list[float]:
        """Initial angle [rad] of each hinge: a wave that stands on the base and on both ends."""
        per_side = self.strips // 2
        wave = [-HINGE_WAVE_ANGLE] + [2 * HINGE_WAVE_ANGLE * (-1) ** k for k in range(per_side - 1)]
        return [side * angle for side in SHEET_SIDES for angle in wave]

    def strips_at_first(self) -> list[tuple[Array, Array, Array]]:
        """Size (3,) [m], middle (3,) [m] and rotation (3, 3) of every strip in the base's frame,
        initially.
        """
        found = [(self.size, np.zeros(3), np.eye(3))]
        per_side = self.strips // 2
        for number, side in enumerate(SHEET_SIDES):
            hinge, tilt = np.array([0.5 * side * self.pitch, 0.0, 0.0]), 0.0
            for angle in self.angles[number * per_side : (number + 1) * per_side]:
                tilt += angle
                rotation = Rotation.from_euler("y", tilt).as_matrix()
                along = rotation @ [side * self.pitch, 0.0, 0.0]
                found.append((self.size, hinge + 0.5 * along, rotation))
                hinge = hinge + along
        return found

    def create(self, client: int) -> int:
        """Create the body with masses of 1 kg; returns its PyBullet id."""
        count, pitch = self.strips - 1, self.pitch
        sides = np.repeat(SHEET_SIDES, count // 2)
        first = [k % (count // 2) == 0 for k in range(count)]
        shapes = {side: self._shape(side, client) for side in (0, *SHEET_SIDES)}
        body = pybullet.createMultiBody(
            1.0,
            shapes[0],
            -1,
            linkMasses=[1.0] * count,
            linkCollisionShapeIndices=[shapes[side] for side in sides],
            linkVisualShapeIndices=[-1] * count,
            linkPositions=[
                (side * pitch * (0.5 if at_base else 1.0), 0.0, 0.0)
                for side, at_base in zip(sides, first, strict=True)
            ],
            linkOrientations=[NO_ROTATION] * count,
            linkInertialFramePositions=[(0.5 * side * pitch, 0.0, 0.0) for side in sides],
            linkInertialFrameOrientations=[NO_ROTATION] * count,
            linkParentIndices=[0 if at_base else k for k, at_base in enumerate(first)],
            linkJointTypes=[pybullet.JOINT_REVOLUTE] * count,
            linkJointAxis=[(0, 1, 0)] * count,
            physicsClientId=client,
        )
        self.reset(body, client)
        return int(body)

    def _shape(self, side: int, client: int) -> int:
        return pybullet.createCollisionShape(
            pybullet.GEOM_BOX,
            halfExtents=(0.5 * self.size).tolist(),
            collisionFramePosition=(0.5 * side * self.pitch, 0.0, 0.0),
            physicsClientId=client,
        )

    def reset(self, body: int, client: int) -> None:
        """Reset the hinges to their initial angles, at rest, with their friction."""
        for hinge, angle in enumerate(self.angles):
            pybullet.resetJointState(body, hinge, angle, 0.0, physicsClientId=client)
            pybullet.setJointMotorControl2(
                body,
                hinge,
                pybullet.VELOCITY_CONTROL,
                targetVelocity=0.0,
                force=self.friction,
                physicsClientId=client,
            )


class ObjectBody:
    """One object in a world.

    Attributes:
        id: PyBullet's id of the body.
        mass: present mass [kg].
        surfaces: indices of the links with which the object touches.
    """

    def __init__(self, description: ObjectDescription, friction: float, world: World) -> None:
        client = world.client
        self.description, self._client, self._world = description, client, world
        self.sheet = Sheet(description.dimensions) if description.shape == "sheet" else None
        solid = description.geometry.solid
        if self.sheet is not None:
            self._moments, self._axes = self.sheet.strip_moments, np.array(NO_ROTATION)
            self.id = self.sheet.create(client)
        else:
            self._moments, self._axes = solid.principal()
            self.id = self._create_cylinder() if self._round else self._create_rigid()
        links = range(-1, pybullet.getNumJoints(self.id, physicsClientId=client))
        self.links = links[:1] if self.sheet is None else links
        self.surfaces = links[1:] if self._round else links
        self._to_own = Rotation.from_quat(self._axes).inv()
        self._set_surface(friction)
        self._limit_spin(world.step_size)
        self.set_mass(description.mass)

    def _create_rigid(self) -> int:
        return int(
            pybullet.createMultiBody(
                self.description.mass,
                collision_shape(self.description, self._client),
                visual_shape(self.description, self._client),
                baseInertialFrameOrientation=self._axes.tolist(),
                physicsClientId=self._client,
            )
        )

    @property
    def is_sheet(self) -> bool:
        """Whether the object is a limp sheet."""
        return self.sheet is not None

    @property
    def _round(self) -> bool:
        return self.description.shape == "cylinder"

    def _create_cylinder(self) -> int:
        """Two halves end to end (`parts` of the dimensions, if another number), as links without
        mass: PyBullet finds one contact of a shape with a plane in a step, and what rolls fast
        would tip over it and sink. (As parts of one shape they would touch alike, but PyBullet does
        not save the contacts of such a shape.)
        """
        radius, _, half_length = self.description.half_extents
        count = self.description.dimensions.get("parts", 2)
        length = 2 * half_length / count
        part = pybullet.createCollisionShape(
            pybullet.GEOM_CYLINDER, radius=radius, height=length, physicsClientId=self._client
        )
        return int(
            pybullet.createMultiBody(
                self.description.mass,
                linkMasses=[0.0] * count,
                linkCollisionShapeIndices=[part] * count,
                linkVisualShapeIndices=[-1] * count,
                linkPositions=[(0, 0, (k + 0.5) * length - half_length) for k in range(count)],
                linkOrientations=[NO_ROTATION] * count,
                linkInertialFramePositions=[(0.0, 0.0, 0.0)] * count,
                linkInertialFrameOrientations=[NO_ROTATION] * count,
                linkParentIndices=[0] * count,
                linkJointTypes=[pybullet.JOINT_FIXED] * count,
                linkJointAxis=[(0, 0, 1)] * count,
                physicsClientId=self._client,
            )
        )

    def _set_surface(self, friction: float) -> None:
        compliance, soft = self.description.compliance, {}
        if compliance is not None:
            soft = {"contactStiffness": compliance.stiffness, "contactDamping": compliance.damping}
        for link in self.surfaces:
            pybullet.changeDynamics(
                self.id,
                link,
                lateralFriction=friction,
                linearDamping=0,
                angularDamping=0,
                jointDamping=0,
                physicsClientId=self._client,
                **soft,
            )
            pybullet.setCollisionFilterGroupMask(
                self.id, link, ENVIRONMENT_GROUP, -1, physicsClientId=self._client
            )

    def _limit_spin(self, step: float) -> None:
        """Limit the spin. PyBullet's own limit of 100 rad/s would brake a marker that rolls faster
        than 0.85 m/s; without a limit, slender objects that spin fast gained energy in random
        trials.
        """
        pybullet.changeDynamics(
            self.id, -1, maxJointVelocity=MAX_ROTATION_PER_STEP / step, physicsClientId=self._client
        )

    def set_mass(self, mass: float) -> None:
        """Set the mass [kg], with the same distribution."""
        self.mass = mass
        self.resist(0.0, 0.0)

    def resist(self, mass: float, inertia: float) -> None:
        """Set the mass [kg] and inertia [kg m2] that a holder adds to each link of the object."""
        share = self.mass / len(self.links)
        for link in self.links:
            pybullet.changeDynamics(
                self.id,
                link,
                mass=share + mass,
                localInertiaDiagonal=(share * self._moments + inertia).tolist(),
                physicsClientId=self._client,
            )

    def velocity(self) -> tuple[Array, Array]:
        """Velocity [m/s] and spin [rad/s] in the world."""
        along, about = pybullet.getBaseVelocity(self.id, physicsClientId=self._client)
        return np.array(along), np.array(about)

    def push(self, force: Array, torque: Array) -> None:
        """For one step, add a force [N] at the object's centre of mass and a torque [N m], in world
        axes.
        """
        frame, client = pybullet.WORLD_FRAME, self._client
        pybullet.applyExternalForce(self.id, -1, force.tolist(), self._center(-1), frame, client)
        pybullet.applyExternalTorque(self.id, -1, torque.tolist(), frame, client)

    def put(self, position: Array, rpy: tuple[float, ...], yaw: float = 0.0) -> None:
        """Put the object at rest at a position (3,) [m] with roll, pitch, yaw (3,) [rad], turned by
        another `yaw` [rad] about the vertical.
        """
        self.put_at(position, Rotation.from_euler("xyz", (*rpy[:2], rpy[2] + yaw)))

    def put_at(self, position: Array, rotation: Rotation) -> None:
        """Put the object at rest at a position (3,) [m] with an orientation."""
        if not self._own_axes:
            rotation = rotation * self._to_own.inv()
        quaternion = rotation.as_quat().tolist()
        pybullet.resetBasePositionAndOrientation(
            self.id, position.tolist(), quaternion, physicsClientId=self._client
        )
        pybullet.resetBaseVelocity(self.id, [0, 0, 0], [0, 0, 0], physicsClientId=self._client)
        if self.sheet is not None:
            self.sheet.reset(self.id, self._client)

    @property
    def _own_axes(self) -> bool:
        """Whether the engine's axes (the principal ones) are the object's own axes."""
        return bool(self._axes[3] == 1.0)

    def pose(self) -> tuple[Array, Array]:
        """Position (3,) [m] and quaternion (4,); raises Diverged when they are not finite."""
        place, found = pybullet.getBasePositionAndOrientation(self.id, physicsClientId=self._client)
        if not np.isfinite(place).all():
            raise self._world.diverged(f"the simulation diverged: the object is at {place}")
        if self._own_axes:
            return np.array(place), np.array(found)
        return np.array(place), (Rotation.from_quat(found) * self._to_own).as_quat()

    def pull_down(self, acceleration: float) -> None:
        """For one step, add the weight that the object has at an acceleration [m/s2]."""
        share = -acceleration * self.mass / len(self.links)
        for link in self.links:
            pybullet.applyExternalForce(
                self.id,
                link,
                [0, 0, share],
                self._center(link),
                pybullet.WORLD_FRAME,
                physicsClientId=self._client,
            )

    def _center(self, link: int) -> tuple[float, ...]:
        if link < 0:
            return pybullet.getBasePositionAndOrientation(self.id, physicsClientId=self._client)[0]
        return pybullet.getLinkState(
            self.id, link, computeForwardKinematics=1, physicsClientId=self._client
        )[0]


def collision_shape(description: ObjectDescription, client: int) -> int:
    """Create the PyBullet collision shape of a rigid object."""
    if description.geometry.pieces:
        return _shape_of_pieces(description.geometry.pieces, client)
    half = description.half_extents
    if description.shape == "box":
        return pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=half, physicsClientId=client
        )
    return pybullet.createCollisionShape(
        pybullet.GEOM_SPHERE, radius=half[0], physicsClientId=client
    )


def visual_shape(description: ObjectDescription, client: int) -> int:
    """Create the PyBullet visual shape of the surface of an object made of pieces; -1 for others,
    whose collision shape is drawn.
    """
    surface = description.geometry.surface
    if surface is None:
        return -1
    return int(
        pybullet.createVisualShape(
            pybullet.GEOM_MESH,
            vertices=surface.vertices.tolist(),
            indices=surface.indices.tolist(),
            normals=surface.normals.tolist(),
            physicsClientId=client,
        )
    )


def _shape_of_pieces(pieces: tuple[Array, ...], client: int) -> int:
    """One shape of several hulls: PyBullet takes them from an OBJ file with one object a hull."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "pieces.obj"
        write_file(path, _obj_text(pieces))
        return int(
            pybullet.createCollisionShape(
                pybullet.GEOM_MESH, fileName=str(path), physicsClientId=client
            )
        )


def _obj_text(pieces: tuple[Array, ...]) -> str:
    lines, first = [], 1
    for number, piece in enumerate(pieces):
        lines.append(f"o piece_{number}")
        lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in piece]
        lines += [f"f {a} {b} {c}" for a, b, c in ConvexHull(piece).simplices + first]
        first += len(piece)
    return "\n".join(lines) + "\n"
