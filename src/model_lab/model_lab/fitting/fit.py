"""Fitting of a forward model: bounded Levenberg-Marquardt on the likelihood of banded noise.

The errors of a band (see `noise_floor`) are taken as Gaussian, each band with its own variance,
which is fitted too; what is minimised is minus twice the log likelihood,

    sum over bands of n*log(variance) + calibration prior,  variance = (SS + nu*v0)/(n + nu),

with the sum of squares SS of the band's n coefficients and nu pseudo-observations of the noise
floor v0. So a part of the error that the model does not explain lowers the weight of its band
instead of distorting the parameters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from model_lab.aliases import Array, Mask
from model_lab.experiments.own_errors import OwnErrors
from model_lab.fitting.noise_floor import Spectrum, falling
from model_lab.fitting.scales import Scales, held
from model_lab.rules import RULES

JACOBIAN_STEP = 1e-4  # step of the Jacobian in units of a parameter's scale, unless stated
MOST_ITERATIONS = 15
LEAST_IMPROVEMENT = 0.3  # of the deviance at which the search ends
PSEUDO_OBSERVATIONS = 4.0
SAME_MINIMUM = 0.01  # of the usual range: searches that meet so near end in the same place
NO_CHANGE = 1e-8  # of the largest residual, that a parameter's difference must change
FIRST_DAMPING, LARGEST_DAMPING = 1e-2, 1e7
DAMPINGS = (0.01, 1.0, 30.0)  # factors on the damping that are tried at the same time


class Parameterised(Protocol):
    """The interface of models that can be fitted, see `forward.Forward`."""

    @property
    def parameters(self) -> Sequence[Any]:
        """Free parameters with name, low, high, typical, logarithmic and spread."""
        ...

    @property
    def measured(self) -> Array:
        """Measured values (samples,)."""
        ...

    def predict(self, values: Array) -> Array:
        """Predictions (lanes, samples) for parameters (lanes, k)."""
        ...


@dataclass(frozen=True)
class Likelihood:
    """A forward model with the noise model for its errors.

    floor (bands,): variance v0 of the noise floor in each band (see the module). gain_known:
    whether repeats tell how much the gains of runs scatter. own: errors of the predictions
    themselves, if it is known how they go.
    """

    forward: Parameterised
    spectrum: Spectrum
    floor: Array
    gain_known: bool = True
    own: OwnErrors | None = field(default=None, compare=False)
    scales: Scales = field(init=False)
    prior: Array = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "scales", Scales.of(self.forward.parameters))
        spread = [parameter.spread for parameter in self.parameters]
        object.__setattr__(self, "prior", np.array(spread, float))

    @property
    def parameters(self) -> Sequence[Any]:
        """The free parameters, in the order of the values (k,)."""
        return self.forward.parameters

    @property
    def slope_step(self) -> float:
        """Step of the Jacobian in units of a parameter's scale."""
        found: float | None = getattr(self.forward, "slope_step", None)
        return JACOBIAN_STEP if found is None else found

    @property
    def names(self) -> list[str]:
        """Names of the free parameters."""
        return [parameter.name for parameter in self.parameters]

    def residuals(self, values: Array) -> Array:
        """Measured minus predicted values (lanes, samples), for parameter values (lanes, k)."""
        return self.forward.measured - self.forward.predict(values)

    def variance(self, power: Array) -> Array:
        """Variance (lanes, bands) of a coefficient in each band, from sums of squares (lanes,
        bands).

        The errors of the gains, which are few, are limited to those of the shape. Otherwise a wrong
        model would be fitted to the shape alone, with an arbitrary size.
        """
        counts = self.spectrum.counts()
        raw = (power + PSEUDO_OBSERVATIONS * self.floor) / (counts + PSEUDO_OBSERVATIONS)
        result = np.empty_like(raw)
        for mine in self.spectrum.bands_of_outputs:
            if self.gain_known:
                raw[:, mine[0]] = np.minimum(
                    raw[:, mine[0]],
                    np.maximum(
                        RULES.gain_error * self.floor[mine[0]],
                        power[:, mine[1:]].sum(axis=1) / counts[mine[0]],
                    ),
                )
            far, left = self._beyond_noise(power[:, mine], counts[mine], self.floor[mine])
            levels = left[:, None] * raw[:, mine] + far[:, None]
            for lane in np.flatnonzero((levels[:, :-1] < levels[:, 1:]).any(axis=1)):
                levels[lane] = falling(levels[lane], counts[mine])
            result[:, mine] = levels
        return result

    @staticmethod
    def _beyond_noise(power: Array, counts: Array, floor: Array) -> tuple[Array, Array]:
        """Mean square (lanes,) of errors that no noise makes, and the share (lanes,) of the others.

        Such an error is in no band alone: else a model that is far off would be fitted where its
        error has many coefficients, at its edges.
        """
        mean_square = power.sum(axis=1) / counts.sum()
        far = np.maximum(mean_square - RULES.far_error**2 * (counts @ floor) / counts.sum(), 0.0)
        return far, 1.0 - far / np.where(far > 0.0, mean_square, 1.0)

    def deviance(self, power: Array, values: Array) -> Array:
        """Minus twice the log likelihood (lanes,), up to a constant, from sums of squares (lanes,
        bands) and parameter values (lanes, k).
        """
        counts = self.spectrum.counts() + PSEUDO_OBSERVATIONS
        variance = self.variance(power)
        given = power + PSEUDO_OBSERVATIONS * self.floor
        bands = counts * np.log(variance) + given / variance - counts
        return bands.sum(axis=-1) + np.sum(((values - 1.0) / self.prior) ** 2, axis=-1)


