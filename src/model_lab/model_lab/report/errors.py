"""Errors of models beside the noise floor: the ladder, the candidates, and the black boxes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from model_lab.report.drawing import COLOURS, Drawing, floor_handle, light_grid, line_handle
from model_lab.report.view import View

MOST_ROWS = 22  # candidates in the figure; the table beside it has all
ROW = 0.24  # [in]
FARTHEST = 1.5  # of the error before, where the scale ends


def ladder(view: View) -> Drawing:
    """Held-out error of the model as it was, and after each effect that was added."""
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
        caption += f"The model stands at {first / diagnosis.noise_floor:.3g} times the floor."
    steps = ", ".join(f"{step.label} {display.shown(step.rmse)}" for step in view.steps)
    alt = f"Held-out errors: {steps}; noise floor {display.shown(diagnosis.noise_floor)}"
    return Drawing(
        "ladder", "Ladder of errors", caption, alt, 0.95 + 0.36 * len(view.steps),
        lambda figure: draw_ladder(figure.subplots(), view),
    )  # fmt: skip


def draw_ladder(axes: Axes, view: View) -> None:
    """Bars from above to below, the last one in the colour of the model after."""
    factor = view.display.factor
    places = np.arange(len(view.steps))
    last = len(view.steps) - 1
    mixed = [COLOURS["before"], *[COLOURS["other"]] * (last - 1), COLOURS["after"]]
    colours = mixed if last else [COLOURS["before"]]
    lengths = [factor * step.rmse for step in view.steps]
    axes.barh(places, lengths, height=0.62, color=colours)
    for place, length, step in zip(places, lengths, view.steps, strict=True):
        text = view.display.shown(step.rmse)
        end = max(length, factor * view.outcome.problem.floor.upper)  # clear of the strip
        axes.annotate(text, (end, place), (4, 0), textcoords="offset points", va="center")
    _floor(axes, view)
    axes.set_yticks(places, [step.label for step in view.steps])
    axes.set_ylim(last + 0.6, -0.6)
    axes.set_xlim(0.0, 1.2 * max(lengths))
    axes.set_xlabel(f"held-out error (rms) [{view.display.unit}]")
    axes.spines["left"].set_visible(False)
    axes.tick_params(left=False)


def _floor(axes: Axes, view: View) -> None:
    """The noise floor, from its value to its upper bound."""
    factor, floor = view.display.factor, view.outcome.problem.floor
    light_grid(axes, "x")
    axes.axvspan(
        factor * floor.total, factor * floor.upper, color=COLOURS["floor"], alpha=0.25, lw=0
    )
    axes.axvline(factor * floor.total, color=COLOURS["floor"], linewidth=1.4)


@dataclass(frozen=True)
class Row:
    """A row of a chart of dots: colour by label, open for what is not plausible."""

    name: str
    rmse: float
    label: str
    filled: bool = True


def ranking(view: View) -> Drawing | None:
    """Held-out error with every effect alone; None when none was tried."""
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
    return Drawing(
        "ranking", "Ranking of effects", caption, alt, 1.0 + ROW * len(shown),
        lambda figure: _draw_ranking(figure, view, shown),
    )  # fmt: skip


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


def _draw_ranking(figure: Figure, view: View, rows: Sequence[Row]) -> None:
    axes = figure.subplots()
    draw_ranking(axes, view, rows)
    _ranking_legend(axes, rows)


def draw_ranking(axes: Axes, view: View, rows: Sequence[Row] | None = None) -> None:
    """A dot a row on the scale of errors, the best rows if none are given."""
    rows = _candidates(view)[:MOST_ROWS] if rows is None else rows
    _dots(axes, view, rows, view.before.held_out.rmse)


def _ranking_legend(axes: Axes, rows: Sequence[Row]) -> None:
    labels = {row.label for row in rows}
    handles: list[Artist] = [
        line_handle(label, text, linestyle="", marker="o", markersize=5)
        for label, text in (("after", "named"), ("tied", "tied with it"), ("other", "others"))
        if label in labels
    ]
    handles += [line_handle("before", "error before", linestyle="--"), floor_handle()]
    axes.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=5)


def _dots(axes: Axes, view: View, rows: Sequence[Row], before: float) -> None:
    factor, most = view.display.factor, _end_of_scale(rows, before)
    _floor(axes, view)
    axes.axvline(factor * before, color=COLOURS["before"], linestyle="--", linewidth=1.2)
    for place, row in enumerate(rows):
        colour, end = COLOURS[row.label], factor * min(row.rmse, most)
        axes.hlines(place, 0.0, end, color=colour, linewidth=0.8, alpha=0.6)
        marker = "o" if row.rmse <= most else ">"
        inside = colour if row.filled else "white"
        axes.plot(end, place, marker, color=colour, markerfacecolor=inside, markersize=5)
        if row.rmse > most:
            text = view.display.shown(row.rmse)
            axes.annotate(text, (end, place), (6, 0), textcoords="offset points", va="center")
    axes.set_yticks(range(len(rows)), [row.name for row in rows])
    for row, label in zip(rows, axes.get_yticklabels(), strict=True):
        if row.label != "other":
            label.set_color(COLOURS[row.label])
            label.set_fontweight("bold")
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_xlim(0.0, 1.1 * factor * most)
    axes.set_xlabel(f"held-out error (rms) [{view.display.unit}]")
    axes.spines["left"].set_visible(False)
    axes.tick_params(left=False)


def _end_of_scale(rows: Sequence[Row], before: float) -> float:
    """Largest error on the scale: some candidates fail wildly on what they have not seen."""
    return min(max(before, *(row.rmse for row in rows)), FARTHEST * before)


def rest(view: View) -> Drawing | None:
    """Held-out error of black boxes on top of the last model; None when none could be tried."""
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
    return Drawing(
        "rest", "What the rest depends on", caption, alt, 1.0 + ROW * len(rows),
        lambda figure: _draw_rest(figure, view, rows, final),
    )  # fmt: skip


def _draw_rest(figure: Figure, view: View, rows: Sequence[Row], final: float) -> None:
    axes = figure.subplots()
    _dots(axes, view, rows, final)
    axes.legend(
        handles=[line_handle("before", "model without black box", linestyle="--"), floor_handle()],
        loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2,
    )  # fmt: skip
