"""Springs in the joints of a chain: how far each turns under a moment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from softhand_model.vector_fields import (
    cross,
    cross_matrix,
    exponentials,
    inverse,
    product,
    transposed,
    turned,
    turned_back,
)

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Factor = Callable[[Array, Array, Indices], Array]
"""Factor (n,) [-] on the stiffness in bending, given actual and free bend (n,) [rad] and which
points they belong to.
"""

STEPS = 12
TOLERANCE = 1e-14  # of the rotation [rad]
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

    def rotate(self, joint: int, moment: Array) -> tuple[Array, Array]:
        """Rotation vector (3, n) [rad] of a joint under a moment (3, n) [N m], and its derivative.

        Both in the rest frame. An isotropic spring turns about the moment; any other balances
        K*e = J(e)^T moment, J the left Jacobian.
        """
        stiffness = self.stiffness[joint]
        rotation = moment / stiffness
        if self.coupling is None and self.factor is None:
            compliance = np.zeros((3, 3, len(stiffness)))
            compliance[[0, 1, 2], [0, 1, 2]] = 1.0 / stiffness
            return rotation, compliance
        for _ in range(STEPS):
            residual, slope, jacobian = self._balance(joint, rotation, moment)
            step = turned(inverse(slope), residual)
            rotation = rotation - step
            if np.max(np.abs(step)) < TOLERANCE:
                break
        _, slope, jacobian = self._balance(joint, rotation, moment)
        return rotation, product(inverse(slope), transposed(jacobian))

    def _balance(self, joint: int, rotation: Array, moment: Array) -> tuple[Array, Array, Array]:
        """K*e - J^T moment (3, n), its derivative by e (3, 3, n), and J (3, 3, n)."""
        elastic, slope = self._elastic(joint, rotation)
        _, jacobian = exponentials(rotation)
        return (
            elastic - turned_back(jacobian, moment),
            slope - _slope_of_transposed_jacobian(rotation, moment),
            jacobian,
        )

    def _elastic(self, joint: int, rotation: Array) -> tuple[Array, Array]:
        """K*e (3, n) [N m] and its derivative (3, 3, n) [N m/rad]."""
        stiffness, rest = self.stiffness[joint], self.rest[joint]
        matrix = np.zeros((3, 3, len(stiffness)))
        matrix[[0, 1, 2], [0, 1, 2]] = stiffness
        if self.coupling is not None:
            matrix[0, 2] = matrix[2, 0] = self.coupling * stiffness
        elastic = turned(matrix, rotation)
        if self.factor is not None:
            bend = rest + rotation[1]
            factor = self.factor(bend, rest, self.points)
            more = self.factor(bend + DIFFERENCE, rest, self.points)
            less = self.factor(bend - DIFFERENCE, rest, self.points)
            elastic[1] = factor * elastic[1]
            rise = rotation[1] * (more - less) / (2.0 * DIFFERENCE)
            matrix[1, 1] = stiffness * (factor + rise)
        return elastic, matrix


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
