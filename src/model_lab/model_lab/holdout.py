"""Errors on data that were not fitted: every fold is predicted by parameters fitted to the others.

Around the fit of all data the parameters of each fold follow from one Gauss-Newton step of ordinary
least squares, shortened where the whole non-linear model says that it went too far; the predictions
are those of the whole model.
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
    values = np.stack([_values_without(fit, fold_of != fold) for fold in range(folds)])
    residuals = fit.problem.residuals(values.reshape(-1, len(fit.values)))
    residuals = residuals.reshape(folds, len(STEP_SHARES), -1)
    residual = np.empty_like(fit.residual)
    for fold in range(folds):
        mine = fold_of == fold
        errors = np.mean(residuals[fold][:, ~mine] ** 2, axis=1)
        residual[mine] = residuals[fold, int(np.argmin(errors)), mine]
    return HeldOut(residual, np.bincount(fold_of, residual**2, folds) / count)


def _values_without(fit: Fit, kept: NDArray[np.bool_]) -> Array:
    """Parameters (shares, k) fitted to the kept samples, by shares of one step."""
    problem, scales = fit.problem, fit.problem.scales
    scale = fit.rmse or 1.0
    rows, rest = fit.jacobian[kept] / scale, fit.residual[kept] / scale
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
