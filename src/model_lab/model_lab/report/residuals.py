"""Residuals before and after against every axis of the set, with bands; anomalies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from model_lab.aliases import Array, IntArray
from model_lab.fitting.notice import Notice
from model_lab.localisation.axes import Axis
from model_lab.localisation.bins import Bins
from model_lab.localisation.localise import RUNS, Dependence, Localisation, localise
from model_lab.report.drawing import FLOOR_KEY, Drawing, Key, Panel, Scale
from model_lab.report.marks import DASHES, Band, Bars, Mark, Points, Strip
from model_lab.report.sentences import listed
from model_lab.report.view import View

RESIDUAL_DOTS = 2000  # samples that are drawn
SCALE_PERCENTILE = 99.7  # percentile of the residuals to which the scale reaches
SKEWED_RATIO = 8.0  # largest value over the 75th percentile from which a scale is bent
TICK_DISTANCE = 3.0  # by which a tick within is smaller than the end of a bent scale
BENT_SCALES = ("pressure_rate", "time_since_step")
DOT_SPREAD = 0.32  # of a category's width, over which its dots lie
MOST_CATEGORY_VALUES = 12  # values of an axis that stand side by side
ODD_DOTS = 600
ODD_TITLES = {
    "repeats": "Scatter of repeats",
    "line": "Share of the error at a frequency",
    "wild_samples": "Wild samples",
    "drift": "Mean error of each run",
    "apart": "Mean error of each run, repeats apart",
    "zero": "Reading at rest of each run",
    "driven": "Range of the input of each run",
    "held_input": "Input that is held until it jumps",
    "clipped": "Change of the output while the input stays at its largest reading",
    "gaps": "Time between samples",
    "size": "Readings of another size than the model's",
    "absolute": "Smallest pressure of each run",
    "duration": "Duration of each run",
    "pulses": "Integral over duration and first difference of pressures",
    "single_sample": "Samples of each run",
    "left_out": "Runs that the model follows",
}
ODD_ABSCISSAS = {
    "line": "frequency [Hz]",
    "wild_samples": "sample",
    "drift": "run",
    "apart": "run",
    "zero": "run",
    "driven": "run",
    "held_input": "time [s]",
    "clipped": "run",
    "gaps": "sample",
    "size": "sample",
    "absolute": "run",
    "duration": "run",
    "pulses": "pulse",
    "single_sample": "run",
    "left_out": "run, those left out last",
}
ODD_ORDINATES = {  # the others are errors
    "line": "share [-]",
    "driven": "range, in Pa or of the stretch",
    "held_input": "share of the largest [-]",
    "gaps": "time [s]",
    "absolute": "pressure [Pa]",
    "duration": "time [s]",
    "pulses": "ratio [-]",
    "single_sample": "samples [-]",
    "left_out": "followed [-]",
}
NOISE_LEVELS = ("stated", "within runs", "with repeats")


def residuals(view: View) -> Drawing | None:
    """The figure of the residuals; None for a set in which nothing varies."""
    found = {label: localise(view.data, scored.held_out.residual) for label, scored in view.models}
    first = found["before"].axes
    if not first:
        return None
    caption = (
        "Measured minus predicted. Each point of a line is the mean over a part of the axis, its "
        f"band the 95 % interval of a bootstrap over {first[0].basis}; dots are single samples, "
        "the green strip is one sigma of the noise floor. Where the band of a line lies off zero, "
        f"the model is wrong in the same way {_again(first[0])}. Panels stand in the order of the "
        f"share of the error that they account for. {_in_words(found['before'])}"
    )
    models = "the model" if view.after is None else "the model before and after"
    alt = f"Residual of {models} against {', '.join(axis_title(one.bins.axis) for one in first)}"
    y = Scale(f"residual [{view.display.unit}]", _ends(view, found))
    dots = RESIDUAL_DOTS // (len(first) * len(view.models))
    panels = tuple(_panel(view, found, entry, y, dots) for entry in first)
    return Drawing("residuals", "Residuals", caption, alt, panels, tuple(_keys(view)))


def _again(entry: Dependence) -> str:
    """How often a residual recurs whose band is off zero."""
    return "run after run" if entry.basis == RUNS else "in one block of a run after the other"


def _in_words(before: Localisation) -> str:
    if not before.failures:
        return "Against none of them does the error vary beyond chance."
    entries = [
        f"{axis_title(entry.bins.axis)} ({entry.where}; {100 * entry.share_of_error:.0f} % of it)"
        for entry in before.failures[:3]
    ]
    return f"The error of the model as it was varies most with {listed(entries)}."


def _panel(
    view: View, found: Mapping[str, Localisation], first: Dependence, y: Scale, dots: int
) -> Panel:
    floor = view.display.factor * view.diagnosis.noise_floor
    marks: list[Mark] = [
        Strip(-floor, floor, "floor", "y", 0.16),
        Strip(0.0, 0.0, "measured", "y", width=0.6),
    ]
    for label, scored in view.models:
        dependence = next(d for d in found[label].axes if d.against == first.against)
        cloud = _dots(view, dependence.bins, label, scored.held_out.residual)
        marks.append(replace(cloud, most=dots))
        marks += _means(view, dependence, label)
    return Panel(tuple(marks), _scale(first.bins), y)


def _ends(view: View, found: Mapping[str, Localisation]) -> tuple[float, float]:
    """Ends of the scale: it holds nearly all residuals, the bands and the floor."""
    floor, factor = 1.5 * view.diagnosis.noise_floor, view.display.factor
    every = np.concatenate([scored.held_out.residual for _, scored in view.models])
    curves = [c for part in found.values() for axis in part.axes for c in axis.curves.values()]
    low = min(
        -floor, np.percentile(every, 100.0 - SCALE_PERCENTILE), *(_least(c.low) for c in curves)
    )
    high = max(floor, np.percentile(every, SCALE_PERCENTILE), *(-_least(-c.high) for c in curves))
    return 1.1 * factor * float(low), 1.1 * factor * float(high)


def _least(values: Array) -> float:
    """Smallest of the finite values; 0 without any."""
    return float(np.min(values, where=np.isfinite(values), initial=0.0))


def _keys(view: View) -> Iterator[Key]:
    words = {"before": "before" if view.after else "model", "after": "after"}
    yield from (Key(words[label], label) for label, _ in view.models)
    outputs = view.data.outputs if len(view.data.outputs) > 1 else ()
    yield from (Key(name, "other", dash) for name, dash in zip(outputs, DASHES, strict=False))
    yield FLOOR_KEY


# ---------------------------------------------------------------------- along an axis
def _scale(bins: Bins) -> Scale:
    """Label of the axis; names of categories; a bent scale where few values lie far out."""
    axis, names = bins.axis, _names(bins)
    display = axis.display
    label = f"{axis_title(axis)} [{display.unit}]" if display.unit else axis_title(axis)
    if names:
        ticks = tuple((float(at), name) for at, name in enumerate(names))
        return Scale(label, (-0.5, len(names) - 0.5), ticks=ticks)
    usual = _usual(bins)
    return Scale(label, ticks=_bent_ticks(display.factor * axis.values, usual) if usual else ())


def _usual(bins: Bins) -> float:
    """Value up to which a bent scale is nearly straight; 0 for a straight one."""
    known = bins.axis.values[np.isfinite(bins.axis.values)]
    values = abs(bins.axis.display.factor * known)
    usual = float(np.percentile(values, 75))
    bent = bins.axis.name in BENT_SCALES and values.max() > SKEWED_RATIO * usual > 0.0
    return usual if bent else 0.0


def _bent_ticks(values: Array, usual: float) -> tuple[tuple[float, str], ...]:
    """Zero, the usual value and its tenfolds, and the ends: where they are drawn and named."""
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    steps = float(f"{usual:.1g}") * 10.0 ** np.arange(9.0)
    inner = [
        v
        for v in (*-steps, 0.0, *steps)
        if low / TICK_DISTANCE < v < high / TICK_DISTANCE or v == 0.0
    ]
    ends = [v for v in (low, high) if abs(v) > TICK_DISTANCE * usual]
    shown = sorted({*inner, *ends})
    return tuple((float(np.arcsinh(v / usual)), f"{v:.2g}") for v in shown)


def axis_title(axis: Axis) -> str:
    """Title of an axis where it stands beside others."""
    return f"direction of the {axis.noun}" if axis.name == "direction" else axis.noun


def _names(bins: Bins) -> tuple[str, ...]:
    """Names of the places of an axis with few values; none if it is drawn to scale."""
    if bins.axis.categories:
        return tuple(name.replace("_", " ") for name in bins.axis.categories)
    if bins.axis.of_run and bins.count <= MOST_CATEGORY_VALUES and np.all(bins.low == bins.high):
        display = bins.axis.display
        return tuple(display.number(value) for value in bins.center.tolist())
    return ()


def _places(bins: Bins, values: Array, index: IntArray) -> Array:
    """Where values of an axis are drawn; index: of their bins."""
    if _names(bins):
        return values if bins.axis.categories else index.astype(float)
    display, usual = bins.axis.display, _usual(bins)
    shown = display.factor * values + display.offset
    return np.arcsinh(shown / usual) if usual else shown


def _dots(view: View, bins: Bins, label: str, residual: Array) -> Points:
    kept = np.flatnonzero(bins.index >= 0)
    at = _places(bins, bins.axis.values[kept], bins.index[kept]) + _beside(view, bins, label)
    if _names(bins):  # dots of one place a little apart
        at = at + DOT_SPREAD * (np.modf(kept * 0.618)[0] - 0.5) * 0.8
    shown = view.display.factor * residual[kept]
    return Points(at, shown, label, marker="o", size=1.3, opacity=0.35)


def _beside(view: View, bins: Bins, label: str) -> float:
    """Both models stand side by side where there are few places."""
    if view.after is None or not _names(bins):
        return 0.0
    return 0.5 * DOT_SPREAD if label == "after" else -0.5 * DOT_SPREAD


def _means(view: View, dependence: Dependence, label: str) -> Iterator[Mark]:
    bins = dependence.bins
    at = _places(bins, bins.center, np.arange(bins.count)) + _beside(view, bins, label)
    factor = view.display.factor
    for curve, dash in zip(dependence.curves.values(), DASHES, strict=False):
        mean, low, high = factor * curve.mean, factor * curve.low, factor * curve.high
        if _names(bins):
            yield bars_of_error(at, low, high, label)
            yield Points(at, mean, label, label, marker="o")
        else:
            yield Band(at, low, high, label)
            yield Points(at, mean, label, label, 1.2, dash, "o", 2.8)


def bars_of_error(at: Array, low: Array, high: Array, colour: str) -> Points:
    """Vertical bars between two values (n,) at each x (n,)."""
    gap = np.full(len(at), np.nan)
    y = np.stack([low, high, gap], axis=1).ravel()
    return Points(np.repeat(at, 3), y, colour, width=2.5, opacity=0.45)


# ---------------------------------------------------------------------- anomalies
def oddities(view: View) -> Drawing | None:
    """The figure of the notices, one panel for each; None without any."""
    found = view.outcome.notices
    if not found:
        return None
    said = "; ".join(notice.text for notice in found)
    caption = f"{said[0].upper()}{said[1:]}. What stands out is drawn in orange."
    panels = tuple(_odd_panel(view, notice) for notice in found)
    return Drawing("oddities", "What is odd", caption, caption, panels)


def _odd_panel(view: View, notice: Notice) -> Panel:
    title = ODD_TITLES[notice.kind]
    if notice.kind == "repeats":
        lengths = (view.display.factor * notice.y).tolist()
        ticks = tuple((float(at), level) for at, level in enumerate(NOISE_LEVELS))
        x, y = Scale(f"scatter [{view.display.unit}]"), Scale("", (2.6, -0.6), ticks=ticks)
        return Panel((Bars(lengths, ("floor", "other", "before")),), x, y, title, 2.1)
    other = ODD_ORDINATES.get(notice.kind)
    values = notice.y if other else view.display.factor * notice.y
    ordinate = other or f"error [{view.display.unit}]"
    look = {"width": 1.2} if other else {"marker": "o", "size": 1.5, "most": ODD_DOTS}
    marked = notice.marked
    marks = (
        Points(notice.x, values, "other", **look),
        Points(notice.x[marked], values[marked], "before", marker="o", size=5.0, most=ODD_DOTS),
    )
    return Panel(marks, Scale(ODD_ABSCISSAS[notice.kind]), Scale(ordinate), title)
