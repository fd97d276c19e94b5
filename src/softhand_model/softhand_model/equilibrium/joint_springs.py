"""Springs in the joints of a chain: how far each rotates under a moment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from softhand_model.chain.segments import SegmentChain
from softhand_model.hand.joint_stiffness import rubber_stress
from softhand_model.numerics.arrays import Array, Indices
from softhand_model.numerics.rotations import (
    cross,
    cross_matrix,
    exponentials,
    inverse,
    jacobian_coefficients,
    product,
    transposed,
    turned,
)

Factor = Callable[[Array, Array, Indices], Array]
"""Factor (n,) [-] on the stiffness in bending, given actual and free bend (n,) [rad] and which
points they belong to.
"""

STEPS = 30
TOLERANCE = 1e-13  # of the rotation [rad]
DIFFERENCE = 1e-7  # [rad] for the slope of the factor


@dataclass(frozen=True)
class JointSprings:
    """Joint springs at n points, linear about the rest orientation, a rotation by `rest` about y.

    stiffness, rest (joints, n) [N m/rad], [rad]; sideways (joints, 2) [-]: stiffness about x and z
    over that in bending, 1 if absent; stretching (joints,) [1/rad]: of rubber in bending
    (`joint_stiffness`), 0 for linear springs; coupling (n,) [-]: off-diagonal of bending about x
    and twist about z over the stiffness; factor: on the stiffness about y; points (n,): what the
    factor is told of the points.
    The energy of a joint is that of its rotation vector against the rest, e*K*e/2 where the springs
    are linear.
    """

    stiffness: Array
    rest: Array
    points: Indices
    coupling: Array | None = None
    factor: Factor | None = None
    sideways: Array | None = None
    stretching: Array | None = None

    def take(self, chosen: Indices) -> JointSprings:
        """The springs of some of the points."""
        return replace(
            self,
            stiffness=self.stiffness[:, chosen],
            rest=self.rest[:, chosen],
            points=self.points[chosen],
            coupling=None if self.coupling is None else self.coupling[chosen],
        )

    @cached_property
    def _rest_sines_cosines(self) -> tuple[Array, Array]:
        return np.sin(self.rest), np.cos(self.rest)

    def rest_sine_cosine(self, joint: int) -> tuple[Array, Array]:
        """Sine and cosine (n,) of a joint's rest angle."""
        sine, cosine = self._rest_sines_cosines
        return sine[joint], cosine[joint]

    def rotation(self, joint: int, moment: Array) -> Array:
        """Rotation vector (3, n) [rad] of a joint under a moment (3, n) [N m], in the rest frame.

        An isotropic spring turns about the moment; any other balances K*e = J(e)^T moment, J the
        left Jacobian.
        """
        rotation = moment / self.stiffness[joint]
        if self.isotropic:
            return rotation
        rotation = rotation / self._shares(joint)
        before, slope = 1.0, None
        for _ in range(STEPS):
            residual = self._elastic(joint, rotation) - _transposed_jacobian(rotation, moment)
            if slope is None:
                slope = inverse(self._slope(joint, rotation, moment))
            step = turned(slope, residual)
            rotation = rotation - step
            size = np.max(np.abs(step))
            if size * min(size / before, 1.0) < TOLERANCE:  # what the next step would be
                break
            if size > 0.1 * before:
                slope = None
            before = size
        return rotation

    def compliance(self, joint: int, rotation: Array, moment: Array) -> Array:
        """Derivative (3, 3, n) [rad/(N m)] of the rotation by the moment."""
        if self.isotropic:
            compliance = np.zeros((3, 3, len(self.points)))
            compliance[[0, 1, 2], [0, 1, 2]] = 1.0 / self.stiffness[joint]
            return compliance
        _, jacobian = exponentials(rotation)
        return product(inverse(self._slope(joint, rotation, moment)), transposed(jacobian))

    @property
    def isotropic(self) -> bool:
        """Whether all springs are the same about all axes."""
        more = (self.coupling, self.factor, self.sideways, self.stretching)
        return all(entry is None for entry in more)

    @property
    def softest(self) -> Array:
        """Stiffness (joints, n) [N m/rad] about the axis about which each joint is softest."""
        if self.sideways is None:
            return self.stiffness
        return self.stiffness * np.minimum(self.sideways.min(axis=1), 1.0)[:, None]

    def _elastic(self, joint: int, rotation: Array) -> Array:
        """K*e (3, n) [N m]."""
        x, y, z = rotation
        elastic = rotation * self._shares(joint)
        if self.stretching is not None:
            elastic[1] = self._rubber(joint, y)[0]
        if self.coupling is not None:
            elastic[0] += self.coupling * z
            elastic[2] += self.coupling * x
        if self.factor is not None:
            rest = self.rest[joint]
            elastic[1] *= self.factor(rest + y, rest, self.points)
        return elastic * self.stiffness[joint]

    def _slope(self, joint: int, rotation: Array, moment: Array) -> Array:
        """Derivative (3, 3, n) of K*e - J^T moment by e."""
        stiffness, rest = self.stiffness[joint], self.rest[joint]
        slope = -_slope_of_transposed_jacobian(rotation, moment)
        slope[[0, 1, 2], [0, 1, 2]] += stiffness * self._shares(joint)
        if self.coupling is not None:
            slope[[0, 2], [2, 0]] += self.coupling * stiffness
        bent, tangent = self._rubber(joint, rotation[1])
        if self.factor is not None:
            bend = rest + rotation[1]
            factor, more, less = (
                self.factor(bend + shift, rest, self.points)
                for shift in (0.0, DIFFERENCE, -DIFFERENCE)
            )
            rise = bent * (more - less) / (2.0 * DIFFERENCE)
            slope[1, 1] += stiffness * (factor * tangent + rise - 1.0)
        else:
            slope[1, 1] += stiffness * (tangent - 1.0)
        return slope

    def _shares(self, joint: int) -> Array:
        """Stiffness (3, 1) [-] about x, y, z over that in bending."""
        lateral, twist = (1.0, 1.0) if self.sideways is None else self.sideways[joint]
        return np.array([[lateral], [1.0], [twist]])

    def _rubber(self, joint: int, bend: Array) -> tuple[Array, Array | float]:
        """Moment over stiffness (n,) [rad] at a bend (n,) [rad] from rest, and its slope [-]."""
        gain = 0.0 if self.stretching is None else float(self.stretching[joint])
        if gain == 0.0:
            return bend, 1.0
        (here, slope), (there, _) = (
            rubber_stress(1.0 + gain * angle)
            for angle in (self.rest[joint] + bend, self.rest[joint])
        )
        return (here - there) / (2.0 * gain), 0.5 * slope


