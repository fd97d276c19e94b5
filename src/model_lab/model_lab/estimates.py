"""Fitted parameters as they are told: values, errors, intervals, correlations, calibration."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.stats import t as student

from model_lab.candidates import names
from model_lab.diagnosis import Estimate, NamedEffect
from model_lab.search import Scored

CONFIDENCE = 0.975


def named_effect(scored: Scored, effect: str) -> NamedEffect:
    """An effect of a fitted model with its parameters, errors and 95 % intervals."""
    parameters = scored.fit.problem.forward.parameters
    return NamedEffect(
        effect,
        {
            parameters[index].name.removeprefix(f"{effect}."): estimate(scored, index)
            for index in scored.parameters_of(effect)
        },
    )


def estimate(scored: Scored, index: int) -> Estimate:
    """One parameter of a fitted model; the interval allows for the few runs there are."""
    fitted, scales = scored.fit, scored.fit.problem.scales
    parameter = fitted.problem.forward.parameters[index]
    spread = float(np.sqrt(max(fitted.covariance[index, index], 0.0)))
    runs = len({part.run for part in fitted.problem.spectrum.layout.series})
    factor = float(student.ppf(CONFIDENCE, max(runs - len(fitted.values), 3)))
    center = scales.inward(fitted.values)
    ends = []
    for side in (-1.0, 1.0):
        moved = center.copy()
        moved[index] += side * factor * spread
        ends.append(float(scales.outward(np.clip(moved, scales.low, scales.high))[index]))
    value = float(fitted.values[index])
    std = value * spread if scales.logarithmic[index] else spread
    return Estimate(value, std, (ends[0], ends[1]), parameter.unit)


def calibration_of(scored: Scored) -> dict[str, Any]:
    """The fitted calibration as a model file holds it."""
    found: dict[str, Any] = {}
    parameters = scored.fit.problem.forward.parameters
    for parameter, value in zip(parameters, scored.fit.values.tolist(), strict=True):
        if parameter.effect is None:
            name, _, entry = parameter.name.partition("[")
            if entry:
                found.setdefault(name, {})[entry.rstrip("]")] = value
            else:
                found[name] = value
    return found


def correlation_of(scored: Scored) -> dict[str, dict[str, float]]:
    """Correlation of every two parameters of a fitted model, by their names."""
    spread = np.sqrt(np.maximum(np.diag(scored.fit.covariance), 0.0))
    size = np.where(spread > 0.0, spread, 1.0)
    matrix = scored.fit.covariance / np.outer(size, size)
    known = names(scored.fit.problem)
    return {
        a: dict(zip(known, row, strict=True)) for a, row in zip(known, matrix.tolist(), strict=True)
    }
