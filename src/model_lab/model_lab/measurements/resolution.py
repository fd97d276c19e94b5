"""Resolution of coarse sensors, and the resulting uncertainty of the output.

While an actuator rests the rounding is the same in every sample, so neither scatter nor splines
tell it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from model_lab.aliases import Array, IntArray
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.rules import RULES

EQUAL_READINGS = 1e-6  # of the range: readings that differ by less are one
ROUNDING_DRAWS = 16


def sensor_step(readings: Sequence[Array], levels_at_least: int = RULES.sensor_levels) -> float:
    """Step by which the readings (n,) of a sensor are rounded, seen over all runs; 0 if no step is
    seen, or the range has fewer steps than `levels_at_least`.
    """
    span = max(float(np.ptp(values)) for values in readings) or 1.0
    of_runs = [
        EQUAL_READINGS * span * np.unique(np.round(values / (EQUAL_READINGS * span)))
        for values in readings
    ]
    levels = np.unique(np.concatenate(of_runs))
    if len(levels) < 2 or sum(map(len, readings)) < RULES.sensor_alike * sum(map(len, of_runs)):
        return 0.0
    apart = np.diff(levels)
    step = float(np.median(apart[apart < 1.5 * apart.min()]))
    whole = np.abs(apart / step - np.round(apart / step)) < RULES.sensor_whole
    return step if whole.all() and np.ptp(levels) >= levels_at_least * step else 0.0


def rounding_errors(data: MeasurementSet, predicted: Array, of_input: bool = True) -> Array | None:
    """Errors (draws, samples) in the output that coarse sensors may cause, for the outputs
    (samples,) that a model predicts; None if no steps are seen. of_input: whether the rounding of
    the input counts, too.

    Rounding errors are drawn uniformly within a step, again whenever the reading changes. An output
    that flickers between steps is left out: its rounding shows as noise.
    """
    table = data.table
    if not data.has_time or len(data.outputs) > 1 or data.experiment == "valve_pulse":
        return None
    inputs = [data.driving(data.runs[course.run]) for course in table.courses]
    driving = np.concatenate(inputs)
    step_in = sensor_step(inputs) if of_input else 0.0
    outputs = [table.value[course.samples] for course in table.courses]
    step_out = sensor_step(outputs, RULES.output_levels)
    if not step_in and not step_out:
        return None
    about = driving - driving.mean()
    slope = float(about @ predicted) / (float(about @ about) or 1.0)
    random = np.random.default_rng(0)
    drawn_in = _drawn(_rests(driving), random)
    rests = _rests(table.value)
    long = (np.bincount(rests) >= RULES.sensor_alike)[rests]
    return slope * step_in * drawn_in + step_out * _drawn(rests, random) * long


def _rests(readings: Array) -> IntArray:
    """The number (n,) of the rest, in which readings (n,) do not change, of each of them."""
    return np.cumsum(np.diff(readings, prepend=readings[0]) != 0.0)


def _drawn(rests: IntArray, random: np.random.Generator) -> Array:
    """Even numbers (draws, n) about 0, one for each rest, over a width of 1."""
    return random.uniform(-0.5, 0.5, (ROUNDING_DRAWS, int(rests[-1]) + 1))[:, rests]
