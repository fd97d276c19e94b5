"""The compliant wrist: a mass and an inertia on a damped spring of limited force that follows a
target pose.

It models an impedance-controlled arm: force = stiffness*(target - pose) - damping*velocity, clipped
at the force limit, plus the load of the hand. The arm compensates the hand's own weight.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from softhand_common.numerics.compiled import compiled
from softhand_model.dynamics.spatial import (
    Row,
    Vector,
    conjugate,
    minus,
    quaternion_of_rotation,
    quaternion_product,
)

Array = NDArray[np.float64]


@dataclass(frozen=True)
class WristParameters:
    """Stiffness [N/m, N m/rad], limits [N, N m], effective mass [kg] and inertia [kg m2] of the
    arm, which is critically damped, and its workspace: how far a target may lie from the world's
    origin along each axis [m].

    Raises ValueError for a value that is not positive.
    """

    stiffness: float = 1000.0
    rotational_stiffness: float = 30.0
    force_limit: float = 20.0
    torque_limit: float = 4.0
    mass: float = 2.0
    inertia: float = 0.02
    workspace: float = 2.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not value > 0:
                raise ValueError(f"wrist {name}: expected a positive number, got {value!r}")


class Drive(NamedTuple):
    """Translational or rotational part of the arm: stiffness [N/m or N m/rad], inertia [kg or kg
    m2] and limit [N or N m].
    """

    stiffness: float
    inertia: float
    limit: float


class Arm(NamedTuple):
    """The arm that holds the wrist."""

    translation: Drive
    rotation: Drive


class WristState(NamedTuple):
    """The arrays of a `Wrist` for the kernels, which change them, and its target pose."""

    position: Array
    orientation: Array
    velocity: Array
    spin: Array
    force: Array
    torque: Array
    target_position: Array
    target_orientation: Array


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
        p = self.parameters
        self.arm = Arm(
            Drive(float(p.stiffness), float(p.mass), float(p.force_limit)),
            Drive(float(p.rotational_stiffness), float(p.inertia), float(p.torque_limit)),
        )
        self.state = WristState(
            self.position,
            self.orientation,
            self.velocity,
            self.spin,
            self.force,
            self.torque,
            self.position.copy(),
            self.orientation.copy(),
        )

    def command(self, position: Array, orientation: Array) -> None:
        """Set the target pose in the world: position (3,) [m], quaternion (4,); raises ValueError
        for numbers that are not finite or no unit quaternion, and for a position outside of the
        workspace.
        """
        place, quaternion = np.array(position, float), np.array(orientation, float)
        if place.shape != (3,) or not np.isfinite(place).all():
            raise ValueError(
                f"wrist target position: expected three finite numbers, got {position}"
            )
        reach = self.parameters.workspace
        if np.abs(place).max() > reach:
            raise ValueError(
                f"wrist target position: expected coordinates within +-{reach:g} m, got {position}"
            )
        if quaternion.shape != (4,) or not abs(np.linalg.norm(quaternion) - 1) < 1e-2:
            raise ValueError(
                f"wrist target orientation: expected a unit quaternion x, y, z, w, got {quaternion}"
            )
        self.state.target_position[:] = place
        self.state.target_orientation[:] = quaternion / np.linalg.norm(quaternion)


@compiled
def advance_wrist(step: float, arm: Arm, wrist: WristState) -> None:
    """Advance the state of the wrist by one implicit step [s] of the arm's damped springs under the
    hand's load.
    """
    error = minus(wrist.target_position, wrist.position)
    _drive(error, wrist.velocity, wrist.force, arm.translation, step)
    error = _rotation_error(wrist.target_orientation, wrist.orientation)
    _drive(error, wrist.spin, wrist.torque, arm.rotation, step)
    for k in range(3):
        wrist.position[k] += step * wrist.velocity[k]
    spin = wrist.spin
    change = quaternion_of_rotation((step * spin[0], step * spin[1], step * spin[2]))
    after = quaternion_product(change, wrist.orientation)
    norm = math.sqrt(after[0] ** 2 + after[1] ** 2 + after[2] ** 2 + after[3] ** 2)
    for k in range(4):
        wrist.orientation[k] = after[k] / norm


@compiled
def _rotation_error(target: Array, orientation: Array) -> Vector:
    """Rotation vector [rad], in world axes, that turns `orientation` into `target`."""
    change = quaternion_product(target, conjugate(orientation))
    norm = math.sqrt(change[0] ** 2 + change[1] ** 2 + change[2] ** 2)
    factor = 2.0 if norm < 1e-9 else 2 * math.atan2(norm, abs(change[3])) / norm
    if change[3] < 0:
        factor = -factor
    return factor * change[0], factor * change[1], factor * change[2]


@compiled
def _drive(error: Row, velocity: Array, load: Array, drive: Drive, step: float) -> None:
    """Update `velocity` by one step of mass*a = push + load."""
    push = arm_push(error, velocity, load, drive, step)
    for k in range(3):
        velocity[k] += step * (push[k] + load[k]) / drive.inertia


@compiled
def arm_push(error: Row, velocity: Array, load: Array, drive: Drive, step: float) -> Vector:
    """Push (3,) [N or N m] of the arm: clip(stiffness*error - damping*v), implicit in the spring
    under a load (3,).
    """
    stiffness, mass = drive.stiffness, drive.inertia
    damping = 2 * math.sqrt(stiffness * mass)
    inertia = mass + step * damping + step**2 * stiffness
    push, size = np.empty(3), 0.0
    for k in range(3):
        force = stiffness * (error[k] - step * velocity[k]) - damping * velocity[k] + load[k]
        push[k] = mass * force / inertia - load[k]
        size += push[k] ** 2
    scale = min(1.0, drive.limit / math.sqrt(size)) if size > 0 else 1.0
    return push[0] * scale, push[1] * scale, push[2] * scale


@compiled
def arm_wrench(step: float, arm: Arm, wrist: WristState, wrench: Array) -> None:
    """Fill force [N] and torque [N m] of the arm on the wrist (2, 3), in world axes, for a step [s]
    under the load of the step before.
    """
    error = minus(wrist.target_position, wrist.position)
    force = arm_push(error, wrist.velocity, wrist.force, arm.translation, step)
    error = _rotation_error(wrist.target_orientation, wrist.orientation)
    torque = arm_push(error, wrist.spin, wrist.torque, arm.rotation, step)
    for k in range(3):
        wrench[0, k], wrench[1, k] = force[k], torque[k]
