"""Residuals before and after against every axis of the set, with bands."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from model_lab.aliases import Array, IntArray
from model_lab.localisation.axes import Axis
from model_lab.localisation.bins import Bins
from model_lab.localisation.localise import RUNS, Dependence, Localisation, localise
from model_lab.measurements.units import display_of
from model_lab.report.drawing import (
    COLOURS,
    Drawing,
    floor_handle,
    legend_above,
    light_grid,
    line_handle,
    thinned,
)
from model_lab.report.sentences import listed
from model_lab.report.view import View

DOTS = 260  # samples of a panel that are drawn
COLUMNS = 3
ROW_HEIGHT = 2.0  # [in]
SHOWN = 99.7  # percentile of the residuals to which the scale reaches
SKEWED = 8.0  # largest value over the 75th percentile from which a scale is bent
LINES = ("-", (0, (4, 1.5)), (0, (1, 1.2)))  # of outputs
SPREAD = 0.32  # of a category's width, over which its dots lie
FEW = 12  # values of an axis that stand side by side
LONG_NAMES = 26  # letters of all categories that fit beside each other


def residuals(view: View) -> Drawing | None:
    """The figure, None for a set in which nothing varies."""
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
    rows = -(-len(first) // COLUMNS)
    models = "the model" if view.after is None else "the model before and after"
    return Drawing(
        "residuals",
        "Residuals",
        caption,
        f"Residual of {models} against {', '.join(axis_title(entry.bins.axis) for entry in first)}",
        0.55 + ROW_HEIGHT * rows,
        lambda figure: _draw(figure, view, found),
    )


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


def _draw(figure: Figure, view: View, found: Mapping[str, Localisation]) -> None:
    order = found["before"].axes
    columns = min(COLUMNS, len(order))
    rows = -(-len(order) // columns)
    grid = figure.subplots(rows, columns, sharey=True, squeeze=False)
    for axes, first in zip(grid.flat, order, strict=False):
        _draw_floor(axes, view)
        _scale(axes, first.bins)
        for label, scored in view.models:
            dependence = next(d for d in found[label].axes if d.against == first.against)
            _draw_dots(axes, view, dependence.bins, label, scored.held_out.residual)
            _draw_means(axes, view, dependence, label)
    for axes in list(grid.flat)[len(order) :]:
        axes.set_visible(False)
    for row in grid:
        row[0].set_ylabel(f"residual [{view.display.unit}]")
    grid[0, 0].set_ylim(*_ends(view, found))
    legend_above(figure, _handles(view), 6)


def _ends(view: View, found: Mapping[str, Localisation]) -> tuple[float, float]:
    """Ends of the scale: it holds nearly all residuals, the bands and the floor."""
    floor, factor = 1.5 * view.diagnosis.noise_floor, view.display.factor
    every = np.concatenate([scored.held_out.residual for _, scored in view.models])
    curves = [c for part in found.values() for axis in part.axes for c in axis.curves.values()]
    low = min(-floor, np.percentile(every, 100.0 - SHOWN), *(_least(c.low) for c in curves))
    high = max(floor, np.percentile(every, SHOWN), *(-_least(-c.high) for c in curves))
    return 1.1 * factor * low, 1.1 * factor * high


def _least(values: Array) -> float:
    """Smallest of the finite values; 0 without any."""
    return float(np.min(values, where=np.isfinite(values), initial=0.0))


def _handles(view: View) -> list:
    words = {"before": "before" if view.after else "model", "after": "after"}
    models = [
        line_handle(label, words[label], marker="o", markersize=3) for label, _ in view.models
    ]
    outputs = view.data.outputs if len(view.data.outputs) > 1 else ()
    styles = [
        line_handle("other", name, linestyle=line)
        for name, line in zip(outputs, LINES, strict=False)
    ]
    return [*models, *styles, floor_handle()]


def _draw_floor(axes: Axes, view: View) -> None:
    floor = view.display.factor * view.diagnosis.noise_floor
    light_grid(axes)
    axes.axhspan(-floor, floor, color=COLOURS["floor"], alpha=0.16, linewidth=0)
    axes.axhline(0.0, color="#555555", linewidth=0.6)


def _scale(axes: Axes, bins: Bins) -> None:
    """Label of the axis; names of categories; a bent scale where few values lie far out."""
    axis, names = bins.axis, _names(bins)
    display = display_of(axis.unit)
    unit = f" [{display.unit}]" if display.unit else ""
    axes.set_xlabel(f"{axis_title(axis)}{unit}")
    if names:
        axes.set_xticks(range(len(names)), names)
        axes.set_xlim(-0.5, len(names) - 0.5)
        if sum(map(len, names)) > LONG_NAMES:
            for text in axes.get_xticklabels():
                text.set(rotation=20, horizontalalignment="right", rotation_mode="anchor")
        return
    values = abs(display.factor * axis.values[np.isfinite(axis.values)])
    usual = float(np.percentile(values, 75))
    if axis.name in ("pressure_rate", "time_since_step") and values.max() > SKEWED * usual > 0.0:
        axes.set_xscale("symlog", linthresh=usual)


def axis_title(axis: Axis) -> str:
    """What an axis is called where others stand beside it."""
    return f"direction of the {axis.noun}" if axis.name == "direction" else axis.noun


def _names(bins: Bins) -> tuple[str, ...]:
    """Names of the places of an axis with few values; none if it is drawn to scale."""
    if bins.axis.categories:
        return tuple(name.replace("_", " ") for name in bins.axis.categories)
    if bins.axis.of_run and bins.count <= FEW and np.all(bins.low == bins.high):
        display = display_of(bins.axis.unit)
        return tuple(display.number(value) for value in bins.center.tolist())
    return ()


def _places(bins: Bins, values: Array, index: IntArray) -> Array:
    """Where values of an axis are drawn; index: of their bins."""
    if _names(bins):
        return values if bins.axis.categories else index.astype(float)
    display = display_of(bins.axis.unit)
    return display.factor * values + display.offset


def _draw_dots(axes: Axes, view: View, bins: Bins, label: str, residual: Array) -> None:
    kept = thinned(len(residual), DOTS)
    kept = kept[bins.index[kept] >= 0]
    at = _places(bins, bins.axis.values[kept], bins.index[kept]) + _beside(view, bins, label)
    if _names(bins):  # dots of one place a little apart
        at = at + SPREAD * (np.modf(kept * 0.618)[0] - 0.5) * 0.8
    shown = view.display.factor * residual[kept]
    axes.plot(at, shown, ".", color=COLOURS[label], markersize=1.6, alpha=0.35, zorder=1.5)


def _beside(view: View, bins: Bins, label: str) -> float:
    """Both models stand side by side where there are few places."""
    if view.after is None or not _names(bins):
        return 0.0
    return 0.5 * SPREAD if label == "after" else -0.5 * SPREAD


def _draw_means(axes: Axes, view: View, dependence: Dependence, label: str) -> None:
    bins = dependence.bins
    at = _places(bins, bins.center, np.arange(bins.count)) + _beside(view, bins, label)
    factor, colour = view.display.factor, COLOURS[label]
    for curve, line in zip(dependence.curves.values(), LINES, strict=False):
        mean, low, high = factor * curve.mean, factor * curve.low, factor * curve.high
        if _names(bins):
            axes.vlines(at, low, high, color=colour, linewidth=2.5, alpha=0.45)
            axes.plot(at, mean, "o", color=colour, markersize=4)
        else:
            axes.fill_between(at, low, high, color=colour, alpha=0.22, linewidth=0)
            axes.plot(at, mean, linestyle=line, marker="o", color=colour, markersize=2.8)
