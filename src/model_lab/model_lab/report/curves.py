"""Measured and predicted curves of every run, before and after: small multiples of one scale."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from model_lab.aliases import Array
from model_lab.measurements.sample_table import Series
from model_lab.report.drawing import (
    COLOURS,
    Drawing,
    by_rows,
    legend_above,
    light_grid,
    line_handle,
    thinned,
)
from model_lab.report.view import Panel, View

MOST_PANELS = 36
SHAPES = (
    (9, 3, 2.1),
    (16, 4, 1.75),
    (MOST_PANELS, 6, 1.45),
)  # panels, columns, height of a row [in]
DOTS = 60  # of a measured curve
TITLES = {4: 7.5, 6: 6.5}  # [pt] by columns, where there are many
LETTERS = 150  # of all titles of a row
DASHED = (0, (4, 1.5))


def curves(view: View) -> Drawing:
    """The figure of all runs, or of as many as can be told apart, spread evenly over the set."""
    panels = view.panels()
    shown = [panels[index] for index in thinned(len(panels), MOST_PANELS)]
    name = view.abscissa()[0]
    part = "" if len(shown) == len(panels) else f" {len(shown)} of {len(panels)} panels are shown."
    pulses = view.data.experiment == "valve_pulse"
    marks, hits = (
        ("crosses", "they meet") if pulses else ("lines", "its line runs through the dots")
    )
    caption = (
        f"Dots are measured ({_output_name(view)} over {name}; "
        f"repeats lie in one panel), {marks} are predicted by parameters that were fitted to the "
        f"other {view.diagnosis.holdout}: {_legend(view)}. "
        f"A model is right where {hits}.{part}"
    )
    columns, height = next((c, h) for most, c, h in SHAPES if len(shown) <= most)
    columns = min(columns, len(shown))
    rows = -(-len(shown) // columns)
    alt = f"Measured and predicted curves in {len(shown)} panels"
    return Drawing(
        "curves", "Measured and predicted", caption, alt, 0.75 + height * rows,
        lambda figure: draw_panels(figure, view, shown, columns),
    )  # fmt: skip


def _legend(view: View) -> str:
    if view.after is None:
        return "orange the model"
    return "orange before, blue with the missing effects"


def draw_panels(figure: Figure, view: View, panels: Sequence[Panel], columns: int) -> None:
    """Panels in a grid with shared axes and one legend above."""
    rows = -(-len(panels) // columns)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    name, display, abscissa = view.abscissa()
    for axes, panel in zip(grid.flat, panels, strict=False):
        light_grid(axes)
        for course in panel.courses:
            _draw_course(axes, view, course, display.factor * abscissa[course.run])
        axes.set_title(
            _short(panel.title, columns), loc="left", pad=3, fontsize=TITLES.get(columns)
        )
    by_rows(grid.flat, len(panels), columns)
    figure.supxlabel(f"{name} [{display.unit}]", fontsize=8.5)
    figure.supylabel(f"{_output_name(view)} [{view.display.unit}]", fontsize=8.5)
    legend_above(figure, _handles(view), 3)


def _short(title: str, columns: int) -> str:
    """As much of a title as a panel has room for."""
    room = LETTERS // columns
    return title if len(title) <= room else f"{title[: room - 1]}…"


def _output_name(view: View) -> str:
    outputs = view.data.outputs
    return outputs[0].replace("_", " ") if len(outputs) == 1 else "torque on the base"


def _draw_course(axes: Axes, view: View, course: Series, at: Array) -> None:
    factor = view.display.factor
    measured = factor * view.measured[course.samples]
    dots = thinned(len(at), DOTS)
    axes.plot(
        at[dots],
        measured[dots],
        "o",
        color=COLOURS["measured"],
        markersize=2.6,
        alpha=0.35,
        markeredgewidth=0,
    )
    kept = dots if view.data.experiment == "valve_pulse" else thinned(len(at))
    for label, scored in view.models:
        line = factor * view.predicted(scored)[course.samples][kept]
        axes.plot(at[kept], line, color=COLOURS[label], **_style(view, label))


def _style(view: View, label: str) -> dict[str, Any]:
    """Dashes tell lines apart without colours, but not where a line runs over itself."""
    if view.data.experiment == "valve_pulse":
        return {"linestyle": "", "marker": "x" if label == "before" else "+", "markersize": 4.5}
    over_time = view.abscissa()[0] == "time"
    dashed = over_time and label == "before"
    return {"linewidth": 1.1, "linestyle": DASHED if dashed else "-"}


def _handles(view: View) -> list[Line2D]:
    words = {"before": "model as it was" if view.after else "model", "after": _after_label(view)}
    return [
        line_handle("measured", "measured", linestyle="", marker="o", markersize=3, alpha=0.6),
        *(line_handle(label, words[label], **_style(view, label)) for label, _ in view.models),
    ]


def _after_label(view: View) -> str:
    return "with " + " and ".join(effect.name for effect in view.diagnosis.effects)
