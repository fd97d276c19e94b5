"""Figures of the output over the input, runs of one protocol on top of each other, and of the
residual over the input and its autocorrelation.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from model_lab.aliases import Array
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.units import Display
from model_lab.report.drawing import Drawing, Key, Panel, Scale
from model_lab.report.marks import Mark, Points, Strip, evenly

Residuals = Sequence[tuple[str, Array]]
"""Colour of a model (`before` or `after`) and its residual (samples,), for each model."""

LOOP_PANELS, LOOP_DOTS = 12, 400  # that are shown
REST_DOTS = 1500
LONGEST_LAG = 40  # samples, and at most half of a run
WHITE_SIGMA = 1.96  # of the 95 % band of an autocorrelation
MODEL_WORDS = {"before": "model", "after": "with the missing effects"}


def loops(data: MeasurementSet, residuals: Residuals) -> Drawing:
    """Figure of measured and predicted outputs over the input, one panel for each specimen and
    protocol.
    """
    groups: dict[tuple[int, int], list[int]] = {}
    for place, course in enumerate(data.table.courses):
        groups.setdefault((course.group, course.output), []).append(place)
    every = [groups[key] for key in sorted(groups)]
    shown = [every[index] for index in evenly(len(every), LOOP_PANELS)]
    part = "" if len(shown) == len(every) else f" {len(shown)} of {len(every)} panels are shown."
    predicted = ", lines are predicted for runs that were held out of the fit" if residuals else ""
    caption = (
        "Output over input; dots are measured, repeats are drawn in the same panel"
        f"{predicted}.{part}"
    )
    x = Scale(input_of(data)[0])
    panels = tuple(_loop(data, residuals, places, x) for places in shown)
    alt = f"Output over input in {len(shown)} panels"
    keys = (Key("measured", "measured", "o"), *_keys(residuals))
    return Drawing("loops", "Output over input", caption, alt, panels, keys)


def rest_over_input(data: MeasurementSet, residuals: Residuals) -> Drawing:
    """Figure of the residual over the input, and of its autocorrelation within runs."""
    caption = (
        "Left: measured minus predicted over the input, each dot a sample. Right: correlation of "
        "the residual with itself, some time later in the same run, the mean of each run taken "
        "off; the green strip holds 95 % of white noise. A residual outside of it has a course "
        "that the model lacks, or its noise is not white."
    )
    panels = (_rest(data, residuals), _correlation(data, residuals))
    alt = "Residual over the input, and its autocorrelation"
    return Drawing("rest-over-input", "Residual", caption, alt, panels, tuple(_keys(residuals)))


def _keys(residuals: Residuals) -> Iterator[Key]:
    words = {**MODEL_WORDS, "before": "model as it was"} if len(residuals) > 1 else MODEL_WORDS
    yield from (Key(words[label], label) for label, _ in residuals)


def input_of(data: MeasurementSet) -> tuple[str, list[Array]]:
    """(label of the input with the unit of the user, its values run by run in that unit)."""
    if data.experiment == "valve_pulse":
        name = "duration"
        values = [run.columns["direction"] * run.columns["duration"] for run in data.runs]
        noun = "pulse duration (negative: deflating)"
    else:
        name = noun = "stretch" if data.stretched else "pressure"
        values = [data.driving(run) for run in data.runs]
    display = data.display(name)
    return _label(noun, display), [display.factor * one + display.offset for one in values]


def _label(noun: str, display: Display) -> str:
    return f"{noun} [{display.unit or '-'}]"


def _loop(data: MeasurementSet, residuals: Residuals, places: Sequence[int], x: Scale) -> Panel:
    courses = [data.table.courses[place] for place in places]
    first = data.runs[courses[0].run]
    output = data.outputs[courses[0].output]
    display = data.display(output)
    inputs = input_of(data)[1]
    marks: list[Mark] = []
    for course in courses:
        at, measured = inputs[course.run], data.table.value[course.samples]
        shown = display.factor * measured
        dots = max(LOOP_DOTS // len(courses), 1)
        marks.append(Points(at, shown, "measured", marker="o", size=2.2, opacity=0.4, most=dots))
        for label, residual in residuals:
            line = display.factor * (measured - residual[course.samples])
            dotted = data.experiment == "valve_pulse"
            look = {"marker": "x", "most": dots} if dotted else {"width": 1.1}
            marks.append(Points(at, line, label, label, **look))
    names = dict.fromkeys([first.specimen, first.protocol, first.mode])
    title = ", ".join(filter(None, names))
    return Panel(tuple(marks), x, Scale(_label(output.replace("_", " "), display)), title)


def _rest(data: MeasurementSet, residuals: Residuals) -> Panel:
    label, inputs = input_of(data)
    at = np.concatenate(inputs)[data.table.row]
    display = data.display(data.outputs[0])
    kept = np.random.default_rng(0).permutation(len(at))[:REST_DOTS]
    marks: list[Mark] = [Strip(0.0, 0.0, "measured", "y", width=0.6)]
    marks += [
        Points(at[kept], display.factor * residual[kept], colour, marker="o", size=1.6,
               opacity=0.4, most=REST_DOTS)
        for colour, residual in residuals
    ]  # fmt: skip
    return Panel(tuple(marks), Scale(label), Scale(f"residual [{display.unit}]"), "Over the input")


def _correlation(data: MeasurementSet, residuals: Residuals) -> Panel:
    shortest = min(course.length for course in data.table.courses)
    most = max(min(LONGEST_LAG, shortest // 2), 1)
    band = WHITE_SIGMA / np.sqrt(data.table.samples)
    step, x = 1.0, "lag [samples]"
    if data.has_time:
        display = data.display("time")
        times = [np.diff(run.columns["time"]) for run in data.runs]
        step, x = display.factor * float(np.median(np.concatenate(times))), f"lag [{display.unit}]"
    marks: list[Mark] = [Strip(-band, band, "floor", "y")]
    for colour, residual in residuals:
        found = autocorrelation([residual[c.samples] for c in data.table.courses], most)
        lags = np.asarray(step * np.arange(1, most + 1), float)
        marks.append(Points(lags, found, colour, width=1.2, marker="o", size=2.5))
    return Panel(tuple(marks), Scale(x), Scale("autocorrelation [-]", (-1.05, 1.05)), "With itself")


def autocorrelation(courses: Sequence[Array], most: int) -> Array:
    """Autocorrelation (most,) of courses (n,) at lags of 1 to `most` samples, over all courses; the
    mean of each course is subtracted first.

    >>> autocorrelation([np.array([1.0, -1.0, 1.0, -1.0])], 2).tolist()
    [-0.75, 0.5]
    """
    clean = [np.nan_to_num(course - np.nanmean(course)) for course in courses]
    power = sum(float(course @ course) for course in clean)
    if power == 0.0:
        return np.zeros(most)
    products = [
        sum(float(course[lag:] @ course[:-lag]) for course in clean if len(course) > lag)
        for lag in range(1, most + 1)
    ]
    return np.array(products) / power