@dataclass(frozen=True)
class Fit:
    """A fitted model.

    values (k,): of its parameters. residual (samples,): measured minus predicted. coefficients
    (samples,): transform of the residual. variance (bands,): of a coefficient in each band.
    jacobian (samples, k): of the prediction by the search coordinates (see `Scales`). covariance
    (k, k): of these coordinates, by noise. at_limit (k,): whether a parameter lies on a bound.
    own_covariance (k, k): of the coordinates, by the errors of the predictions themselves.
    """

    likelihood: Likelihood
    values: Array
    deviance: float
    residual: Array
    coefficients: Array
    variance: Array
    jacobian: Array
    covariance: Array
    at_limit: Mask
    own_covariance: Array | float = 0.0

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
    damping: float = FIRST_DAMPING
    finished: bool = False


def fit(likelihood: Likelihood, starts: Array) -> Fit:
    """The best of the fits from n starts (n, k), which are improved at the same time."""
    coordinates = np.clip(
        likelihood.scales.inward(starts), likelihood.scales.low, likelihood.scales.high
    )
    points = _points(likelihood, coordinates)
    for _ in range(MOST_ITERATIONS if starts.shape[1] else 0):
        active = [index for index, point in enumerate(points) if not point.finished]
        if not active:
            break
        moved = _improved(likelihood, [points[index] for index in active])
        for index, point in zip(active, moved, strict=True):
            points[index] = point
        _finish_followers(likelihood.scales, points)
    return _finished(likelihood, min(points, key=lambda point: point.deviance))


def _finish_followers(scales: Scales, points: list[_Point]) -> None:
    """End the search from points that approach the position of a better one."""
    ranked = sorted(points, key=lambda point: point.deviance)
    for place, point in enumerate(ranked):
        near = [
            np.all(np.abs(point.coordinates - other.coordinates) <= SAME_MINIMUM * scales.width)
            for other in ranked[:place]
        ]
        point.finished = point.finished or any(near)


def _points(likelihood: Likelihood, coordinates: Array, known: Array | None = None) -> list[_Point]:
    """The model at points (n, k) with its Jacobian, by differences that stay inside the bounds.

    known (n, samples): the residual there, if it is.
    """
    scales = likelihood.scales
    step = likelihood.slope_step * scales.width
    step = np.where(coordinates + step > scales.high, -step, step)
    lanes = coordinates[:, None] + _diagonals(step)
    if known is None:
        lanes = np.concatenate([coordinates[:, None], lanes], axis=1)
    residual = likelihood.residuals(scales.outward(lanes.reshape(-1, step.shape[1])))
    residual = residual.reshape(*lanes.shape[:2], -1)
    if known is not None:
        residual = np.concatenate([known[:, None], residual], axis=1)
    coefficients = likelihood.spectrum.coefficients(residual[:, 0])
    power = likelihood.spectrum.power(coefficients)
    values = scales.outward(coordinates)
    deviance = likelihood.deviance(power, values)
    return [
        _Point(
            coordinates[n],
            values[n],
            residual[n, 0],
            (_seen(residual[n, :1] - residual[n, 1:], residual[n, 0]) / step[n, :, None]).T,
            coefficients[n],
            power[n],
            float(deviance[n]),
        )
        for n in range(len(step))
    ]


def _seen(change: Array, residual: Array) -> Array:
    """Changes (k, samples) of the residual; of a parameter that moves nothing exactly 0, where
    solvers that settle a little differently would let the search run along it.
    """
    seen = np.max(np.abs(change), axis=1) > NO_CHANGE * np.max(np.abs(residual))
    return np.where(seen[:, None], change, 0.0)


def _diagonals(rows: Array) -> Array:
    """Diagonal matrices (n, k, k) of rows (n, k)."""
    return rows[:, None, :] * np.eye(rows.shape[1])


def _improved(likelihood: Likelihood, points: list[_Point]) -> list[_Point]:
    """Each point moved to the best of its trial steps; finished where that gains nothing more."""
    scales = likelihood.scales
    trials = np.stack([_trial_coordinates(likelihood, point) for point in points])
    values = scales.outward(trials.reshape(-1, trials.shape[-1]))
    residual = likelihood.residuals(values)
    power = likelihood.spectrum.power(likelihood.spectrum.coefficients(residual))
    residual = residual.reshape(*trials.shape[:2], -1)
    deviance = likelihood.deviance(power, values).reshape(len(points), -1)
    deviance = np.where(np.isfinite(deviance), deviance, np.inf)
    best = np.argmin(deviance, axis=1)
    better = [n for n, point in enumerate(points) if deviance[n, best[n]] < point.deviance]
    chosen = better, best[better]
    found = _points(likelihood, trials[chosen], residual[chosen]) if better else ()
    moved = dict(zip(better, found, strict=True))
    return [_next(point, moved.get(n), DAMPINGS[best[n]]) for n, point in enumerate(points)]


