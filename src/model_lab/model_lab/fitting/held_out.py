"""Held-out errors: every fold is predicted with parameters fitted to the others.

Around the fit of all data these follow from one Gauss-Newton step, shortened where the non-linear
model says that it went too far. On request, which makes sense when folds are few and each is a
large part of the data, they are also computed by complete fits. Predictions are always those of the
non-linear model. Two weightings are tried, by the banded noise and equal: the first is right for a
model that explains the data, the second for one that does not. The one that predicts better counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model_lab.aliases import Array, Mask
from model_lab.fitting.fit import Fit, inverse
from model_lab.fitting.scales import held

STEP_SHARES = (1.0, 0.5)  # tried beside none; the one that fits the other folds best is taken
SINGULAR = 1e-8
MOST_STEPS = 20  # of a fit to the other folds


@dataclass(frozen=True)
class HeldOut:
    """Held-out residual (samples,), and its mean square in each fold (folds,)."""

    residual: Array
    mean_square: Array

    @property
    def rmse(self) -> float:
        """Root mean square over all samples."""
        return float(np.sqrt(np.mean(self.residual**2)))


def hold_out(fit: Fit, anew: bool = False) -> HeldOut:
    """Predict every fold by parameters fitted to the other folds.

    anew: whether complete fits are tried as well as one step from the fit to all data.
    """
    table = fit.likelihood.spectrum.table
    fold_of, folds = table.fold, len(table.folds)
    count = np.maximum(np.bincount(fold_of, minlength=folds), 1)
    if not len(fit.values):
        return HeldOut(fit.residual, np.bincount(fold_of, fit.residual**2, folds) / count)
    found = [*_held_out(fit)]
    if anew:
        each = [_refitted(fit, fold_of != fold) for fold in range(folds)]
        found.append(np.choose(fold_of, each))
    residual = min(found, key=lambda rest: float(np.nan_to_num(np.sum(rest**2), nan=np.inf)))
    return HeldOut(residual, np.bincount(fold_of, residual**2, folds) / count)


def _held_out(fit: Fit) -> tuple[Array, Array]:
    """Held-out residuals (samples,) by steps without, and with, the weights of banded noise."""
    table = fit.likelihood.spectrum.table
    fold_of, folds = table.fold, len(table.folds)
    systems = [_equations(fit, weighted) for weighted in (False, True)]
    values = np.concatenate(
        [_values_without(fit, systems, fold_of != fold) for fold in range(folds)]
    )
    residuals = fit.likelihood.residuals(values).reshape(folds, len(STEP_SHARES) + 1, -1)
    plain, weighted = np.empty_like(fit.residual), np.empty_like(fit.residual)
    for fold in range(folds):
        mine = fold_of == fold
        tried = np.concatenate([residuals[fold, :-1], fit.residual[None]])
        errors = np.mean(tried[:, ~mine] ** 2, axis=1)
        errors[~np.isfinite(tried).all(axis=1)] = np.inf  # the model has no result there
        plain[mine] = tried[int(np.argmin(errors)), mine]
        weighted[mine] = residuals[fold, -1, mine]
    return plain, weighted


def _refitted(fit: Fit, kept: Mask) -> Array:
    """Residual (samples,) by parameters fitted to the kept samples alone, without weights."""
    from scipy.optimize import least_squares  # here, as it takes long to load

    likelihood, scales, scale = fit.likelihood, fit.likelihood.scales, fit.rmse or 1.0

    def left(lanes: Array) -> Array:
        values = scales.outward(lanes)
        own = likelihood.residuals(values)[:, kept] / scale
        return np.hstack([own, (values - 1.0) / likelihood.prior])

    def slopes(at: Array) -> Array:
        step = likelihood.slope_step * scales.width
        step = np.where(at + step > scales.high, -step, step)
        rows = left(at + np.vstack([np.zeros_like(step), np.diag(step)]))
        return np.asarray((rows[1:] - rows[0]).T / step)

    start = np.clip(scales.inward(fit.values), scales.low, scales.high)
    found = least_squares(
        lambda at: left(at[None])[0],
        start,
        slopes,
        (scales.low, scales.high),
        x_scale=scales.width,
        max_nfev=MOST_STEPS,
    )
    return np.asarray(likelihood.residuals(scales.outward(found.x[None]))[0])


def _values_without(fit: Fit, systems: Sequence[tuple[Array, Array]], kept: Mask) -> Array:
    """Parameters (n, k) fitted to the kept samples: by shares of the step without weights, and by
    the step with them. systems: the equations of both.
    """
    scales = fit.likelihood.scales
    center = scales.inward(fit.values)
    plain, weighted = (_step(fit, center, rows[kept], rest[kept]) for rows, rest in systems)
    tried = center + np.stack([*(share * plain for share in STEP_SHARES), weighted])
    return scales.outward(np.clip(tried, scales.low, scales.high))


def _step(fit: Fit, center: Array, rows: Array, rest: Array) -> Array:
    """Step (k,) of Gauss and Newton by these equations."""
    scales = fit.likelihood.scales
    prior = 1.0 / fit.likelihood.prior**2
    normal = rows.T @ rows + np.diag(prior)
    gradient = rows.T @ rest - prior * (fit.values - 1.0)
    free = ~held(scales, center, gradient)
    move = np.zeros(len(gradient))
    if free.any():
        move[free] = inverse(normal[np.ix_(free, free)], SINGULAR) @ gradient[free]
    return np.clip(move, -scales.width, scales.width)


def _equations(fit: Fit, weighted: bool) -> tuple[Array, Array]:
    """Jacobian (samples, k) and residual (samples,) over their errors; with weights those of the
    coefficients, of which each fold has its own, as it is whole series.
    """
    if not weighted:
        scale = fit.rmse or 1.0
        return fit.jacobian / scale, fit.residual / scale
    spectrum = fit.likelihood.spectrum
    errors = np.sqrt(fit.variance)[spectrum.bands]
    rows = spectrum.coefficients(np.ascontiguousarray(fit.jacobian.T)).T
    return rows / errors[:, None], fit.coefficients / errors