def springs_of(chain: SegmentChain, rest: Array, modulus: Array | float = 1.0) -> JointSprings:
    """The springs of a chain at rest angles (joints, n) [rad], of a rubber whose shear modulus is
    `modulus` (n,) [-] over the chain's.
    """
    points, bending = rest.shape[1], chain.stiffness[:, 1:2]
    sideways = chain.stiffness[:, [0, 2]] / bending
    return JointSprings(
        bending * np.broadcast_to(modulus, points),
        rest,
        np.arange(points),
        sideways=None if np.all(sideways == 1.0) else sideways,
        stretching=chain.stretching if chain.stretching.any() else None,
    )


def _transposed_jacobian(rotation: Array, moment: Array) -> Array:
    """J(e)^T m (3, n), J the left Jacobian of rotation vectors: m - b*(e x m) + c*e x (e x m)."""
    b, c = jacobian_coefficients(np.sum(rotation * rotation, axis=0))
    across = cross(rotation, moment)
    return moment - b * across + c * cross(rotation, across)


def _slope_of_transposed_jacobian(rotation: Array, moment: Array) -> Array:
    """Derivative (3, 3, n) of J(e)^T m by e: J^T m = m - b*(e x m) + c*e x (e x m), b and c as at
    e = 0 but for the first order.
    """
    e, m = rotation, moment
    em = np.sum(e * m, axis=0)
    across = cross(e, m)
    # d(e x m) = -[m] de; d(e x (e x m)) = (e.m + e m^T - 2 m e^T) de; db = -e.de/12
    slope = 0.5 * cross_matrix(m)
    slope += across[:, None] * e[None] / 12.0
    slope += (e[:, None] * m[None] - 2.0 * m[:, None] * e[None]) / 6.0
    slope[[0, 1, 2], [0, 1, 2]] += em / 6.0
    return slope
