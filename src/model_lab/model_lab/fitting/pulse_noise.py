"""Noise of the masses of valve pulses, from pulses that resemble each other.

Pulses follow each other in any order, so a spline over their order leaves the whole error of a
model. Their masses are a smooth function of durations and pressures: what a regression on these and
on their products leaves is the noise, and what no equation of a valve explains.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence

import numpy as np
from scipy.linalg import orth

from model_lab.aliases import Array
from model_lab.measurements.measurement_set import INPUTS, MeasurementSet
from model_lab.rules import RULES
from softhand_model.gas import psi

LEAST_SINGULAR = 1e-7  # of the largest singular value: less is rounding
RUN = "run"  # column that says of which run a pulse is


def pulse_level(data: MeasurementSet, residual: Array) -> float | None:
    """Standard deviation of the noise of the masses, in the unit of the residual (samples,) of a
    model; None if there are too few pulses. Runs that are stated as repeats but command other
    pulses are looked at together, each with a gain of its own.
    """
    stated: dict[tuple[str, str], list[int]] = defaultdict(list)
    for index, run in enumerate(data.runs):
        stated[run.specimen, run.protocol].append(index)
    squares, freedom = 0.0, 0
    for runs in stated.values():
        columns = _joined(data, runs)
        rest = np.concatenate([residual[data.table.run == index] for index in runs])
        for direction in np.unique(columns["direction"]):
            chosen = columns["direction"] == direction
            shapes = _regressors({name: column[chosen] for name, column in columns.items()})
            base = orth(shapes, LEAST_SINGULAR)
            if len(base) < 2 * base.shape[1]:
                continue
            left = rest[chosen] - base @ (base.T @ rest[chosen])
            squares, freedom = squares + float(left @ left), freedom + len(base) - base.shape[1]
    return float(np.sqrt(squares / freedom)) if freedom >= RULES.fewest_freedom else None


def _joined(data: MeasurementSet, runs: Sequence[int]) -> dict[str, Array]:
    """Columns (pulses,) of some runs, by index, one after the other, and the run of each pulse."""
    parts = [data.runs[index].columns for index in runs]
    known = [name for name in parts[0] if all(name in part for part in parts)]
    joined = {name: np.concatenate([part[name] for part in parts]) for name in known}
    return joined | {RUN: np.repeat(runs, [data.runs[index].samples for index in runs])}


def _regressors(columns: Mapping[str, Array]) -> Array:
    """Terms of eq. 4.1, products, and gains of all runs but one (pulses, terms), for pulses of one
    direction; each of size 1.
    """
    duration, p_in, p_out = (columns[name] for name in INPUTS["valve_pulse"][1:4])
    friction = columns.get("friction_integral", (p_in - p_out) * duration)
    injector = columns.get("injector_integral", p_in * psi(p_out / p_in) * duration)
    straight = [p_in * duration, p_out * duration, friction, injector]
    bent = [duration * term for term in straight]
    ones = np.ones_like(duration)
    gains = [p_in * duration * (columns[RUN] == run) for run in np.unique(columns[RUN])[1:]]
    terms = [ones, duration, duration**2, p_in, p_out, p_in * p_out, *straight, *bent, *gains]
    return np.stack([term / np.linalg.norm(term) for term in terms if np.any(term)], axis=1)
