"""A finger under load: bent by its own weight, or with its tip blocked.

A finger bends in a vertical plane. With the angle theta(x) against its base, theta' = kappa, the
tilt of the base phi (0 if the finger hangs from it), a weight w per length [N/m] and a load W at
the tip [N], what lies beyond x pulls at x with the moment M, M' = -(w*(L - x) + W)*sin(theta +
phi), M(L) = 0: positive, so that it straightens, when the finger hangs. Where the base is level and
the finger curls up, phi is pi/2. A finger that stands (phi = pi), or curls down from a level base
(-pi/2), is one with the negative weight that hangs, or curls up.

A blocked tip is held against a force gauge: the finger is straight at rest, and its tip may not
deflect. The gauge pushes with F, so each section carries M = F*(L - x), and F follows from the
deflection of the tip, int(kappa*(L - x)) dx = F/stiffness of the gauge (0 for a rigid one).

Arrays are (lanes, rows, sections) as in `effects.stages`, with the Gauss points along a finger as
sections.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre

from softhand_common.numerics.arrays import Array, Indices
from softhand_model.bending.balance import (
    Balanced,
    Elastic,
    balance,
    first_slope,
    iterate,
    rough_stretch,
)
from softhand_model.effects.stages import SectionShape
from softhand_model.hand import section

LOADED_STEP = 1e-9  # last step of the stretch; with a constant matrix about the error
MATRIX_STEPS = 7  # steps of an iteration after which its matrix is updated
LEAST_START = 0.7  # smallest stretch at which the search begins
STRAIGHT_STEPS, BULGING_STEPS = 5, 3  # of Newton's method for the force


def running_integral(edges: Array, points: int) -> Array:
    """Matrix (n, n) [m] that integrates a function, given at n Gauss points, from the first edge to
    each of these points. The pieces between the edges [m] have `points` Gauss points each.

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
    """The weight of fingers, and of what hangs at them, and its effect on the balance of their
    sections.

    pull (lanes, rows, sections) [N]: weight of what lies beyond each section, w*(L - x) + W;
    positive where the finger hangs from its base or curls up from a level one, negative where it
    stands or curls down. tilt (1, rows, 1) [rad]: of the base, 0 where it is upright, pi/2 where it
    is level. weights (1, rows, sections) [m]: Gauss weights of the sections. running (rows,
    sections, sections) [m]: `running_integral` of each row.
    """

    pull: Array
    tilt: Array
    weights: Array
    running: Array

    def of_rows(self, rows: Indices) -> Weight:
        """The same for a selection of the rows, in which rows may repeat."""
        return Weight(
            self.pull[:, rows], self.tilt[:, rows], self.weights[:, rows], self.running[rows]
        )

    def solver(self, shape: SectionShape, alike: int = 1) -> WeightSolver:
        """Solver for the balance of sections of this shape under the weight and a load.

        alike: number of consecutive rows that are so similar that one matrix serves them all.
        """
        return WeightSolver(self, shape, alike)


