"""Scale and zero of a whole run, measured against its prediction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model_lab.aliases import Array, IntArray
from model_lab.measurements.sample_table import SampleTable
from model_lab.rules import RULES

OUTPUT_SCALE, OUTPUT_ZERO, LOAD_SCALE = "scale", "zero", "load"
SMALLEST_RATIO = 1e-3  # of measured to predicted; also stands for a run of the opposite sign


@dataclass(frozen=True)
class RunValues:
    """One number for each run.

    quantity: OUTPUT_SCALE, the natural logarithm of the ratio of measured to predicted outputs; or
    OUTPUT_ZERO, the measured output where the predicted one is zero, in the SI unit of the outputs.
    For positions, which lie far from zero, OUTPUT_ZERO is the mean difference of measured and
    predicted. output: index of the output; 0 for the scale, which all outputs share. values
    (runs,): the numbers. size (runs,): root mean square change of a run's outputs when its number
    changes by 1.
    """

    quantity: str
    output: int
    values: Array
    size: Array


def run_values(
    table: SampleTable, measured: Array, predicted: Array, of_places: bool = False
) -> tuple[RunValues, ...]:
    """Scale of every run, and zero of each of its outputs, from measured and predicted outputs
    (samples,). of_places: whether the outputs are positions [m].
    """
    runs = range(table.runs)
    read, said = ([table.of_run(values, run) for run in runs] for values in (measured, predicted))
    outputs = range(len(read[0]))
    units = np.sqrt([np.mean(_of_output(read, output) ** 2) for output in outputs])
    units = np.where(units > 0.0, units, 1.0)[:, None]
    pairs = list(zip(read, said, strict=True))
    scale = np.array([_log_ratio(y / units, p / units) for y, p in pairs])
    size = np.sqrt([max(np.mean(y**2), np.mean(p**2)) for y, p in pairs])
    found = [RunValues(OUTPUT_SCALE, 0, scale, size)]
    for output in outputs:
        zero = [(_shift if of_places else _zero)(y[output], p[output]) for y, p in pairs]
        found.append(RunValues(OUTPUT_ZERO, output, np.array(zero), np.ones(len(zero))))
    return tuple(one for one in found if np.all(np.isfinite(one.values)))


def _of_output(values: list[Array], output: int) -> Array:
    return np.concatenate([part[output] for part in values])


def _log_ratio(measured: Array, predicted: Array) -> float:
    square = float(np.sum(predicted**2))
    if square == 0.0:
        return float("nan")
    return float(np.log(max(float(np.sum(measured * predicted)) / square, SMALLEST_RATIO)))


def _zero(measured: Array, predicted: Array) -> float:
    """Intercept of the line through measured over predicted values; NaN without two of them."""
    about = predicted - predicted.mean()
    square = float(about @ about)
    if square <= 1e-12 * float(predicted @ predicted) or square == 0.0:
        return float("nan")
    slope = float(about @ measured) / square
    return float(measured.mean() - slope * predicted.mean())


def _shift(measured: Array, predicted: Array) -> float:
    """Mean distance of measured from predicted values."""
    return float(np.mean(measured - predicted))


def within_groups(values: Array, group: IntArray) -> Array:
    """Values (..., runs) less their mean over the repeats of each run; group (runs,): number of the
    group of repeats of each run.
    """
    member = group == np.unique(group)[:, None]
    return np.asarray(values - (values @ member.T / member.sum(axis=1)) @ member)


def as_good(left: float, least: float, freedom: int) -> bool:
    """Whether two explanations are equally good for the repeats: `left` and `least` are the sums of
    squares that they leave, `freedom` is their degrees of freedom.
    """
    return freedom * np.log(max(left, 1e-300) / max(least, 1e-300)) <= RULES.event_tie
