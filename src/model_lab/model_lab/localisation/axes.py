"""What a residual may vary with: the axes of the contract, one value for every sample.

`pressure` stands for what drives the experiment: the stretch when pulling a bar, and the pressure
drop p_in - p_out of a valve pulse. A pulse has no course of its own: its direction is that of the
valve, its `time_since_step` the time for which the valve was open.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from model_lab.aliases import Array
from model_lab.measurements.hands import FORCES, GRASP, MARKER_AXES, PRESS
from model_lab.measurements.measurement_set import (
    DEFLATE,
    TEMPERATURE,
    MeasurementSet,
    Run,
    down_of,
)
from model_lab.measurements.units import Display
from model_lab.rules import RULES

SMOOTHED = 100  # a rate is taken over two of so many parts of a run ...
LONGEST_SMOOTHED = 20  # ... but over twice so many samples at most

ROUNDING_ERROR = 1e-9  # of the largest value of an axis, within which values are one
NO_UNIT = Display("")
RISING, RESTS, FALLING = 0.0, 1.0, 2.0
COURSES = ("rises", "rests", "falls")
DIRECTION_NAMES = ("inflating", "deflating")
DRIVING_QUANTITY = {
    "uniaxial": ("stretch", ""),
    "rubber": ("stretch", ""),
    "valve_pulse": ("pressure drop", "Pa"),
}  # others: pressure
MARKER = "marker"
AXES_OF_RUNS = (
    ("run_order", "run", ""),
    ("temperature", "temperature", "K"),
    ("wall", "wall", "m"),
)


@dataclass(frozen=True)
class Axis:
    """One axis along which a residual may vary.

    values (samples,): in SI units; NaN for samples without a value. noun: what the axis means in
    this experiment. categories: names of the values 0, 1, ... of an axis without order; empty for
    others. of_run: whether the value is constant within a run. display: unit and factor with which
    values are shown.
    """

    name: str
    noun: str
    unit: str
    values: Array
    categories: tuple[str, ...] = ()
    of_run: bool = False
    display: Display = NO_UNIT


def axes_of(data: MeasurementSet) -> tuple[Axis, ...]:
    """The axes along which a set varies. Of axes with the same values within runs only the first is
    kept.
    """
    axes = [*_course_axes(data), *_run_axes(data), *(_hand_axes(data) if data.of_hand else ())]
    varied = [replace(axis, display=data.shown_in(axis.unit)) for axis in axes if _varies(axis)]
    return tuple(
        axis
        for index, axis in enumerate(varied)
        if axis.of_run or not any(_same(axis, other) for other in varied[:index])
    )


def input_rate(run: Run, values: Array) -> Array:
    """Smoothed rate of change (samples,) of an input, per second; per sample if the run has no
    time.
    """
    count = len(values)
    if count < 2:
        return np.zeros(count)
    time = run.columns.get("time", np.arange(count, dtype=float))
    reach = min(max(count // (2 * SMOOTHED), 1), LONGEST_SMOOTHED)
    index = np.arange(count)
    before, after = np.maximum(index - reach, 0), np.minimum(index + reach, count - 1)
    return (values[after] - values[before]) / (time[after] - time[before])


def resting_share(data: MeasurementSet) -> float:
    """Share (0 to 1) of all samples in which the driving input is constant."""
    inputs = [data.driving(run) for run in data.runs]
    rests = [
        _course(run, values, input_rate(run, values)) == RESTS for run, values in _zip(data, inputs)
    ]
    return float(np.mean(np.concatenate(rests)))


def _in_runs(data: MeasurementSet, values: Sequence[Array]) -> Array:
    """Values (samples,) of a set, given those of each run (samples of the run,)."""
    return np.concatenate(values).astype(float)[data.table.row]


def _of_runs(data: MeasurementSet, values: Sequence[float]) -> Array:
    """Values (samples,) of a set, given one for each run."""
    return np.array(values, float)[data.table.run]


# ---------------------------------------------------------------------- within runs
def _course_axes(data: MeasurementSet) -> list[Axis]:
    noun, unit = DRIVING_QUANTITY.get(data.experiment, ("pressure", "Pa"))
    inputs = [data.driving(run) for run in data.runs]
    axes = [Axis("pressure", noun, unit, _in_runs(data, inputs))]
    if data.experiment == "valve_pulse":
        return axes + _pulse_axes(data)
    rates = [input_rate(run, values) for run, values in zip(data.runs, inputs, strict=True)]
    courses = [_course(run, values, rate) for run, values, rate in _zip(data, inputs, rates)]
    axes.append(Axis("direction", noun, "", _in_runs(data, courses), COURSES))
    if data.has_time:
        of_rates = f"{unit or '1'}/s"
        axes.append(Axis("pressure_rate", f"{noun} rate", of_rates, _in_runs(data, rates)))
        since = [_since_moved(run, course) for run, course in zip(data.runs, courses, strict=True)]
        axes.append(Axis("time_since_step", "time since a step", "s", _in_runs(data, since)))
    largest = _in_runs(data, _largest_so_far(data, inputs))
    axes.append(Axis("largest_pressure", f"largest {noun} so far", unit, largest))
    return axes


def _zip(data: MeasurementSet, *values: Sequence[Array]) -> zip:
    return zip(data.runs, *values, strict=True)


def _pulse_axes(data: MeasurementSet) -> list[Axis]:
    deflating = [run.columns["direction"] == DEFLATE for run in data.runs]
    durations = [run.columns["duration"] for run in data.runs]
    return [
        Axis("direction", "valve", "", _in_runs(data, deflating), DIRECTION_NAMES),
        Axis("time_since_step", "pulse duration", "s", _in_runs(data, durations)),
    ]


def _course(run: Run, values: Array, rate: Array) -> Array:
    """RISING, RESTS or FALLING for each sample (samples,) of an input."""
    time = run.columns.get("time", np.arange(len(values), dtype=float))
    typical = float(np.ptp(values)) / max(float(np.ptp(time)), 1e-300)
    course = np.full(len(values), RESTS)
    course[rate > RULES.resting_rate * typical] = RISING
    course[rate < -RULES.resting_rate * typical] = FALLING
    return course


def _since_moved(run: Run, course: Array) -> Array:
    """Time [s] (samples,) for which the input has rested since it rose or fell, else NaN."""
    time = run.columns["time"]
    moved = np.where(course != RESTS, time, -np.inf)
    since = time - np.maximum.accumulate(moved)
    return np.where(np.isfinite(since) & (course == RESTS), since, np.nan)


def _largest_so_far(data: MeasurementSet, inputs: Sequence[Array]) -> list[Array]:
    """The largest input (samples,) that the specimen has seen, run by run."""
    largest: dict[str, float] = {}
    result = []
    for run, values in zip(data.runs, inputs, strict=True):
        before = -np.inf if run.virgin else largest.get(run.specimen, -np.inf)
        if run.lead:
            before = max(before, float(np.max(data.driving(replace(run, columns=run.lead)))))
        result.append(np.maximum.accumulate(np.maximum(values, before)))
        largest[run.specimen] = float(result[-1][-1])
    return result


# ---------------------------------------------------------------------- of runs
def _run_axes(data: MeasurementSet) -> list[Axis]:
    axes = [
        Axis(name, noun, unit, _of_runs(data, data.of_runs(name)), of_run=True)
        for name, noun, unit in AXES_OF_RUNS
    ]
    if any(TEMPERATURE in run.columns for run in data.runs):
        warmth = _in_runs(data, [run.warmth for run in data.runs])
        axes = [
            replace(axis, values=warmth, of_run=False) if axis.name == TEMPERATURE else axis
            for axis in axes
        ]
    return [
        *axes,
        *(_named_axis(data, name, data.of_runs(name)) for name in ("mode", "mount", "specimen")),
    ]


def _hand_axes(data: MeasurementSet) -> list[Axis]:
    """Pressure of each channel, share of the weight along each axis of the wrist, and marker."""
    axes = [Axis(name, name, "Pa", data.column(name)) for name in data.pressures]
    down = np.array([down_of(run) for run in data.runs]).T
    for axis, along in zip(MARKER_AXES, down, strict=True):
        name = f"down.{axis}"
        axes.append(Axis(name, name, "", _of_runs(data, along.tolist()), of_run=True))
    if data.experiment == PRESS:
        part = data.table.output // len(FORCES)
        return [*axes, Axis("part", "part", "", part.astype(float), ("force", "torque"))]
    if data.experiment == GRASP:
        one = data.table.output.astype(float)
        return [*axes, Axis("part", "part", "", one, data.outputs)]
    marker = data.table.output // len(MARKER_AXES)
    return [*axes, Axis(MARKER, MARKER, "", marker.astype(float), tuple(data.markers))]


def _named_axis(data: MeasurementSet, name: str, names: Sequence[str]) -> Axis:
    categories = tuple(dict.fromkeys(names))
    values = [float(categories.index(entry)) for entry in names]
    return Axis(name, name, "", _of_runs(data, values), categories, of_run=True)


def _varies(axis: Axis) -> bool:
    known = axis.values[np.isfinite(axis.values)]
    if not len(known):
        return False
    if axis.name == "pressure_rate":
        low, high = np.quantile(known, (0.1, 0.9))
        return float(high - low) > RULES.even_rate * float(np.abs(known).max())
    return bool(np.ptp(known) > ROUNDING_ERROR * np.abs(known).max())


def _same(axis: Axis, other: Axis) -> bool:
    """Whether two axes are one, as pressure and the largest so far are where it only rises."""
    return np.array_equal(axis.values, other.values, equal_nan=True)
