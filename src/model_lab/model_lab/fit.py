"""Fitting of a forward model: bounded Levenberg-Marquardt on the likelihood of banded noise.

The errors of a band (see `spectrum`) are taken as Gaussian with a variance of their own that is
fitted along; what is minimised is minus twice the log likelihood,

    sum over bands of n*log(variance) + calibration prior,  variance = (SS + nu*v0)/(n + nu),

with the sum of squares SS of the band's n coefficients and nu pseudo-observations of the noise
floor v0. So a part of the error that the model does not explain lowers the weight of its band
instead of distorting the parameters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from model_lab.noise import falling
from model_lab.spectrum import Spectrum

Array = NDArray[np.float64]

DIFFERENCE = 1e-4  # step of the Jacobian in units of a parameter's scale
ITERATIONS = 25
IMPROVEMENT = 2e-3  # of the deviance at which the search ends
PSEUDO_OBSERVATIONS = 4.0
MODULUS_SPREAD = 0.15 / np.sqrt(3.0)  # of a scale that is uniform within 15 %
AT_LIMIT = 1e-3  # of the range: a parameter this near to a bound lies on it
FIRST_DAMPING, LARGEST_DAMPING = 1e-3, 1e8


class Parameterised(Protocol):
    """What is fitted: see `forward.Forward`."""

    @property
    def parameters(self) -> Sequence[Any]:
        """Free parameters with name, low, high, typical and logarithmic."""
        ...

    @property
    def measured(self) -> Array:
        """What was measured (samples,)."""
        ...

    def predict(self, values: Array) -> Array:
        """Predictions (lanes, samples) for parameters (lanes, k)."""
        ...


@dataclass(frozen=True)
class Scales:
    """Coordinates in which parameters are searched: logarithms where they span decades."""

    low: Array
    high: Array
    width: Array
    logarithmic: NDArray[np.bool_]

    @classmethod
    def of(cls, parameters: Sequence[Any]) -> Scales:
        """Scales of free parameters; width is that of their typical range."""
        log = np.array([parameter.logarithmic for parameter in parameters], bool)
        ends = np.array([[p.low, p.high, *p.typical] for p in parameters], float).reshape(-1, 4)
        ends[log] = np.log(ends[log])
        return cls(ends[:, 0], ends[:, 1], np.maximum(ends[:, 3] - ends[:, 2], 1e-12), log)

    def inward(self, values: Array) -> Array:
        """Coordinates of values (..., k)."""
        with np.errstate(divide="ignore"):
            return np.where(
                self.logarithmic, np.log(np.where(self.logarithmic, values, 1.0)), values
            )

    def outward(self, coordinates: Array) -> Array:
        """Values of coordinates (..., k)."""
        return np.where(
            self.logarithmic, np.exp(np.where(self.logarithmic, coordinates, 0.0)), coordinates
        )


@dataclass(frozen=True)
class Problem:
    """A forward model with the noise it is judged by; floor (bands,) is v0 above."""

    forward: Parameterised
    spectrum: Spectrum
    floor: Array
    scales: Scales = field(init=False)
    prior: Array = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "scales", Scales.of(self.forward.parameters))
        spread = [
            MODULUS_SPREAD if parameter.name.startswith("modulus_scale") else np.inf
            for parameter in self.forward.parameters
        ]
        object.__setattr__(self, "prior", np.array(spread))

    def residuals(self, values: Array) -> Array:
        """Measured minus predicted (lanes, samples)."""
        return self.forward.measured - self.forward.predict(values)

    def variance(self, power: Array) -> Array:
        """Variance (lanes, bands) of a coefficient of each band, for sums of squares likewise."""
        counts = self.spectrum.counts()
        raw = (power + PSEUDO_OBSERVATIONS * self.floor) / (counts + PSEUDO_OBSERVATIONS)
        result = np.empty_like(raw)
        for output in np.unique(self.spectrum.band_output):
            mine = np.flatnonzero(self.spectrum.band_output == output)
            for lane, row in enumerate(raw):
                result[lane, mine] = falling(row[mine], counts[mine])
        return result

    def deviance(self, power: Array, values: Array) -> Array:
        """Minus twice the log likelihood (lanes,), but for a constant."""
        counts = self.spectrum.counts() + PSEUDO_OBSERVATIONS
        variance = self.variance(power)
        given = power + PSEUDO_OBSERVATIONS * self.floor
        bands = counts * np.log(variance) + given / variance - counts
        return bands.sum(axis=-1) + np.sum(((values - 1.0) / self.prior) ** 2, axis=-1)


@dataclass(frozen=True)
class Fit:
    """A fitted model: values and covariance of its parameters, and how well it does.

    jacobian (samples, k): of the prediction by the search coordinates. covariance (k, k) of those
    coordinates. coefficients (samples,): the residual's. variance (bands,). at_limit (k,): lies on
    a bound.
    """

    problem: Problem
    values: Array
    deviance: float
    residual: Array
    coefficients: Array
    variance: Array
    jacobian: Array
    covariance: Array
    at_limit: NDArray[np.bool_]

    @property
    def rmse(self) -> float:
        """Root mean square of the residual."""
        return float(np.sqrt(np.mean(self.residual**2)))


@dataclass
class _Point:
    coordinates: Array
    values: Array
    residual: Array
    jacobian: Array
    coefficients: Array
    power: Array
    deviance: float


def fit(problem: Problem, starts: Array) -> Fit:
    """The best fit from parameters starts (n, k), each improved in turn."""
    if starts.shape[1] == 0:
        return _finished(problem, _point(problem, np.zeros(0)))
    found = [_search(problem, problem.scales.inward(start)) for start in starts]
    return _finished(problem, min(found, key=lambda point: point.deviance))


def _point(problem: Problem, coordinates: Array) -> _Point:
    """The model at a point with its Jacobian, by differences that stay inside the bounds."""
    scales = problem.scales
    step = DIFFERENCE * scales.width
    step = np.where(coordinates + step > scales.high, -step, step)
    lanes = (
        np.vstack([coordinates, coordinates + np.diag(step)]) if len(step) else coordinates[None]
    )
    residual = problem.residuals(scales.outward(lanes))
    jacobian = ((residual[:1] - residual[1:]) / step[:, None]).T
    coefficients = problem.spectrum.coefficients(residual[:1])
    power = problem.spectrum.power(coefficients)
    values = scales.outward(coordinates)
    deviance = float(problem.deviance(power, values[None])[0])
    return _Point(coordinates, values, residual[0], jacobian, coefficients[0], power[0], deviance)


def _search(problem: Problem, start: Array) -> _Point:
    scales = problem.scales
    point = _point(problem, np.clip(start, scales.low, scales.high))
    damping = FIRST_DAMPING
    for _ in range(ITERATIONS):
        trial, damping = _step(problem, point, damping)
        if trial is None:
            return point
        gained = point.deviance - trial.deviance
        point = trial
        if gained < IMPROVEMENT:
            return point
    return point


def _step(problem: Problem, point: _Point, damping: float) -> tuple[_Point | None, float]:
    """A better point and the damping that led to it; None when there is none."""
    normal, gradient = _normal_equations(problem, point)
    scales = problem.scales
    while damping < LARGEST_DAMPING:
        free = ~held(scales, point.coordinates, gradient)
        if not free.any():
            return None, damping
        system = normal[np.ix_(free, free)]
        system = system + damping * np.diag(np.diag(system) + 1e-12 * np.trace(system))
        move = np.zeros(len(gradient))
        move[free] = np.linalg.lstsq(system, gradient[free], rcond=None)[0]
        move = np.clip(move, -2.0 * scales.width, 2.0 * scales.width)
        coordinates = np.clip(point.coordinates + move, scales.low, scales.high)
        if np.all(np.abs(coordinates - point.coordinates) <= 1e-9 * scales.width):
            return None, damping
        trial = _point(problem, coordinates)
        if trial.deviance < point.deviance:
            return trial, max(damping / 10.0, 1e-9)
        damping = max(damping, 1e-6) * 10.0
    return None, damping


def _normal_equations(problem: Problem, point: _Point) -> tuple[Array, Array]:
    """J'WJ (k, k) and J'Wr (k,) in search coordinates, with the prior of the calibration."""
    rows = problem.spectrum.coefficients(point.jacobian.T)
    weight = 1.0 / problem.variance(point.power[None])[0][problem.spectrum.bands]
    prior = 1.0 / problem.prior**2
    normal = (rows * weight) @ rows.T + np.diag(prior)
    return normal, rows @ (weight * point.coefficients) - prior * (point.values - 1.0)


def held(scales: Scales, coordinates: Array, gradient: Array) -> NDArray[np.bool_]:
    """Parameters on a bound that want to go beyond it."""
    below = (coordinates <= scales.low) & (gradient < 0.0)
    return below | ((coordinates >= scales.high) & (gradient > 0.0))


def _finished(problem: Problem, point: _Point) -> Fit:
    normal, _ = _normal_equations(problem, point) if len(point.values) else (np.zeros((0, 0)), None)
    scales = problem.scales
    span = np.where(np.isfinite(scales.high - scales.low), scales.high - scales.low, scales.width)
    distance = np.minimum(point.coordinates - scales.low, scales.high - point.coordinates)
    return Fit(
        problem,
        point.values,
        point.deviance,
        point.residual,
        point.coefficients,
        problem.variance(point.power[None])[0],
        point.jacobian,
        _lost_freedom(problem, len(point.values))
        * np.asarray(np.linalg.pinv(normal, hermitian=True)),
        distance <= AT_LIMIT * span,
    )


def _lost_freedom(problem: Problem, parameters: int) -> float:
    """Factor on the covariance for the runs that the parameters have used up."""
    runs = len({part.run for part in problem.spectrum.layout.series})
    return runs / max(runs - parameters, 1.0)
