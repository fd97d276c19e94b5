"""The compliant wrist: a mass and an inertia on a damped spring of limited force that follows a
target pose.

It stands for an impedance-controlled arm: force = stiffness*(target - pose) - damping*velocity, cut
off at the force limit, plus what the hand feels. The arm carries the hand's own weight.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pneuflex_sim.dynamics.spatial import (
    conjugate,
    minus,
    quaternion_of_rotation,
    quaternion_product,
)
from softhand_model.numerics.compiled import compiled

Array = NDArray[np.float64]


@dataclass(frozen=True)
class WristParameters:
    """Stiffness [N/m, N m/rad], limits [N, N m], effective mass [kg] and inertia [kg m2] of the
    arm; critically damped.

    Raises ValueError for a value that is not positive.
    """

    stiffness: float = 1000.0
    rotational_stiffness: float = 30.0
    force_limit: float = 20.0
    torque_limit: float = 4.0
    mass: float = 2.0
    inertia: float = 0.02

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not value > 0:
                raise ValueError(f"wrist {name}: expected a positive number, got {value!r}")


@dataclass
class Wrist:
    """State of the wrist in the world: position [m], quaternion, velocity [m/s], spin [rad/s], and
    the hand's wrench on it.
    """

    parameters: WristParameters
    position: Array
    orientation: Array
    velocity: Array = field(default_factory=lambda: np.zeros(3))
    spin: Array = field(default_factory=lambda: np.zeros(3))
    force: Array = field(default_factory=lambda: np.zeros(3))
    torque: Array = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        self.target_position, self.target_orientation = (
            self.position.copy(),
            self.orientation.copy(),
        )
        p = self.parameters
        self.springs = (  # stiffness, inertia and limit of the translation and of the rotation
            (float(p.stiffness), float(p.mass), float(p.force_limit)),
            (float(p.rotational_stiffness), float(p.inertia), float(p.torque_limit)),
        )

    def command(self, position: Array, orientation: Array) -> None:
        """Set the target pose in the world: position (3,) [m], quaternion (4,); raises ValueError
        for unusable numbers.
        """
        place, turn = np.array(position, float), np.array(orientation, float)
        if place.shape != (3,) or not np.isfinite(place).all():
            raise ValueError(
                f"wrist target position: expected three finite numbers, got {position}"
            )
        if turn.shape != (4,) or not abs(np.linalg.norm(turn) - 1) < 1e-2:
            raise ValueError(
                f"wrist target orientation: expected a unit quaternion x, y, z, w, got {turn}"
            )
        self.target_position, self.target_orientation = place, turn / np.linalg.norm(turn)

    @property
    def arrays(self) -> tuple[Array, ...]:
        """What `hand_kernel` calls wrist."""
        return (
            self.target_position,
            self.target_orientation,
            self.force,
            self.torque,
            self.position,
            self.orientation,
            self.velocity,
            self.spin,
        )

    def advance(self, step: float) -> None:
        """One implicit step of the damped spring under the wrench of the hand."""
        translation, rotation = self.springs
        advance_wrist(
            step,
            translation,
            rotation,
            (self.target_position, self.target_orientation),
            (self.force, self.torque),
            (self.position, self.orientation, self.velocity, self.spin),
        )


@compiled
def advance_wrist(step, translation, rotation, target, load, state):
    """Advance `state` (position, orientation, velocity, spin) in place by one step.

    `translation` and `rotation` are (stiffness, inertia, limit), `target` (position, orientation),
    `load` (force, torque).
    """
    position, orientation, velocity, spin = state
    _drive(minus(target[0], position), velocity, load[0], *translation, step)
    _drive(_rotation_error(target[1], orientation), spin, load[1], *rotation, step)
    for k in range(3):
        position[k] += step * velocity[k]
    turn = quaternion_of_rotation((step * spin[0], step * spin[1], step * spin[2]))
    after = quaternion_product(turn, orientation)
    norm = math.sqrt(after[0] ** 2 + after[1] ** 2 + after[2] ** 2 + after[3] ** 2)
    for k in range(4):
        orientation[k] = after[k] / norm


@compiled
def _rotation_error(target, orientation):
    """Rotation vector [rad], in world axes, that turns `orientation` into `target`."""
    change = quaternion_product(target, conjugate(orientation))
    norm = math.sqrt(change[0] ** 2 + change[1] ** 2 + change[2] ** 2)
    factor = 2.0 if norm < 1e-9 else 2 * math.atan2(norm, abs(change[3])) / norm
    if change[3] < 0:
        factor = -factor
    return factor * change[0], factor * change[1], factor * change[2]


@compiled
def _drive(error, velocity, load, stiffness, mass, limit, step):
    """Update `velocity` by one step of mass*a = clip(stiffness*error - damping*v) + load, implicit
    in the spring.
    """
    damping = 2 * math.sqrt(stiffness * mass)
    inertia = mass + step * damping + step**2 * stiffness
    drive, size = np.empty(3), 0.0
    for k in range(3):
        force = stiffness * (error[k] - step * velocity[k]) - damping * velocity[k] + load[k]
        drive[k] = mass * force / inertia - load[k]
        size += drive[k] ** 2
    scale = min(1.0, limit / math.sqrt(size)) if size > 0 else 1.0
    for k in range(3):
        velocity[k] += step * (drive[k] * scale + load[k]) / mass
