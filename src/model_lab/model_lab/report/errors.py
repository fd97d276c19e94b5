"""Errors of models beside the noise floor: the ladder, the candidates, and the black boxes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model_lab.report.drawing import FLOOR_KEY, Drawing, Key, Panel, Scale
from model_lab.report.marks import Bars, Mark, Points, Strip
from model_lab.report.view import View

MOST_ROWS = 22  # candidates in the figure; the table beside it has all
CANDIDATE_HEIGHT = 0.31  # [in] of a candidate
RUNG_HEIGHT = 0.46  # [in] of a rung of the ladder
FRAME_HEIGHT = 0.83  # [in] above and below the rows
LARGEST_SHARE_SHOWN = 1.5  # of the error before, where the scale ends


def ladder(view: View) -> Drawing:
    """Figure of the held-out error of the model as it was, and after each added effect."""
    diagnosis, display = view.diagnosis, view.display
    first, last = view.steps[0].rmse, view.steps[-1].rmse
    caption = (
        "Root mean square error on held-out data. The line is the noise floor, below which no "
        "model can go, the strip reaches to its 95 % bound. "
    )
    if view.after is not None:
        caption += (
            f"The error falls {first / last:.3g}-fold, from {display.shown(first)} to "
            f"{display.shown(last)}; the floor is {display.shown(diagnosis.noise_floor)}."
        )
    else:
        caption += f"The error of the model is {first / diagnosis.noise_floor:.3g} times the floor."
    steps = ", ".join(f"{step.label} {display.shown(step.rmse)}" for step in view.steps)
    alt = f"Held-out errors: {steps}; noise floor {display.shown(diagnosis.noise_floor)}"
    return Drawing("ladder", "Ladder of errors", caption, alt, (ladder_panel(view),), (FLOOR_KEY,))


def ladder_panel(view: View) -> Panel:
    """Panel with one bar per model, from top to bottom, the last one in the colour of the model
    after.
    """
    factor, last = view.display.factor, len(view.steps) - 1
    lengths = [factor * step.rmse for step in view.steps]
    colours = ["before", *["other"] * (last - 1), "after"] if last else ["before"]
    texts = [view.display.shown(step.rmse) for step in view.steps]
    clear = np.maximum(lengths, factor * view.outcome.problem.floor.upper)
    places = np.arange(last + 1.0)
    marks = (*_floor(view), Bars(lengths, colours), Points(clear, places, "before", texts=texts))
    names = tuple((float(at), step.label) for at, step in enumerate(view.steps))
    return Panel(
        marks,
        _error_scale(view, 1.2 * max(lengths)),
        Scale("", (last + 0.6, -0.6), ticks=names),
        height=FRAME_HEIGHT + RUNG_HEIGHT * len(lengths),
    )


def _error_scale(view: View, end: float) -> Scale:
    return Scale(f"held-out error [{view.display.unit}]", (0.0, end))


def _floor(view: View) -> tuple[Mark, ...]:
    """The noise floor, and from its value to its upper bound."""
    factor, floor = view.display.factor, view.outcome.problem.floor
    low, high = factor * floor.total, factor * floor.upper
    return Strip(low, high, "floor"), Strip(low, low, "floor")


@dataclass(frozen=True)
class Row:
    """A row of a chart with dots. label: what its colour means. filled: False for what is not
    plausible.
    """

    name: str
    rmse: float
    label: str
    filled: bool = True


def ranking(view: View) -> Drawing | None:
    """Figure of the held-out error with each effect alone; None if none was tried."""
    rows = _candidates(view)
    if not rows:
        return None
    shown = rows[:MOST_ROWS]
    more = f" {len(rows) - len(shown)} more are in the table." if len(rows) > len(shown) else ""
    caption = (
        "Held-out error when one effect alone is added and everything is fitted again. Filled: its "
        "parameters are plausible; open: one lies on its limit, or none is known. The dashed line "
        "is the error without any; what explains the data comes down to the green strip. With "
        f"several effects missing no single one does.{more}"
    )
    alt = "Best first: " + ", ".join(
        f"{row.name} {view.display.shown(row.rmse)}" for row in shown[:5]
    )
    labels = {row.label for row in rows}
    words = (("after", "named"), ("tied", "tied with it"), ("other", "others"))
    keys = [Key(text, label, "o") for label, text in words if label in labels]
    keys += [Key("error before", "before", "dash"), FLOOR_KEY]
    return Drawing(
        "ranking", "Ranking of effects", caption, alt, (ranking_panel(view, shown),), tuple(keys)
    )


def _candidates(view: View) -> list[Row]:
    named = {effect.name for effect in view.diagnosis.effects}
    tied = {name for names in view.diagnosis.tied for name in names}
    rows = [
        Row(
            entry.name,
            entry.rmse_heldout,
            "after" if entry.name in named else "tied" if entry.name in tied else "other",
            entry.plausible,
        )
        for entry in view.diagnosis.ranking
    ]
    return sorted(rows, key=lambda row: row.rmse)


def ranking_panel(view: View, rows: Sequence[Row] | None = None) -> Panel:
    """Panel with one dot per row over the error. rows: None: the best effects."""
    rows = _candidates(view)[:MOST_ROWS] if rows is None else rows
    return _dots(view, rows, view.before.held_out.rmse)


def _dots(view: View, rows: Sequence[Row], before: float) -> Panel:
    factor = view.display.factor
    end = factor * _end_of_scale(rows, before)
    marks = [*_floor(view), Strip(factor * before, factor * before, "before", dash="dash")]
    for place, row in enumerate(rows):
        marks += _dot(float(place), row, factor * row.rmse, end, view.display.shown(row.rmse))
    names = tuple((float(at), row.name) for at, row in enumerate(rows))
    strong = tuple((row.name, row.label) for row in rows if row.label != "other")
    scale = Scale("", (len(rows) - 0.4, -0.6), ticks=names, strong=strong)
    height = FRAME_HEIGHT + CANDIDATE_HEIGHT * len(rows)
    return Panel(tuple(marks), _error_scale(view, 1.1 * end), scale, height=height)


def _dot(place: float, row: Row, error: float, end: float, text: str) -> list[Mark]:
    """A line from zero to a dot, or to an arrow with the error beyond the end of the scale."""
    at = min(error, end)
    y = np.array([place])
    found: list[Mark] = [
        Points(np.array([0.0, at]), np.array([place, place]), row.label, width=0.8, opacity=0.6),
        Points(
            np.array([at]), y, row.label, row.name,
            marker="o" if error <= end else ">", size=5.0, hollow=not row.filled,
        ),
    ]  # fmt: skip
    return [*found, Points(np.array([at]), y, row.label, texts=(text,))] if error > end else found


def _end_of_scale(rows: Sequence[Row], before: float) -> float:
    """Largest error on the scale: some candidates fail wildly on what they have not seen."""
    return min(max(before, *(row.rmse for row in rows)), LARGEST_SHARE_SHOWN * before)


def rest(view: View) -> Drawing | None:
    """Figure of the held-out error with black boxes added to the last model; None if there are
    none.
    """
    black_boxes = view.outcome.black_boxes
    if not black_boxes:
        return None
    final = view.outcome.selection.final.held_out.rmse
    against = view.diagnosis.unexplained.against
    rows = [
        Row(
            black_box.name.replace("_", " "),
            black_box.rmse,
            "tied" if black_box.against in against else "other",
        )
        for black_box in black_boxes
    ]
    caption = (
        "Held-out error when a black box (a flexible curve without physics) of one kind of input "
        "may correct the model. A dot well left of the dashed line says that the rest depends on "
        "that input; one right of it, that the black box only learned noise."
    )
    alt = "Best first: " + ", ".join(f"{r.name} {view.display.shown(r.rmse)}" for r in rows[:3])
    keys = (Key("model without black box", "before", "dash"), FLOOR_KEY)
    return Drawing(
        "rest", "What the rest depends on", caption, alt, (_dots(view, rows, final),), keys
    )
