"""Figure of a learned curve: the curve with its band, and the error before and after."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from model_lab.aliases import Array
from model_lab.learning.learn import Candidate, Learning
from model_lab.learning.result import curve_points
from model_lab.learning.words import verdict
from model_lab.localisation.axes import axes_of
from model_lab.measurements.units import display_of
from model_lab.report.drawing import Drawing, Key, Panel, Scale
from model_lab.report.marks import Band, Bars, Mark, Points, Strip
from model_lab.report.residuals import bars_of_error

LEARNED_DOTS = 3000  # residuals that are drawn
MEAN_BINS = 30
LEARNED_KEYS = (
    Key("before, without the curve", "before"),
    Key("after, with the curve", "after"),
    Key("noise floor", "floor"),
    Key("tied with it", "tied", "strip"),
    Key("others", "other", "strip"),
)


def picture_of(learning: Learning) -> Drawing:
    """Figure of a learned curve with its band, of the residual before and after, and of the errors
    with other candidates.
    """
    chosen = learning.chosen
    caption = (
        "Residuals are measured minus predicted; dots are samples, lines are means over parts of "
        "the "
        "axis. All errors are root mean squares on held-out data."
    )
    panels = (_residual_panel(learning), _error_panel(learning))
    if chosen is None:
        return Drawing(
            "learned", "Residuals and errors", caption, verdict(learning), panels, LEARNED_KEYS[::2]
        )
    titles = " ".join(one.shape.title for one in learning.curves)
    caption = f"{titles} The band holds 95 %. {caption}"
    curves = [curve_panel(one) for one in learning.curves]
    return Drawing(
        "learned", "Learned curve", caption, verdict(learning), (*curves, *panels), LEARNED_KEYS
    )


def curve_panel(candidate: Candidate) -> Panel:
    """Panel of the curve with its band and knots."""
    shape, points = candidate.shape, curve_points(candidate)
    middle, low, high = (np.array([row[k] for row in points]) for k in (1, 2, 3))
    marks: list[Mark] = []
    if shape.neutral is not None:
        marks.append(Strip(shape.neutral, shape.neutral, "other", "y", width=0.8, dash="dash"))
    if shape.names:
        at = np.arange(float(len(points)))
        marks += [bars_of_error(at, low, high, "after"), Points(at, middle, "after", marker="o")]
        ticks = tuple((float(place), name) for place, name in enumerate(shape.names))
        x = Scale(shape.abscissa, (-0.5, len(points) - 0.5), ticks=ticks)
    else:
        along, factor = _shown_along(shape.abscissa)
        course = factor * np.array([row[0] for row in points], float)
        knots = factor * np.array(shape.places, float)
        marks += [
            Band(course, low, high, "after"),
            Points(course, middle, "after", width=1.4),
            Points(knots, candidate.values, "after", marker="o", size=3.0),
        ]
        x = Scale(along)
    return Panel(tuple(marks), x, Scale(shape.ordinate), "Learned curve")


def _shown_along(abscissa: str) -> tuple[str, float]:
    """Label of an axis in the unit that people read, and the factor from SI units to it."""
    noun, _, unit = abscissa.rpartition(" [")
    display = display_of(unit.rstrip("]").replace("-", ""))
    return f"{noun or abscissa} [{display.unit or '-'}]", display.factor


def _place(learning: Learning) -> tuple[Array, str]:
    """Where every sample lies on the axis of the curve, and what the axis is."""
    data = learning.problem.data
    chosen = learning.chosen
    against = chosen.shape.axis if chosen else "pressure"
    if against == "output":
        display = data.output_display
        name = data.outputs[0].replace("_", " ")
        return display.factor * data.table.value, f"{name} [{display.unit}]"
    axis = next((one for one in axes_of(data) if one.name == against), axes_of(data)[0])
    display = axis.display
    return display.factor * axis.values + display.offset, f"{axis.noun} [{display.unit or '-'}]"


def _residual_panel(learning: Learning) -> Panel:
    """Held-out residuals before and after along the axis of the curve."""
    unit = learning.problem.data.output_display.unit
    label = _place(learning)[1]
    y = Scale(f"residual [{unit}]")
    return Panel(tuple(_residuals(learning)), Scale(label), y, "Residual before and after")


def _residuals(learning: Learning) -> Iterator[Points]:
    place, _ = _place(learning)
    factor = learning.problem.data.output_display.factor
    parts = [("before", learning.base)]
    if learning.chosen is not None:
        parts.append(("after", learning.final))
    for label, scored in parts:
        rest = factor * scored.held_out.residual
        yield Points(place, rest, label, marker="o", size=1.3, opacity=0.3, most=LEARNED_DOTS)
    for label, scored in parts:
        at, mean = _means(place, factor * scored.held_out.residual)
        yield Points(at, mean, label, label, width=1.8)


def _means(place: Array, rest: Array) -> tuple[Array, Array]:
    """Mean residual in bins along an axis."""
    known = np.isfinite(place)
    place, rest = place[known], rest[known]
    edges = np.unique(np.quantile(place, np.linspace(0.0, 1.0, MEAN_BINS + 1)))
    where = np.clip(np.searchsorted(edges, place, side="right") - 1, 0, max(len(edges) - 2, 0))
    count = np.bincount(where)
    used = count > 0
    return (
        (np.bincount(where, place)[used] / count[used]),
        (np.bincount(where, rest)[used] / count[used]),
    )


def _error_panel(learning: Learning) -> Panel:
    """Held-out errors of the candidates as bars, the floor as a line."""
    display = learning.problem.data.output_display
    chosen = [learning.chosen, *learning.further] if learning.chosen else []
    every = [*chosen, *learning.others]
    shapes = [one.shape for one in every]
    names = ["without", *(f"{s.stage} {s.form}, {s.against.replace('_', ' ')}" for s in shapes)]
    names[2 : len(chosen) + 1] = [f"+ {name}" for name in names[2 : len(chosen) + 1]]
    errors = [learning.base.held_out.rmse, *(one.scored.held_out.rmse for one in every)]
    colours = ["before"] + [
        "after" if one in chosen else "tied" if learning.is_tied(one) else "other" for one in every
    ]
    floor = display.factor * learning.problem.floor.total
    ticks = tuple((float(at), name) for at, name in enumerate(names))
    marks = (Bars([display.factor * e for e in errors], colours), Strip(floor, floor, "floor"))
    scale = Scale("", (len(names) - 0.4, -0.6), ticks=ticks)
    return Panel(marks, Scale(f"held-out error [{display.unit}]"), scale, "Error by candidate")
