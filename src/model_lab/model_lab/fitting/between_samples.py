"""The input between samples: constant until it jumps, linear, or without the steps of a sensor.

Time constants near the time between samples depend on it. All are tried with the model as it is,
followed by lags of many time constants; the one that predicts held-out data best is kept.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from model_lab.aliases import Array
from model_lab.experiments.samples import SampleRows
from model_lab.measurements.held_input import jumps, with_jumps
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.rules import RULES
from softhand_model.effects.whole_runs import lagged_in_runs

LAGS = np.geomspace(0.02, 50.0, 16)  # time constants over the time between samples

Predict = Callable[[MeasurementSet], Array]
"""What a model says of the samples (samples,) of a set."""


def with_input_between(
    data: MeasurementSet, predict: Predict, unrounded: MeasurementSet | None = None
) -> MeasurementSet:
    """The set, whose field `jumps` now says whether its input is held between samples and then
    jumps, or goes straight; or the set without the rounding of a coarse sensor, unless held-out
    data speak against it.

    predict: returns the outputs of the model for a set. unrounded: the set without the rounding of
    its input; None if no rounding is seen.
    """
    if unrounded is None and not any(len(jumps(data, run)) for run in data.runs):
        return data
    held, own = with_jumps(data)
    straight = _held_out(data, _lags(data, predict(data)))
    jumping = _held_out(data, _lags(held, predict(held))[:, own])
    if unrounded is not None:
        rest = _held_out(unrounded, _lags(unrounded, predict(unrounded))).sum()
        if rest <= min(straight.sum(), jumping.sum()):
            return unrounded
    lower = jumping.sum() < RULES.held_error**2 * straight.sum()
    lower &= np.mean(jumping < straight) >= RULES.held_folds
    return replace(data, jumps=bool(lower))


def _lags(data: MeasurementSet, predicted: Array) -> Array:
    """Predictions (lags, samples) that lag behind."""
    rows = SampleRows(data)
    apart = np.median(np.concatenate([np.diff(run.columns["time"]) for run in data.runs]))
    return lagged_in_runs(predicted[None, :, None], rows.runs, LAGS * apart)[:, :, 0]


def _held_out(data: MeasurementSet, lags: Array) -> Array:
    """Sum of squares (folds,) that the lag which suits the other folds best leaves of each, beside
    a parabola of what lags: the model need not be right.
    """
    table = data.table
    scaled = lags / np.max(np.abs(lags))
    features = np.stack([np.ones_like(scaled), scaled, scaled**2], axis=2)
    left = np.empty(len(table.folds))
    for fold in range(len(table.folds)):
        kept = table.fold != fold
        found = np.linalg.pinv(features[:, kept]) @ table.value[kept]
        rest = table.value - (features @ found[:, :, None])[:, :, 0]
        best = rest[np.argmin(np.sum(rest[:, kept] ** 2, axis=1))]
        left[fold] = np.sum(best[~kept] ** 2)
    return left
