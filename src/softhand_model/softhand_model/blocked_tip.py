"""A finger whose tip is held against a gauge: straight at rest, and its tip may not deflect.

The gauge pushes with F, so each section carries M = F*(L - x), and F follows from the deflection of
the tip, int(kappa*(L - x)) dx = F/stiffness of the gauge (0 for a rigid one). Arrays are (lanes,
rows, sections) as in `effects.stages`, with the Gauss points along a finger as sections.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softhand_model.balance import Balanced, Elastic, balance, first_slope, iterate, rough_stretch
from softhand_model.effects.stages import SectionShape

Array = NDArray[np.float64]

LEAST_START = 0.7  # stretch, where the search begins at the least
StiffnessFactor = Callable[[Array, Array], Array | float]
"""Factor [-] on the stiffness at an actual and a free curvature [1/m]."""


@dataclass(frozen=True)
class Blocked:
    """Fingers with a blocked tip: reach (1, rows, sections) [m] from each section to the tip,
    weights the same: of its Gauss point; compliance [m/N] of the gauge, a number or (lanes, 1, 1).
    """

    reach: Array
    weights: Array
    compliance: Array | float

    def of_rows(self, rows: NDArray[np.intp]) -> Blocked:
        """Some of the rows, or rows that repeat."""
        return Blocked(self.reach[:, rows], self.weights[:, rows], self.compliance)

    def spring_force(self, free: Array, stiffness: Array, factor: StiffnessFactor) -> Array:
        """Force (lanes, rows, 1) [N] with linear springs of stiffness B [N m2] about the free
        curvature [1/m] (section 5.2.3).

        >>> blocked = Blocked(np.array([0.75, 0.25]), np.array([0.5, 0.5]), 0.0)
        >>> blocked.spring_force(np.ones(2), np.full(2, 3.0), lambda bend, rest: 1.0).round(3)
        array([4.8])
        """
        deflection = np.sum(self.weights * free * self.reach, axis=-1, keepdims=True)
        force = deflection / self._give(stiffness)
        stiffness = stiffness * factor(free - force * self.reach / stiffness, free)
        return deflection / self._give(stiffness)

    def _give(self, stiffness: Array) -> Array:
        """Deflection of the tip per force [m/N], the gauge's included."""
        square = self.weights * self.reach**2 / stiffness
        return np.sum(square, axis=-1, keepdims=True) + self.compliance


class BlockedSolver:
    """Balance of elastic side, load and tip force: q = s - m, m = ratio*F*(L - x)/(2*G*h*d*z).

    Newton's method with secants for the elastic side, in which the force is eliminated. factor: on
    the stiffness, if there is one; it divides m.

    force (lanes, rows, 1) [N]: of the last balance.
    """

    def __init__(
        self, blocked: Blocked, shape: SectionShape, factor: StiffnessFactor | None = None
    ) -> None:
        self._blocked, self._height, self._factor = blocked, shape.height, factor
        self._moment = (  # m of a unit force
            shape.ratio
            * blocked.reach
            / (2.0 * shape.shear_modulus * shape.height * shape.wall * shape.width)
        )
        self._deflection = blocked.weights * blocked.reach / shape.height  # per stretch
        self._free: Balanced | None = None
        self.force = np.zeros(1)

    def __call__(self, elastic: Elastic, load: Array, start: Balanced | None) -> Balanced:
        """Stretch [-] in balance, from a start if there is one."""
        if self._factor is not None:
            self._free = balance(elastic, load, self._free)

        def correction(stretch: Array, stress: Array, slope: Array) -> Array:
            moment = self._moment_at(stretch)
            unbalanced = load - stress
            there = _total(self._deflection * (stretch - 1.0 + unbalanced / slope))
            give = _total(self._deflection * moment / slope) + self._blocked.compliance
            self.force = there / give
            return (unbalanced - moment * self.force) / slope

        if start is None:
            start = first_slope(elastic, self._rough(load))
        return iterate(elastic, correction, start)

    def _moment_at(self, stretch: Array) -> Array:
        """What a unit force takes off the load [-] at a stretch."""
        if self._factor is None or self._free is None:
            return self._moment
        free = (self._free.stretch - 1.0) / self._height
        return self._moment / self._factor((stretch - 1.0) / self._height, free)

    def _rough(self, load: Array) -> Array:
        """Stretch of a beam of even stiffness: back at its base, forth at its tip."""
        place = self._blocked.reach / _total(self._blocked.weights)
        free = rough_stretch(load + 0.0 * self._moment) - 1.0
        return np.maximum(1.0 + free * (1.0 - 1.5 * place), LEAST_START)


def _total(values: Array) -> Array:
    return np.sum(values, axis=-1, keepdims=True)
