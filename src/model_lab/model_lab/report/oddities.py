"""What is odd about a set whatever the model, one panel for each notice."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from model_lab.fitting.notices import Notice
from model_lab.report.drawing import COLOURS, Drawing, light_grid, thinned
from model_lab.report.view import View

DOTS = 1500  # samples that are drawn beside those that stand out
TITLES = {
    "repeats": "Scatter of repeats",
    "line": "Share of the error at a frequency",
    "wild_samples": "Wild samples",
    "drift": "Mean error of each run",
    "held_input": "Input that is held until it jumps",
}
ABSCISSAS = {
    "line": "frequency [Hz]",
    "wild_samples": "sample",
    "drift": "run",
    "held_input": "time [s]",
}
SHARES = {"line": "share", "held_input": "share of the largest"}  # the others are errors
LEVELS = ("stated", "within runs", "with repeats")


def oddities(view: View) -> Drawing | None:
    """The figure; None where nothing is odd."""
    found = view.outcome.notices
    if not found:
        return None
    said = "; ".join(notice.text for notice in found)
    caption = f"{said[0].upper()}{said[1:]}. What stands out is drawn in orange."
    return Drawing(
        "oddities", "What is odd", caption, caption, 2.3 * len(found),
        lambda figure: _draw(figure, view),
    )  # fmt: skip


def _draw(figure: Figure, view: View) -> None:
    panels = figure.subplots(len(view.outcome.notices), squeeze=False)[:, 0]
    for axes, notice in zip(panels, view.outcome.notices, strict=True):
        light_grid(axes)
        axes.set_title(TITLES[notice.kind], loc="left")
        share = SHARES.get(notice.kind)
        _draw_points(axes, notice, notice.y if share else view.display.factor * notice.y)
        axes.set_ylabel(f"{share} [-]" if share else f"error [{view.display.unit}]")
        axes.set_xlabel(ABSCISSAS.get(notice.kind, ""))


def _draw_points(axes: Axes, notice: Notice, values: np.ndarray) -> None:
    if notice.kind == "repeats":
        axes.bar(LEVELS, values, color=[COLOURS["floor"], COLOURS["other"], COLOURS["before"]])
        return
    kept = thinned(len(values), DOTS)
    style = "-" if notice.kind in SHARES else "."
    axes.plot(notice.x[kept], values[kept], style, color=COLOURS["other"], markersize=3)
    axes.plot(notice.x[notice.marked], values[notice.marked], "o", color=COLOURS["before"])
