"""Springs in the joints of a chain: how far each turns under a moment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from softhand_model.vector_fields import (
    cross,
    cross_matrix,
    exponentials,
    inverse,
    jacobian_coefficients,
    product,
    transposed,
    turned,
)

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Factor = Callable[[Array, Array, Indices], Array]
"""Factor (n,) [-] on the stiffness in bending, given actual and free bend (n,) [rad] and which
points they belong to.
"""

STEPS = 30
TOLERANCE = 1e-13  # of the rotation [rad]
DIFFERENCE = 1e-7  # [rad] for the slope of the factor


@dataclass(frozen=True)
class JointSprings:
    """Joint springs at n points, linear about the rest orientation, a turn by `rest` about y.

    stiffness, rest (joints, n) [N m/rad], [rad]; coupling (n,) [-]: off-diagonal of bending about x
    and twist about z over the stiffness; factor: on the stiffness about y; points (n,): what the
    factor is told of the points.
    The energy of a joint is that of its rotation vector against the rest, e*K*e/2.
    """

    stiffness: Array
    rest: Array
    points: Indices
    coupling: Array | None = None
    factor: Factor | None = None

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
    def _turns(self) -> tuple[Array, Array]:
        return np.sin(self.rest), np.cos(self.rest)

    def turn(self, joint: int) -> tuple[Array, Array]:
        """Sine and cosine (n,) of a joint's rest angle."""
        sine, cosine = self._turns
        return sine[joint], cosine[joint]

    def rotation(self, joint: int, moment: Array) -> Array:
        """Rotation vector (3, n) [rad] of a joint under a moment (3, n) [N m], in the rest frame.

        An isotropic spring turns about the moment; any other balances K*e = J(e)^T moment, J the
        left Jacobian.
        """
        rotation = moment / self.stiffness[joint]
        if self.isotropic:
            return rotation
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
        return self.coupling is None and self.factor is None

    def _elastic(self, joint: int, rotation: Array) -> Array:
        """K*e (3, n) [N m]."""
        x, y, z = rotation
        elastic = np.array(rotation)
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
        slope[[0, 1, 2], [0, 1, 2]] += stiffness
        if self.coupling is not None:
            slope[[0, 2], [2, 0]] += self.coupling * stiffness
        if self.factor is not None:
            bend = rest + rotation[1]
            factor, more, less = (
                self.factor(bend + shift, rest, self.points)
                for shift in (0.0, DIFFERENCE, -DIFFERENCE)
            )
            rise = rotation[1] * (more - less) / (2.0 * DIFFERENCE)
            slope[1, 1] += stiffness * (factor + rise - 1.0)
        return slope


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
