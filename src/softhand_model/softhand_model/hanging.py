"""Free bending of a finger that its own weight pulls at, in the deformed shape.

A finger hangs from its base, or stands on it, in the vertical plane in which it bends. With the
angle theta(x) against the vertical, theta' = kappa, and a weight w per length [N/m], the part
beyond x pulls at x with the moment M, M' = -w*(L - x)*sin(theta), M(L) = 0: positive, so that it
straightens, when the finger hangs. Arrays are (lanes, rows, sections) as in `effects.stages`, with
the Gauss points along a finger as sections.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from softhand_model.balance import Balanced, Elastic, first_slope, iterate, rough_stretch
from softhand_model.effects.stages import SectionShape

Array = NDArray[np.float64]

SETTLED = (
    1e-9  # last step of the stretch: with a matrix that stays it is not much larger than the error
)
REFRESHED = 7  # steps of an iteration after which the matrix of its steps is made anew


def running_integral(edges: Array, points: int) -> Array:
    """Matrix (n, n) [m] that integrates from the first edge to each Gauss point a function given
    there, on pieces between edges [m] with so many points each; n = pieces*points.

    >>> matrix = running_integral(np.array([0.0, 0.5, 2.0]), 3)
    >>> x = matrix @ np.ones(6)
    >>> bool(np.allclose(matrix @ x**2, x**3 / 3.0))
    True
    """
    nodes, weights = legendre.leggauss(points)
    series = np.eye(points)
    to_series = (np.arange(points) + 0.5)[:, None] * legendre.legval(nodes, series) * weights
    from_start = [legendre.legval(nodes, legendre.legint(one, lbnd=-1)) for one in series]
    half = np.diff(edges) / 2.0
    inside = np.kron(np.diag(half), np.transpose(from_start) @ to_series)
    whole_pieces = np.kron(np.tril(np.ones((len(half), len(half))), -1), np.ones((points, points)))
    return np.asarray(inside + whole_pieces * np.kron(half, weights), float)


@dataclass(frozen=True)
class Weight:
    """The weight of fingers: what it does to the balance of their sections.

    per_length (lanes, rows, 1) [N/m]: positive where the finger hangs from its base, negative where
    it stands on it. reach (1, rows, sections) [m]: from each section to the tip; weights the same:
    of its Gauss point. running (rows, sections, sections) [m]: `running_integral` of each row.
    """

    per_length: Array
    reach: Array
    weights: Array
    running: Array

    def of_rows(self, rows: NDArray[np.intp]) -> Weight:
        """Some of the rows, or rows that repeat."""
        return Weight(
            self.per_length[:, rows],
            self.reach[:, rows],
            self.weights[:, rows],
            self.running[rows],
        )

    def solver(self, shape: SectionShape, alike: int = 1) -> WeightSolver:
        """What balances sections of this shape under the weight and a load.

        alike: number of rows in a row that are so much alike that one matrix serves them all.
        """
        return WeightSolver(self, shape, alike)


class WeightSolver:
    """Balance of elastic side, load and weight: q = s - m, m = ratio*M/(2*G*h*d*z).

    Newton's method with secants for the elastic side, in which the inverse of the matrix of the
    sections' equations stays as long as it serves, from step to step.
    """

    def __init__(self, weight: Weight, shape: SectionShape, alike: int) -> None:
        beyond = weight.weights[0][:, None, :] - weight.running
        self._lever = beyond * weight.reach[0][:, None, :]
        self._turn = weight.running / np.broadcast_to(shape.height, weight.reach.shape)[0][:, None]
        self._scale = (
            weight.per_length
            * shape.ratio
            / (2.0 * shape.shear_modulus * shape.height * shape.wall * shape.width)
        )
        self._alike = alike
        self._inverse: Array | None = None

    def __call__(self, elastic: Elastic, load: Array, start: Balanced | None) -> Balanced:
        """Stretch [-] in balance, from a start if there is one."""
        steps = 0

        def correction(stretch: Array, stress: Array, slope: Array) -> Array:
            nonlocal steps
            angle = _same_in_lanes(self._turn, stretch - 1.0)
            moment = self._scale * _same_in_lanes(self._lever, np.sin(angle))
            if self._inverse is None:
                self._inverse = self._inverted(angle, slope, self._alike)
            elif steps % REFRESHED == REFRESHED - 1:
                self._inverse = self._inverted(angle, slope)
            steps += 1
            return np.matmul(self._inverse, (load - moment - stress)[..., None])[..., 0]

        if start is None:
            start = first_slope(elastic, rough_stretch(load + 0.0 * self._scale))
        return iterate(elastic, correction, start, SETTLED)

    def _inverted(self, angle: Array, slope: Array, alike: int = 1) -> Array:
        """Inverse (lanes, rows, sections, sections) of the slope of elastic side and moment."""
        some = np.arange(0, angle.shape[-2], alike)
        bent = (self._lever[some] * np.cos(angle[..., some, None, :])) @ self._turn[some]
        matrix = self._scale[..., some, :, None] * bent
        matrix += slope[..., some, :, None] * np.eye(matrix.shape[-1])
        inverse = np.linalg.inv(matrix)
        return inverse if alike == 1 else inverse[..., np.arange(angle.shape[-2]) // alike, :, :]


def _same_in_lanes(matrices: Array, vectors: Array) -> Array:
    """Products of a matrix (rows, n, n) a row with the vectors (lanes, rows, n) of all lanes."""
    product = np.matmul(vectors.swapaxes(0, 1), matrices.swapaxes(1, 2))
    return np.ascontiguousarray(product.swapaxes(0, 1))
