"""Inputs between samples: parabolas from the neighbouring samples, straight lines beside corners.

Effects in time, a lag or a late clock, need the input between samples. Straight lines cut the bends
of a smooth input; an effect that treats these errors differently from its rivals could win or lose
by that alone. So all effects get the same input: between two samples a parabola with the harmonic
mean of the second differences at both ends (as van Leer limits slopes), which is straight beside a
corner. A run that does not start steady was at rest before.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model_lab.aliases import Array, Indices
from model_lab.measurements.held_input import DRIVING_COLUMN
from model_lab.measurements.measurement_set import MeasurementSet, Run

STRAIGHT_TOLERANCE = 2e-4  # of the input's range, that straight lines may be off
MOST_PIECES = 8  # pieces of the distance between two samples


def begun(time: Array, values: Array, before: float) -> tuple[Array, Array]:
    """Times and values, (n + 1,) each, with one more sample in front, whose value is `before`."""
    apart = (time[-1] - time[0]) / max(len(time) - 1, 1)
    return np.append(time[0] - apart, time), np.append(before, values)


def bends(time: Array, values: Array) -> Array:
    """Half the second derivative (n - 1,) of a course (n,) between its samples.

    >>> bends(np.arange(4.0), np.array([0.0, 1.0, 4.0, 9.0]))
    array([0., 1., 0.])
    """
    changes = np.diff(values) / np.diff(time)
    at = np.zeros(len(time))
    at[1:-1] = np.diff(changes) / (time[2:] - time[:-2])
    before, after = at[:-1], at[1:]
    alike = before * after > 0.0
    both = np.where(alike, before + after, 1.0)
    return np.where(alike, 2.0 * before * after / both, 0.0)


def between(time: Array, values: Array, bend: Array, wanted: Array) -> Array:
    """Values of a course (n,) with `bend` (n - 1,) from `bends`, at wanted times of any shape
    within its own.
    """
    at = np.clip(np.searchsorted(time, wanted, side="right") - 1, 0, len(time) - 2)
    beside = (wanted - time[at]) * (wanted - time[at + 1])
    return np.asarray(np.interp(wanted, time, values) + bend[at] * beside)


def with_bends(data: MeasurementSet) -> tuple[MeasurementSet, Indices]:
    """(the set with more samples where the driving input bends, indices of the original samples).
    The experiment must have a column that drives it.
    """
    driving, rest = DRIVING_COLUMN[data.experiment], 1.0 if data.stretched else 0.0
    runs, places, so_far = [], [], 0
    for run in data.runs:
        more, own = _with_bends(run, driving, rest)
        runs.append(more)
        places.append(so_far + own)
        so_far += more.samples
    return replace(data, runs=tuple(runs)), np.concatenate(places)


def _with_bends(run: Run, driving: str, rest: float) -> tuple[Run, Indices]:
    """The run with more samples where it bends; other columns go straight."""
    own = np.arange(run.samples)
    if run.samples < 3 or "time" not in run.columns:
        return run, own
    time, values = run.columns["time"], run.columns[driving]
    before = float(values[0]) if run.steady else rest
    bend, apart = bends(*begun(time, values, before))[1:], np.diff(time)
    off = np.abs(bend) * apart**2 / 4.0 / (STRAIGHT_TOLERANCE * (np.ptp(values) or 1.0))
    pieces = np.clip(np.ceil(np.sqrt(off)), 1, MOST_PIECES).astype(int)
    place = np.concatenate([[0], np.cumsum(pieces)])
    if place[-1] == own[-1]:
        return run, own
    finer = np.interp(np.arange(place[-1] + 1), place, time)
    columns = {name: np.interp(finer, time, column) for name, column in run.columns.items()}
    columns |= {"time": finer, driving: between(time, values, bend, finer)}
    return replace(run, columns=columns), place