def _next(point: _Point, moved: _Point | None, chosen: float) -> _Point:
    """The point to go on from: the moved one, or the old one with more damping, or the end."""
    if moved is None:
        damping = point.damping * DAMPINGS[-1] ** 2
        return replace(point, damping=damping, finished=damping > LARGEST_DAMPING)
    finished = point.deviance - moved.deviance < LEAST_IMPROVEMENT
    return replace(moved, damping=max(point.damping * chosen, 1e-9), finished=finished)


def _trial_coordinates(likelihood: Likelihood, point: _Point) -> Array:
    """Coordinates (trials, k) reached by steps of different damping."""
    normal, gradient = _normal_equations(likelihood, point)
    scales = likelihood.scales
    free = ~held(scales, point.coordinates, gradient)
    if not np.isfinite(gradient).all():  # the model has no result there: no way leads on
        free[:] = False
    moves = np.zeros((len(DAMPINGS), len(gradient)))
    if free.any():
        system = normal[np.ix_(free, free)]
        ridge = np.diag(np.diag(system))
        damped = np.stack([system + factor * point.damping * ridge for factor in DAMPINGS])
        for move, inverted in zip(moves, inverse(damped), strict=True):
            move[free] = inverted @ gradient[free]
    moves = np.clip(moves, -2.0 * scales.width, 2.0 * scales.width)
    return np.clip(point.coordinates + moves, scales.low, scales.high)


def _normal_equations(likelihood: Likelihood, point: _Point) -> tuple[Array, Array]:
    """J'WJ (k, k) and J'Wr (k,) in search coordinates, with the prior of the calibration."""
    rows = likelihood.spectrum.coefficients(point.jacobian.T)
    weight = 1.0 / likelihood.variance(point.power[None])[0][likelihood.spectrum.bands]
    prior = 1.0 / likelihood.prior**2
    normal = (rows * weight) @ rows.T + np.diag(prior)
    return normal, rows @ (weight * point.coefficients) - prior * (point.values - 1.0)


def inverse(normal: Array, singular: float = 1e-14) -> Array:
    """Pseudo-inverses (..., k, k) of the matrices of normal equations, whatever the units of their
    parameters.

    singular: directions whose eigenvalue, with the diagonal scaled to 1, is below this are left
    out.
    """
    diagonal = np.diagonal(normal, axis1=-2, axis2=-1)
    size = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    sizes = size[..., :, None] * size[..., None, :]
    values, vectors = np.linalg.eigh(normal / sizes)
    values, vectors = values[..., ::-1], vectors[..., ::-1]  # the largest first
    kept = np.abs(values) > singular * np.abs(values).max(axis=-1, keepdims=True, initial=0.0)
    inverted = np.divide(1.0, values, out=np.zeros_like(values), where=kept)
    columns = inverted[..., :, None] * np.swapaxes(vectors, -1, -2)
    return np.asarray(np.matmul(vectors, columns) / sizes)


def _finished(likelihood: Likelihood, point: _Point) -> Fit:
    normal, _ = (
        _normal_equations(likelihood, point) if len(point.values) else (np.zeros((0, 0)), None)
    )
    scales, inverted = likelihood.scales, inverse(normal)
    span = np.minimum(scales.high - scales.low, scales.width)
    distance = np.minimum(point.coordinates - scales.low, scales.high - point.coordinates)
    return Fit(
        likelihood,
        point.values,
        point.deviance,
        point.residual,
        point.coefficients,
        likelihood.variance(point.power[None])[0],
        point.jacobian,
        _lost_freedom(likelihood, len(point.values)) * inverted,
        distance <= RULES.limit_distance * span,
        _by_own_errors(likelihood, point, inverted),
    )


def _by_own_errors(likelihood: Likelihood, point: _Point, inverted: Array) -> Array:
    """Covariance (k, k) of the search coordinates by the errors of the predictions themselves: each
    moves them by its weighted least squares. All repeats have the same error, so that it does not
    average out over them as noise does.
    """
    if likelihood.own is None or not len(point.values):
        return np.zeros_like(inverted)
    spectrum = likelihood.spectrum
    weight = 1.0 / likelihood.variance(point.power[None])[0][spectrum.bands]
    gain = inverted @ (spectrum.coefficients(point.jacobian.T) * weight)
    rows = spectrum.coefficients(likelihood.own.rows)
    return likelihood.own.covariance(rows, gain, spectrum.table)


def _lost_freedom(likelihood: Likelihood, parameters: int) -> float:
    """Factor on the covariance for the runs that the parameters have used up."""
    runs = likelihood.spectrum.table.runs
    return runs / max(runs - parameters, 1.0)
