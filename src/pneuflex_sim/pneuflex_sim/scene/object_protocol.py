"""The interface of the body of an object in any engine."""

from __future__ import annotations

from typing import Protocol

from scipy.spatial.transform import Rotation

from pneuflex_sim.scene.objects import ObjectDescription
from softhand_common.numerics.arrays import Array


class BodyOfObject(Protocol):
    """The body of an object, with its present `mass` [kg] and its description."""

    mass: float
    description: ObjectDescription

    @property
    def is_sheet(self) -> bool:
        """Whether the object is a limp sheet."""

    def set_mass(self, mass: float) -> None:
        """Set the mass [kg], with the same distribution."""

    def resist(self, mass: float, inertia: float) -> None:
        """Set the mass [kg] and inertia [kg m2] of the holder of the object, added to its own."""

    def put(self, position: Array, rpy: tuple[float, ...], yaw: float = 0.0) -> None:
        """Put the object at rest at a position (3,) [m] with roll, pitch, yaw (3,) [rad], turned by
        another `yaw` [rad] about the vertical.
        """

    def put_at(self, position: Array, rotation: Rotation) -> None:
        """Put the object at rest at a position (3,) [m] with an orientation."""

    def pose(self) -> tuple[Array, Array]:
        """Position (3,) [m] and quaternion; raises Diverged when they are not finite."""

    def velocity(self) -> tuple[Array, Array]:
        """Velocity [m/s] and spin [rad/s] in the world."""

    def push(self, force: Array, torque: Array) -> None:
        """For one step, add a force [N] at the object's centre of mass and a torque [N m], in world
        axes.
        """

    def pull_down(self, acceleration: float) -> None:
        """For one step, add the weight that the object has at an acceleration [m/s2]."""
