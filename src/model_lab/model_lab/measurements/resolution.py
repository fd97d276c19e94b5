"""Resolution of coarse sensors, and the resulting uncertainty of the output.

While an actuator rests the rounding is the same in every sample, so neither scatter nor splines
tell it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.polynomial import Polynomial

from model_lab.aliases import Array, IntArray, Mask
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.rules import RULES

EQUAL_READINGS = 1e-6  # of the range: readings that differ by less are one
ROUNDING_DRAWS = 32
HELD = 1e-3  # of a step: an input that changes by less from sample to sample is held
SLOPE_DEGREE = 3


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


def rounding_errors(data: MeasurementSet, predicted: Array, repeated: bool = False) -> Array | None:
    """Errors (draws, samples) in the output that coarse sensors may cause, for the outputs
    (samples,) that a model predicts; None if no steps are seen.

    Rounding errors are drawn uniformly within a step, again whenever the reading changes. An output
    that flickers between steps is left out: its rounding shows as noise. Of an input whose steps
    were taken out (`measurements.unrounded`), what is held is still rounded; of another one only
    repeats tell how much its rounding matters, if there are any.
    """
    table = data.table
    if not data.has_time or len(data.outputs) > 1 or data.experiment == "valve_pulse":
        return None
    inputs = [data.driving(data.runs[course.run]) for course in table.courses]
    driving = np.concatenate(inputs)
    step_in = data.input_step or (0.0 if repeated else sensor_step(inputs))
    outputs = [table.value[course.samples] for course in table.courses]
    step_out = sensor_step(outputs, RULES.output_levels)
    if not step_in and not step_out:
        return None
    random = np.random.default_rng(0)
    error_in = (
        _of_course(driving - (1.0 if data.stretched else 0.0), table.group, step_in, random)
        if data.input_step
        else step_in * _drawn(_rests(driving), random)
    )
    rests = _rests(table.value)
    error_out = step_out * _drawn(rests, random) * _long(rests)
    return _slope(driving, predicted) * error_in + error_out


def _of_course(driving: Array, group: IntArray, step: float, random: np.random.Generator) -> Array:
    """Errors (draws, n) that are left of an input's rounding once its steps are taken out: where it
    is held, but not at rest, that of the reading, alike in all repeats of a group; where it moves,
    at most its change from sample to sample. driving (n,): less that at rest.
    """
    level = np.round(driving / step)
    regions = _rests(level)
    held = (np.bincount(regions, held_still(driving, step))[regions] > 0.0) & (level != 0.0)
    alike = np.unique([group, level], axis=1, return_inverse=True)[1].reshape(-1)
    change = np.abs(np.diff(driving, prepend=driving[0]))
    moving = np.minimum(np.maximum(change, np.append(change[1:], 0.0)), step)
    every = np.arange(len(driving))
    return np.where(held, step * _drawn(alike, random), moving * _drawn(every, random))


def held_still(driving: Array, step: float) -> Mask:
    """Which samples (n,) of an input whose steps were taken out are held at one reading."""
    return _long(_rests(driving, HELD * step), RULES.held_samples)


def _slope(driving: Array, predicted: Array) -> Array:
    """Slope (n,) of a prediction over what drives it, by a polynomial."""
    levels = len(np.unique(driving))
    if levels < 2:
        return np.zeros_like(driving)
    course = Polynomial.fit(driving, predicted, min(SLOPE_DEGREE, levels - 1))
    return np.asarray(course.deriv()(driving), float)


def _long(rests: IntArray, least: float = RULES.sensor_alike) -> Mask:
    """Which samples (n,) belong to a rest of several ones."""
    return np.asarray((np.bincount(rests) >= least)[rests])


def _rests(readings: Array, alike: float = 0.0) -> IntArray:
    """The number (n,) of the rest, in which readings (n,) do not change, of each of them."""
    return np.cumsum(np.abs(np.diff(readings, prepend=readings[0])) > alike)


def _drawn(rests: IntArray, random: np.random.Generator) -> Array:
    """Even numbers (draws, n) about 0, one for each rest, over a width of 1."""
    return random.uniform(-0.5, 0.5, (ROUNDING_DRAWS, int(rests.max()) + 1))[:, rests]
