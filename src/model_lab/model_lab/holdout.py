"""Errors on data that were not fitted: every fold is predicted by parameters fitted to the others.

Around the fit of all data the parameters of each fold follow from one Gauss-Newton step, shortened
where the whole non-linear model says that it went too far; the predictions are those of the whole
model. Two weights are tried, that of the banded noise and none: the first is right for a model that
explains the data, the second for one that does not; the one that predicts better counts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_lab.fit import Fit, held, inverse

Array = NDArray[np.float64]

STEP_SHARES = (1.0, 0.5, 0.0)  # tried; the one that fits the other folds best is taken
SINGULAR = 1e-8


@dataclass(frozen=True)
class HeldOut:
    """Held-out residual (samples,), and for each fold its mean square (folds,)."""

    residual: Array
    mean_square: Array

    @property
    def rmse(self) -> float:
        """Root mean square over all samples."""
        return float(np.sqrt(np.mean(self.residual**2)))


def hold_out(fit: Fit) -> HeldOut:
    """Predict every fold of the layout without its own data."""
    layout = fit.problem.spectrum.layout
    fold_of, folds = layout.fold_of(), len(layout.folds)
    count = np.maximum(np.bincount(fold_of, minlength=folds), 1)
    if not len(fit.values):
        return HeldOut(fit.residual, np.bincount(fold_of, fit.residual**2, folds) / count)
    found = [_held_out(fit, weighted) for weighted in (False, True)]
    residual = min(found, key=lambda rest: float(np.sum(rest**2)))
    return HeldOut(residual, np.bincount(fold_of, residual**2, folds) / count)


def _held_out(fit: Fit, weighted: bool) -> Array:
    """Held-out residual (samples,) by steps with, or without, the weights of banded noise."""
    layout = fit.problem.spectrum.layout
    fold_of, folds = layout.fold_of(), len(layout.folds)
    values = np.stack([_values_without(fit, fold_of != fold, weighted) for fold in range(folds)])
    residuals = fit.problem.residuals(values.reshape(-1, len(fit.values)))
    residuals = residuals.reshape(folds, len(STEP_SHARES), -1)
    residual = np.empty_like(fit.residual)
    for fold in range(folds):
        mine = fold_of == fold
        errors = np.mean(residuals[fold][:, ~mine] ** 2, axis=1)
        chosen = 0 if weighted else int(np.argmin(errors))
        residual[mine] = residuals[fold, chosen, mine]
    return residual


def _values_without(fit: Fit, kept: NDArray[np.bool_], weighted: bool) -> Array:
    """Parameters (shares, k) fitted to the kept samples, by shares of one step."""
    problem, scales = fit.problem, fit.problem.scales
    rows, rest = _equations(fit, kept, weighted)
    prior = 1.0 / problem.prior**2
    normal = rows.T @ rows + np.diag(prior)
    gradient = rows.T @ rest - prior * (fit.values - 1.0)
    center = scales.inward(fit.values)
    free = ~held(scales, center, gradient)
    move = np.zeros(len(gradient))
    if free.any():
        system = normal[np.ix_(free, free)]
        move[free] = inverse(system, SINGULAR) @ gradient[free]
    step = np.clip(move, -scales.width, scales.width)
    tried = np.stack([center + share * step for share in STEP_SHARES])
    return scales.outward(np.clip(tried, scales.low, scales.high))


def _equations(fit: Fit, kept: NDArray[np.bool_], weighted: bool) -> tuple[Array, Array]:
    """Jacobian (n, k) and residual (n,) of what is kept, over their errors.

    A fold is whole series, and so are its coefficients.
    """
    if not weighted:
        scale = fit.rmse or 1.0
        return fit.jacobian[kept] / scale, fit.residual[kept] / scale
    spectrum = fit.problem.spectrum
    errors = np.sqrt(fit.variance)[spectrum.bands][kept]
    rows = spectrum.coefficients(np.ascontiguousarray(fit.jacobian.T)).T[kept]
    return rows / errors[:, None], fit.coefficients[kept] / errors
