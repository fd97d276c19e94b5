"""A damped spring in six directions that holds the object in front of the hand, as an experimenter
does (section 8.2.2), and is released gradually.

Stiffness and resistance are our choice. The engine's contacts see masses, but no springs. So mass
and inertia of the holding hand, with which the spring is well damped, are added to the object. The
damping force of a step is evaluated at its end; otherwise steps of 10 ms diverge.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from pneuflex_sim.scene.object_protocol import BodyOfObject
from softhand_common.numerics.arrays import Array

SPRING_STIFFNESS, SPRING_TURN_STIFFNESS = 500.0, 5.0  # [N/m], [N m/rad]
HOLDING_MASS, HOLDING_INERTIA = 0.1, 5e-4  # of what holds it [kg], [kg m2]
SPRING_DAMPING = 2.0 * np.sqrt(SPRING_STIFFNESS * HOLDING_MASS)  # [N s/m]
SPRING_TURN_DAMPING = 2.0 * np.sqrt(SPRING_TURN_STIFFNESS * HOLDING_INERTIA)  # [N m s/rad]


@dataclass(frozen=True)
class ObjectSpring:
    """Pose at which the object is held, position (3,) [m] and orientation (4,) in the wrist frame;
    from `let_go` [s] on the spring fades within `fade` [s].
    """

    position: tuple[float, ...]
    orientation: tuple[float, ...]
    let_go: float = np.inf
    fade: float = 0.0

    def __post_init__(self) -> None:
        lengths = len(self.position), len(self.orientation)
        if lengths != (3, 4) or not np.isfinite([*self.position, *self.orientation]).all():
            raise ValueError(
                "held object: expected a position of three finite numbers and a quaternion, got "
                f"{self.position}, {self.orientation}"
            )
        if not abs(np.linalg.norm(self.orientation) - 1) < 1e-2:
            raise ValueError(
                f"held object: expected a unit quaternion x y z w, got {self.orientation}"
            )
        if not self.fade >= 0:
            raise ValueError(
                f"held object: expected a time of release of 0 s or more, got {self.fade} s"
            )

    def fading(self, now: float, duration: float) -> ObjectSpring:
        """A copy whose stiffness decreases to zero within a duration [s] from now."""
        return replace(self, let_go=now, fade=duration)

    def strength(self, now: float) -> float:
        """Remaining share of the spring at a time [s], 1 to 0."""
        since = now - self.let_go
        if since < 0.0:
            return 1.0
        return 0.0 if since >= self.fade else 1.0 - since / self.fade

    def pose(self, wrist_position: Array, wrist_orientation: Array) -> tuple[Array, Rotation]:
        """Position [m] and rotation in the world where the object is held."""
        wrist = Rotation.from_quat(wrist_orientation)
        place = wrist_position + wrist.apply(self.position)
        return place, wrist * Rotation.from_quat(self.orientation)

    def pull(
        self, body: BodyOfObject, wrist: tuple[Array, Array], now: float, step: float, weight: float
    ) -> None:
        """Apply the spring's force and torque to a body for one step [s].

        `wrist` is position [m] and quaternion of the wrist, `now` the time [s], `weight` [N] that
        of the body and of the holding mass.
        """
        share = self.strength(now)
        body.resist(share * HOLDING_MASS, share * HOLDING_INERTIA)
        place, turn = self.pose(*wrist)
        position, orientation = body.pose()
        velocity, spin = body.velocity()
        error = (turn * Rotation.from_quat(orientation).inv()).as_rotvec()
        damping = SPRING_DAMPING / (1.0 + step * SPRING_DAMPING / HOLDING_MASS)
        turn_damping = SPRING_TURN_DAMPING / (1.0 + step * SPRING_TURN_DAMPING / HOLDING_INERTIA)
        force = (
            SPRING_STIFFNESS * (place - position)
            - damping * velocity
            + np.array([0.0, 0.0, weight])
        )
        body.push(share * force, share * (SPRING_TURN_STIFFNESS * error - turn_damping * spin))
