"""A limp sheet in PyBullet: stiff strips side by side, on hinges with dry friction."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pybullet
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pneuflex_sim.solids import box_solid

Array = NDArray[np.float64]

WAVE = 0.1  # [rad] by which strips stand up and down at first: a flat sheet would not buckle
IDENTITY = (0.0, 0.0, 0.0, 1.0)
SIDES = (1, -1)


class Sheet:
    """Strips along y; the middle one is the base, and a chain of them hangs on either side of it.

    strip_moments (3,): principal moments per mass [m2] of a strip.
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
        """Angle [rad] of each hinge at first: a wave that stands on the base and both ends."""
        per_side = self.strips // 2
        wave = [-WAVE] + [2 * WAVE * (-1) ** k for k in range(per_side - 1)]
        return [side * angle for side in SIDES for angle in wave]

    def strips_at_first(self) -> list[tuple[Array, Array, Array]]:
        """Size (3,) [m], middle (3,) [m] and turn (3, 3) of every strip in the base's frame."""
        found = [(self.size, np.zeros(3), np.eye(3))]
        per_side = self.strips // 2
        for number, side in enumerate(SIDES):
            hinge, tilt = np.array([0.5 * side * self.pitch, 0.0, 0.0]), 0.0
            for angle in self.angles[number * per_side : (number + 1) * per_side]:
                tilt += angle
                turn = Rotation.from_euler("y", tilt).as_matrix()
                along = turn @ [side * self.pitch, 0.0, 0.0]
                found.append((self.size, hinge + 0.5 * along, turn))
                hinge = hinge + along
        return found

    def create(self, client: int) -> int:
        """Create the body with masses of 1 kg; its PyBullet id."""
        count, pitch = self.strips - 1, self.pitch
        sides = np.repeat(SIDES, count // 2)
        first = [k % (count // 2) == 0 for k in range(count)]
        shapes = {side: self._shape(side, client) for side in (0, *SIDES)}
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
            linkOrientations=[IDENTITY] * count,
            linkInertialFramePositions=[(0.5 * side * pitch, 0.0, 0.0) for side in sides],
            linkInertialFrameOrientations=[IDENTITY] * count,
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
        """Hinges to their first angles, at rest, with their friction."""
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
