"""Noise of the masses of valve pulses, from pulses that resemble each other.

Pulses follow each other in any order, so a spline over their order leaves the whole error of a
model. Their masses are a smooth function of durations and pressures: what a regression on these and
on their products leaves is the noise, and what no equation of a valve explains.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.linalg import orth

from model_lab.aliases import Array
from model_lab.measurements.measurement_set import INPUTS, MeasurementSet
from model_lab.rules import RULES
from softhand_model.gas import psi

LEAST_SINGULAR = 1e-7  # of the largest singular value: less is rounding


def pulse_level(data: MeasurementSet, residual: Array) -> float | None:
    """Standard deviation of the noise of the masses, in the unit of the residual (samples,) of a
    model; None if there are too few pulses.
    """
    squares, freedom = 0.0, 0
    for index, run in enumerate(data.runs):
        rest = residual[data.table.run == index]
        for direction in np.unique(run.columns["direction"]):
            chosen = run.columns["direction"] == direction
            shapes = _regressors({name: run.columns[name][chosen] for name in run.columns})
            base = orth(shapes, LEAST_SINGULAR)
            if len(base) < 2 * base.shape[1]:
                continue
            left = rest[chosen] - base @ (base.T @ rest[chosen])
            squares, freedom = squares + float(left @ left), freedom + len(base) - base.shape[1]
    return float(np.sqrt(squares / freedom)) if freedom >= RULES.fewest_freedom else None


def _regressors(columns: Mapping[str, Array]) -> Array:
    """Terms of eq. 4.1 and products (pulses, terms) of pulses of one direction, each of size 1."""
    duration, p_in, p_out = (columns[name] for name in INPUTS["valve_pulse"][1:4])
    friction = columns.get("friction_integral", (p_in - p_out) * duration)
    injector = columns.get("injector_integral", p_in * psi(p_out / p_in) * duration)
    straight = [p_in * duration, p_out * duration, friction, injector]
    bent = [duration * term for term in straight]
    ones = np.ones_like(duration)
    terms = [ones, duration, duration**2, p_in, p_out, p_in * p_out, *straight, *bent]
    return np.stack([term / np.linalg.norm(term) for term in terms], axis=1)
