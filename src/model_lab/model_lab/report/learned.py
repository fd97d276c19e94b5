"""Report of a learned curve: one page with the curve, its band, and the error before and after."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from model_lab.aliases import Array
from model_lab.learning.learn import Candidate, Learning
from model_lab.learning.result import curve_points
from model_lab.learning.words import alternative_rows, curve_rows, verdict
from model_lab.localisation.axes import axes_of
from model_lab.measurements.units import display_of
from model_lab.report.drawing import COLOURS, WIDTH, Drawing, light_grid, styled, thinned

PAGE, PICTURE = "learned.html", "learned.png"
HEIGHT, DPI = 3.4, 130
DOTS = 3000  # residuals drawn
BINS = 30


def write_learned(learning: Learning, folder: Path, command: str) -> None:
    """Write the page and the picture of what was learned to a folder.

    command: the shell line that makes them again.
    """
    from model_lab.report.page import template

    drawing = picture_of(learning)
    chosen = learning.chosen
    text = template("learned.html").render(
        title=f"Learned: {learning.problem.data.title}",
        verdict=verdict(learning),
        drawing=drawing,
        curve=curve_rows(chosen) if chosen else [],
        alternatives=alternative_rows(learning),
        command=command,
    )
    (folder / PAGE).write_text(text, encoding="utf-8")
    with styled():
        drawing.figure().savefig(folder / PICTURE, dpi=DPI)


def picture_of(learning: Learning) -> Drawing:
    """The curve with its band, the residual before and after, and the candidates' errors."""
    chosen = learning.chosen
    caption = "Residual before in orange, after in blue, means in bins as lines; errors held out."
    if chosen is not None:
        caption = f"{chosen.shape.title} Band: 95 %. {caption}"

    def draw(figure: Figure) -> None:
        panels = figure.subplots(1, 3 if chosen else 2)
        if chosen is not None:
            draw_curve(panels[0], chosen)
        _draw_residuals(panels[-2], learning)
        _draw_errors(panels[-1], learning)

    return Drawing("learned", "Learned curve", caption, verdict(learning), HEIGHT, draw, WIDTH)


def draw_curve(axes: Axes, candidate: Candidate) -> None:
    """The curve with its band and knots."""
    shape, points = candidate.shape, curve_points(candidate)
    middle, low, high = (np.array([row[k] for row in points]) for k in (1, 2, 3))
    light_grid(axes, "both")
    if shape.names:
        at = np.arange(len(points))
        axes.errorbar(at, middle, [middle - low, high - middle], fmt="o", color=COLOURS["after"])
        axes.set_xticks(at, shape.names, rotation=30, ha="right")
    else:
        along, factor = _shown_along(shape.abscissa)
        course = factor * np.array([row[0] for row in points], float)
        axes.fill_between(course, low, high, color=COLOURS["after"], alpha=0.25, linewidth=0)
        axes.plot(course, middle, color=COLOURS["after"])
        knots = factor * np.array(shape.places, float)
        axes.plot(knots, candidate.values, "o", color=COLOURS["after"], markersize=3)
        axes.set_xlabel(along)
    if shape.neutral is not None:
        axes.axhline(shape.neutral, color=COLOURS["other"], linestyle="--", linewidth=0.8)
    axes.set_ylabel(shape.ordinate)
    axes.set_title("learned curve", loc="left")


def _shown_along(abscissa: str) -> tuple[str, float]:
    """An axis in the unit of the bench, and the factor to it."""
    noun, _, unit = abscissa.rpartition(" [")
    display = display_of(unit.rstrip("]").replace("-", ""))
    return f"{noun or abscissa} [{display.unit or '-'}]", display.factor


def _place(learning: Learning) -> tuple[Array, str]:
    """Where every sample lies on the axis of the curve, and what the axis is."""
    data = learning.problem.data
    chosen = learning.chosen
    against = chosen.shape.axis if chosen else "pressure"
    if against == "output":
        display = display_of(data.unit)
        name = data.outputs[0].replace("_", " ")
        return display.factor * data.table.value, f"{name} [{display.unit}]"
    axis = next((one for one in axes_of(data) if one.name == against), axes_of(data)[0])
    display = display_of(axis.unit)
    return display.factor * axis.values, f"{axis.noun} [{display.unit or '-'}]"


def _draw_residuals(axes: Axes, learning: Learning) -> None:
    """Held-out residuals before and after along the axis of the curve."""
    place, label = _place(learning)
    display = display_of(learning.problem.data.unit)
    some = thinned(len(place), DOTS)
    parts = [("before", learning.base)]
    if learning.chosen is not None:
        parts.append(("after", learning.chosen.scored))
    for name, scored in parts:
        rest = display.factor * scored.held_out.residual
        axes.plot(place[some], rest[some], ".", color=COLOURS[name], markersize=1.5, alpha=0.3)
    for name, scored in parts:
        at, mean = _means(place, display.factor * scored.held_out.residual)
        axes.plot(at, mean, color=COLOURS[name], linewidth=1.8)
    light_grid(axes)
    axes.set_xlabel(label)
    axes.set_ylabel(f"measured less predicted [{display.unit}]")
    axes.set_title("residual before and after", loc="left")


def _means(place: Array, rest: Array) -> tuple[Array, Array]:
    """Mean residual in bins along an axis."""
    known = np.isfinite(place)
    place, rest = place[known], rest[known]
    edges = np.unique(np.quantile(place, np.linspace(0.0, 1.0, BINS + 1)))
    where = np.clip(np.searchsorted(edges, place, side="right") - 1, 0, max(len(edges) - 2, 0))
    count = np.bincount(where)
    used = count > 0
    return (
        (np.bincount(where, place)[used] / count[used]),
        (np.bincount(where, rest)[used] / count[used]),
    )


def _draw_errors(axes: Axes, learning: Learning) -> None:
    """Held-out errors of the candidates as bars, the floor as a line."""
    factor = display_of(learning.problem.data.unit).factor
    every = [one for one in (learning.chosen, *learning.others) if one is not None]
    names = ["without"] + [
        f"{c.shape.stage} {c.shape.form}\n{c.shape.against.replace('_', ' ')}" for c in every
    ]
    errors = [learning.base.held_out.rmse, *(c.scored.held_out.rmse for c in every)]
    colours = [COLOURS["before"]] + [
        COLOURS["after" if c is learning.chosen else "tied" if learning.is_tied(c) else "other"]
        for c in every
    ]
    at = np.arange(len(names))[::-1]
    axes.barh(at, factor * np.array(errors), color=colours, height=0.65)
    axes.axvline(factor * learning.problem.floor.total, color=COLOURS["floor"])
    axes.set_yticks(at, names, fontsize=6.5)
    axes.set_xlabel(f"held-out error [{display_of(learning.problem.data.unit).unit}]")
    axes.set_title("floor green, tied pink", loc="left")
