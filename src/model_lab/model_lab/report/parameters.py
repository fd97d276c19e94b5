"""Fitted parameters with their intervals, and their correlation."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from model_lab.diagnosis.result import Estimate, correlation, estimate
from model_lab.report.drawing import COLOURS, Drawing
from model_lab.report.view import View

MOST = 14  # parameters in the figure: one factor a specimen may be many
ROW = 0.55  # [in]
STRONG = 0.9  # correlation that is worth a word


def parameter_estimates(view: View) -> dict[str, Estimate]:
    """Estimates of the calibration and of all effects of the best model, by name."""
    fitted = view.best.fit.likelihood.parameters
    return {entry.name: estimate(view.best, index) for index, entry in enumerate(fitted)}


def parameters(view: View) -> Drawing | None:
    """The figure, None for a model without a free parameter."""
    count = len(view.best.fit.values)
    if count == 0:
        return None
    shown = list(range(count))[-MOST:]  # those of effects come last
    names = [entry.name for entry in view.best.fit.likelihood.parameters]
    caption = (
        "Every fitted parameter with its 95 % interval; the grey bar is the range in which the "
        "parameter is usually found."
    )
    alt, height = f"Intervals of {', '.join(names[i] for i in shown)}", 0.5 + ROW * len(shown)
    if len(shown) > 1:
        caption += (
            " To the right the correlation of the estimates: a value near 1 or -1 means that the "
            f"data fix only a combination of the two. {_in_words(view, names)}"
        )
        alt, height = f"{alt}, and their correlation", max(height, 1.3 + 0.3 * len(shown))
    return Drawing(
        "parameters", "Parameters", caption, alt, height,
        lambda figure: _draw(figure, view, shown),
    )  # fmt: skip


def _in_words(view: View, names: list[str]) -> str:
    matrix = correlation(view.best)
    strong = [
        f"{names[i]} and {names[j]} ({matrix[i, j]:.2f})"
        for i in range(len(names))
        for j in range(i)
        if abs(matrix[i, j]) > STRONG
    ]
    return f"Hardly told apart here: {', '.join(strong[:4])}." if strong else ""


def _draw(figure: Figure, view: View, shown: list[int]) -> None:
    if len(shown) == 1:
        _draw_interval(figure.subplots(), view, shown[0])
        return
    left, right = figure.subfigures(1, 2, squeeze=False, width_ratios=(1.25, 1.0))[0]
    rows = left.subplots(len(shown), 1, squeeze=False)[:, 0]
    for axes, index in zip(rows, shown, strict=True):
        _draw_interval(axes, view, index)
    _draw_correlation(right.subplots(), view, shown)


def _draw_interval(axes: Axes, view: View, index: int) -> None:
    parameter = view.best.fit.likelihood.parameters[index]
    found = estimate(view.best, index)
    colour = COLOURS["other"] if parameter.effect is None else COLOURS["after"]
    axes.hlines(0.0, *parameter.typical, color="#DDDDDD", linewidth=9)
    axes.hlines(0.0, *found.interval, color=colour, linewidth=2.2)
    axes.plot(found.value, 0.0, "o", color=colour, markersize=5)
    if parameter.logarithmic:
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0), numticks=4))
        axes.xaxis.set_minor_formatter(NullFormatter())
    else:
        axes.xaxis.set_major_locator(MaxNLocator(5))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.4g}"))
    axes.set_yticks([])
    axes.set_ylim(-1.0, 1.0)
    axes.spines["left"].set_visible(False)
    unit = f" {parameter.unit}" if parameter.unit else ""
    low, high = found.interval
    text = f"{parameter.name} = {found.value:.4g}{unit}   [{low:.4g}, {high:.4g}]"
    axes.set_title(text, loc="left", pad=2)


def _draw_correlation(axes: Axes, view: View, shown: list[int]) -> None:
    matrix = correlation(view.best)[np.ix_(shown, shown)]
    names = [view.best.fit.likelihood.parameters[index].name for index in shown]
    short = [name.partition(".")[2] or name for name in names]
    axes.imshow(matrix, cmap="PuOr", vmin=-1.0, vmax=1.0)
    axes.set_xticks(range(len(short)), short, rotation=35, ha="right")
    axes.set_yticks(range(len(short)), short)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    for row, column in np.ndindex(*matrix.shape):
        value = matrix[row, column]
        colour = "white" if abs(value) > 0.6 else "#222222"
        axes.text(column, row, f"{value:.2f}", ha="center", va="center", color=colour, fontsize=7.5)
