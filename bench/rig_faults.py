"""Faults of a rig that a set gets afterwards: what happens between runs, or to one run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from model_lab.aliases import Array
from model_lab.measurements.measurement_set import MeasurementSet, Run


def slipped_winding(data: MeasurementSet, first: int, gain: float) -> MeasurementSet:
    """Outputs larger by a relative `gain` from the run `first` (an index) on."""
    return _changed(data, lambda index, values: values * (1.0 + gain * (index >= first)))


def drifting_gain(data: MeasurementSet, gain: float) -> MeasurementSet:
    """Outputs that grow evenly over the series, by a relative `gain` at its last run."""
    last = max(len(data.runs) - 1, 1)
    return _changed(data, lambda index, values: values * (1.0 + gain * index / last))


def changed_sensor(data: MeasurementSet, first: int, gain: float, zero: float) -> MeasurementSet:
    """Another sensor from the run `first` on: a relative `gain`, and a `zero` over the largest
    reading of the set.
    """
    largest = float(np.abs(data.table.value).max())
    return _changed(
        data,
        lambda index, values: values * (1 + gain) + zero * largest if index >= first else values,
    )


def run_in_other_unit(
    data: MeasurementSet, run: int, factor: float, column: str = ""
) -> MeasurementSet:
    """One run with a column (the output by default) written in a unit `factor` times as small."""
    name = column or data.outputs[0]
    runs = list(data.runs)
    columns = {**runs[run].columns, name: factor * runs[run].columns[name]}
    runs[run] = replace(runs[run], columns=columns)
    return replace(data, runs=tuple(runs))


def exchanged_plugs(data: MeasurementSet, first: int, second: int) -> MeasurementSet:
    """Two runs of as many samples, each with the outputs of the other."""
    runs = list(data.runs)
    outputs = [{name: runs[run].columns[name] for name in data.outputs} for run in (first, second)]
    for run, other in zip((first, second), reversed(outputs), strict=True):
        runs[run] = replace(runs[run], columns={**runs[run].columns, **other})
    return replace(data, runs=tuple(runs))


def _changed(data: MeasurementSet, change: Callable[[int, Array], Array]) -> MeasurementSet:
    """The set with all outputs (samples of a run,) changed, given the index of the run."""

    def of_run(index: int, run: Run) -> Run:
        outputs = {
            name: change(index, run.columns[name]) for name in data.outputs if name in run.columns
        }
        return replace(run, columns={**run.columns, **outputs})

    return replace(data, runs=tuple(of_run(index, run) for index, run in enumerate(data.runs)))