class WeightSolver:
    """Balance of elastic stress q, load and weight: q = s - m, m = ratio*M/(2*G*h*d*z).

    Newton's method with secants for the elastic stress, in which the inverse of the matrix of the
    equations is kept from step to step as long as it is good enough.
    """

    def __init__(self, weight: Weight, shape: SectionShape, alike: int) -> None:
        self._beyond = weight.weights[0][:, None, :] - weight.running
        height = np.broadcast_to(shape.height, weight.weights.shape)[0][:, None]
        self._to_angle = weight.running / height
        self._scale, self._pull = shape.ratio / _stiffness(shape), weight.pull
        self._tilt = weight.tilt
        self._alike = alike
        self._inverse: Array | None = None

    def __call__(self, elastic: Elastic, load: Array, start: Balanced | None) -> Balanced:
        """Stretch [-] in balance; the search begins at `start`, if it is given."""
        steps = 0

        def correction(stretch: Array, stress: Array, slope: Array) -> Array:
            """Step of the stretch [-] towards balance, from stress and slope over the modulus."""
            nonlocal steps
            angle = self._tilt + _same_in_lanes(self._to_angle, stretch - 1.0)
            moment = self._scale * _same_in_lanes(self._beyond, self._pull * np.sin(angle))
            if self._inverse is None:
                self._inverse = self._inverted(angle, slope, self._alike)
            elif steps % MATRIX_STEPS == MATRIX_STEPS - 1:
                self._inverse = self._inverted(angle, slope)
            steps += 1
            return np.matmul(self._inverse, (load - moment - stress)[..., None])[..., 0]

        if start is None:
            start = first_slope(elastic, rough_stretch(load + 0.0 * self._scale * self._pull))
        return iterate(elastic, correction, start, LOADED_STEP)

    def _inverted(self, angle: Array, slope: Array, alike: int = 1) -> Array:
        """Inverse (lanes, rows, sections, sections) of the slope of elastic side and moment."""
        some = np.arange(0, angle.shape[-2], alike)
        turned = (self._pull * np.cos(angle))[..., some, None, :]
        bent = (self._beyond[some] * turned) @ self._to_angle[some]
        scale = np.broadcast_to(self._scale, angle.shape)[..., some, :, None]
        matrix = scale * bent
        matrix += slope[..., some, :, None] * np.eye(matrix.shape[-1])
        inverse = np.linalg.inv(matrix)
        return inverse if alike == 1 else inverse[..., np.arange(angle.shape[-2]) // alike, :, :]


def _stiffness(shape: SectionShape) -> Array:
    """2*G*h*d*z [N m], over which a moment times the ratio counts in the balance."""
    return 2.0 * shape.shear_modulus * shape.height * shape.wall * shape.width


def _same_in_lanes(matrices: Array, vectors: Array) -> Array:
    """Products of a matrix (rows, n, n) a row with the vectors (lanes, rows, n) of all lanes."""
    product = np.matmul(vectors.swapaxes(0, 1), matrices.swapaxes(1, 2))
    return np.ascontiguousarray(product.swapaxes(0, 1))


StiffnessFactor = Callable[[Array, Array], Array | float]
"""Factor [-] on the stiffness at an actual and a free curvature [1/m]."""


@dataclass(frozen=True)
class Blocked:
    """Fingers with a blocked tip.

    reach (1, rows, sections) [m]: distance from each section to the tip. weights (1, rows,
    sections) [m]: Gauss weights of the sections. compliance [m/N]: of the force gauge, a number or
    (lanes, 1, 1). running (rows, sections, sections) [m]: `running_integral` of each row.
    """

    reach: Array
    weights: Array
    compliance: Array | float
    running: Array

    def of_rows(self, rows: Indices) -> Blocked:
        """The same for a selection of the rows, in which rows may repeat."""
        return Blocked(
            self.reach[:, rows], self.weights[:, rows], self.compliance, self.running[rows]
        )

    def by_force(self, shape: SectionShape) -> tuple[Array, Array]:
        """(reduction of the load per force [1/N], deflection of the tip per stretch [m])."""
        return shape.ratio * self.reach / _stiffness(
            shape
        ), self.weights * self.reach / shape.height

    def spring_force(self, free: Array, stiffness: Array, factor: StiffnessFactor) -> Array:
        """Force (lanes, rows, 1) [N] with linear springs of stiffness B [N m2] about the free
        curvature [1/m] (section 5.2.3).

        >>> halves = np.array([0.75, 0.25]), np.array([0.5, 0.5])
        >>> blocked = Blocked(*halves, 0.0, np.zeros((1, 2, 2)))
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


def bulging(load: Array, shape: SectionShape, blocked: Blocked) -> Array:
    """Force of a blocked tip over that of a finger that stays straight (lanes, rows, 1) [-], under
    a load (lanes, rows, sections) [-] and with the base's rubber.

    A blocked finger bulges between its base and the gauge. With finite rotations the deflection is
    int(sin(theta)) dx, and F acts at x on the lever int_x^L(cos(theta)) dx, on which the tip also
    moves if the section at x bends: both are taken again after each step of Newton's method for F.
    The tip slides along the gauge without friction.
    """
    moment, _ = blocked.by_force(shape)
    beyond = blocked.weights[0][:, None, :] - blocked.running

    def step(force: Array, lever: Array, finite: bool) -> tuple[Array, Array]:
        """Force and lever after a step."""
        arm = moment / blocked.reach
        stretch = section.free_stretch(load - arm * lever * force)
        bend = (stretch - 1.0) / shape.height
        deflection, acted = _total(blocked.weights * bend * lever), lever * force
        if finite:
            angle = _same_in_lanes(blocked.running, bend)
            deflection = _total(blocked.weights * np.sin(angle))
            lever = _same_in_lanes(beyond, np.cos(angle))
        yields = blocked.weights * lever * arm / (1.0 + 3.0 * stretch**-4) / shape.height
        give = _total(yields * lever) + blocked.compliance
        return (deflection + _total(yields * acted)) / give, lever

    straight = np.zeros(1)
    for _ in range(STRAIGHT_STEPS):
        straight, _ = step(straight, blocked.reach, finite=False)
    force, lever = straight, blocked.reach
    for _ in range(BULGING_STEPS):
        force, lever = step(force, lever, finite=True)
    loaded = straight != 0.0
    return np.where(loaded, force, 1.0) / np.where(loaded, straight, 1.0)


class BlockedSolver:
    """Balance of elastic stress q, load and tip force: q = s - m, m = ratio*F*(L - x)/(2*G*h*d*z).

    Newton's method with secants for the elastic stress, in which the force is eliminated. factor:
    factor on the stiffness, which divides m; None for none.

    force (lanes, rows, 1) [N]: force of the tip in the last balance.
    """

    def __init__(
        self, blocked: Blocked, shape: SectionShape, factor: StiffnessFactor | None = None
    ) -> None:
        self._blocked, self._height, self._factor = blocked, shape.height, factor
        self._moment, self._deflection = blocked.by_force(shape)
        self._free: Balanced | None = None
        self.force = np.zeros(1)

    def __call__(self, elastic: Elastic, load: Array, start: Balanced | None) -> Balanced:
        """Stretch [-] in balance; the search begins at `start`, if it is given."""
        if self._factor is not None:
            self._free = balance(elastic, load, self._free)

        def correction(stretch: Array, stress: Array, slope: Array) -> Array:
            """Step of the stretch [-] towards balance, from stress and slope over the modulus."""
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
        """Reduction of the load [-] per unit force at a stretch."""
        if self._factor is None or self._free is None:
            return self._moment
        free = (self._free.stretch - 1.0) / self._height
        return self._moment / self._factor((stretch - 1.0) / self._height, free)

    def _rough(self, load: Array) -> Array:
        """Stretch of a beam of uniform stiffness: reduced at its base, increased at its tip."""
        place = self._blocked.reach / _total(self._blocked.weights)
        free = rough_stretch(load + 0.0 * self._moment) - 1.0
        return np.maximum(1.0 + free * (1.0 - 1.5 * place), LEAST_START)


def _total(values: Array) -> Array:
    return np.sum(values, axis=-1, keepdims=True)
