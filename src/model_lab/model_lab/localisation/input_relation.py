"""Relation of a residual to the input over time: cross-correlation and loops."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from model_lab.aliases import Array
from model_lab.measurements.measurement_set import MeasurementSet, Run
from model_lab.rules import RULES

GRID_STEPS = 500  # of the longest run
LARGEST_LAG = 50  # lag in steps


@dataclass(frozen=True)
class InputRelation:
    """How a residual follows the input of its runs.

    lag (2*LARGEST_LAG + 1,): of the residual behind the input, in `lag_unit` (seconds; samples if
    there is no time). correlation (outputs, lags): from -1 to 1, over all runs, each about its
    mean. loop_area: by run (outputs,), integral of the residual over the closed course of the
    input, in the product of their SI units; positive when the residual is larger while the input
    falls. loop_width: by run (outputs,), by how much it is then larger on average, in the unit of
    the residual. Both are NaN for runs whose input does not return to its start.
    """

    lag: Array
    lag_unit: str
    correlation: Array
    loop_area: Mapping[str, Array]
    loop_width: Mapping[str, Array]

    def strongest(self, output: int = 0) -> tuple[float, float]:
        """(lag, correlation) where the correlation of an output, given by its index, is largest in
        magnitude.
        """
        index = int(np.argmax(np.abs(self.correlation[output])))
        return float(self.lag[index]), float(self.correlation[output, index])


def input_relation(data: MeasurementSet, residual: Array) -> InputRelation | None:
    """The relation of a residual (samples,) to the input; None for valve pulses, in which the input
    has no course.
    """
    if data.experiment == "valve_pulse":
        return None
    outputs = len(data.outputs)
    step = max(float(np.ptp(_time(run, data.has_time))) for run in data.runs) / GRID_STEPS or 1.0
    products = np.zeros((outputs, 2 * LARGEST_LAG + 1))
    squares, area, width = np.zeros((outputs, 2)), {}, {}
    for index, run in enumerate(data.runs):
        part, course = data.table.of_run(residual, index), data.driving(run)
        area[run.name], width[run.name] = _loop(part, course)
        more = _products(part, course, _time(run, data.has_time), step)
        products, squares = products + more[0], squares + more[1]
    size = np.sqrt(squares.prod(axis=1, keepdims=True))
    correlation = np.divide(products, size, out=np.zeros_like(products), where=size > 0.0)
    lag: Array = step * np.arange(-LARGEST_LAG, LARGEST_LAG + 1, dtype=float)
    return InputRelation(lag, "s" if data.has_time else "samples", correlation, area, width)


def _time(run: Run, has_time: bool) -> Array:
    return run.columns["time"] if has_time else np.arange(run.samples, dtype=float)


def _loop(residual: Array, course: Array) -> tuple[Array, Array]:
    """Area (outputs,) and mean width of the loops of a residual (outputs, samples)."""
    if abs(course[-1] - course[0]) > RULES.open_loop * np.ptp(course):
        return np.full(len(residual), np.nan), np.full(len(residual), np.nan)
    closed = np.append(residual, residual[:, :1], axis=1)
    steps = np.diff(np.append(course, course[0]))
    area = -np.sum((closed[:, 1:] + closed[:, :-1]) / 2.0 * steps, axis=1)
    travelled = float(np.abs(steps).sum())
    return area, 2.0 * area / travelled if travelled > 0.0 else np.zeros(len(residual))


def _products(residual: Array, course: Array, time: Array, step: float) -> tuple[Array, Array]:
    """Sums of products (outputs, lags) and of squares (outputs, 2) on an even grid of time."""
    grid = np.arange(time[0], time[-1] + 0.5 * step, step)
    driving = _about_mean(np.interp(grid, time, course))
    products, squares = [], []
    for output in residual:
        follows = _about_mean(np.interp(grid, time, output))
        full = np.correlate(follows, driving, "full")
        products.append(_middle(full, len(grid)))
        squares.append([np.sum(follows**2), np.sum(driving**2)])
    return np.array(products), np.array(squares)


def _about_mean(values: Array) -> Array:
    return values - values.mean()


def _middle(full: Array, count: int) -> Array:
    """The values of a cross-correlation for lags from -LARGEST_LAG to LARGEST_LAG steps.

    `full` (2*count - 1,) is `np.correlate(..., "full")` of two series of `count` values, whose lag
    0 stands in its middle. Lags that series so short do not have get 0.
    """
    padded = np.pad(full, LARGEST_LAG)
    center = count - 1 + LARGEST_LAG
    return padded[center - LARGEST_LAG : center + LARGEST_LAG + 1]
