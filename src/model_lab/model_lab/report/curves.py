"""Measured and predicted curves of every run, before and after effects are added: small panels with
the same scales.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from model_lab.aliases import Array
from model_lab.measurements.sample_table import Series
from model_lab.report.drawing import Drawing, Key, Panel, Scale
from model_lab.report.marks import LINE_POINTS, Mark, Points, evenly
from model_lab.report.view import Repeats, View

CURVE_PANELS = 36
CURVE_DOTS, POINTS = 2000, 18_000  # of all measured curves, of all lines
SCALE_MARGIN = 0.04  # of a scale


def curves(view: View) -> Drawing:
    """The figure of all runs; of very many runs, a selection spread evenly over the set."""
    every = view.panels()
    shown = [every[index] for index in evenly(len(every), CURVE_PANELS)]
    name = view.abscissa()[0]
    part = "" if len(shown) == len(every) else f" {len(shown)} of {len(every)} panels are shown."
    pulses = view.data.experiment == "valve_pulse"
    marks, hits = (
        ("crosses", "they meet") if pulses else ("lines", "its line runs through the dots")
    )
    caption = (
        f"Dots are measured ({view.output_name} over {name}; "
        f"repeats lie in one panel), {marks} are predicted by parameters that were fitted to the "
        f"other {view.diagnosis.holdout}: {_legend(view)}. "
        f"A model is right where {hits}.{part}"
    )
    alt = f"Measured and predicted curves in {len(shown)} panels"
    panels, keys = tuple(panels_of(view, shown)), tuple(curve_keys(view))
    return Drawing("curves", "Measured and predicted", caption, alt, panels, keys)


def _legend(view: View) -> str:
    if view.after is None:
        return "orange the model"
    return "orange before, blue with the missing effects"


def panels_of(view: View, shown: Sequence[Repeats]) -> Iterator[Panel]:
    """A panel for each group of repeats, all with the same scales."""
    name, display, abscissa = view.abscissa()
    courses = [course for repeats in shown for course in repeats.courses]
    each = [max(total // len(courses), 8) for total in (CURVE_DOTS, POINTS // len(view.models))]
    across = {course: display.factor * abscissa[course.run] for course in courses}
    marks = {course: tuple(_marks(view, course, across[course], *each)) for course in courses}
    heights = [mark.y for each in marks.values() for mark in each]
    x = Scale(f"{name} [{display.unit}]", _ends(list(across.values())))
    y = Scale(f"{view.output_name} [{view.display.unit}]", _ends(heights))
    for repeats in shown:
        found: list[Mark] = [mark for course in repeats.courses for mark in marks[course]]
        yield Panel(tuple(found), x, y, repeats.title)


def _ends(values: Sequence[Array]) -> tuple[float, float]:
    every = np.concatenate(values)
    low, high = float(every.min()), float(every.max())
    margin = SCALE_MARGIN * ((high - low) or abs(high) or 1.0)
    return low - margin, high + margin


def _marks(view: View, course: Series, at: Array, dots: int, points: int) -> Iterator[Points]:
    factor = view.display.factor
    measured = factor * view.measured[course.samples]
    name = view.data.runs[course.run].name
    yield Points(at, measured, "measured", name, marker="o", size=2.6, opacity=0.4, most=dots)
    for label, scored in view.models:
        line = factor * view.predicted(scored)[course.samples]
        look = _look(view, label)
        if look in ("x", "+"):
            yield Points(at, line, label, label, marker=look, size=4.5, most=dots)
        else:
            most = min(points, LINE_POINTS)
            yield Points(at, line, label, label, width=1.1, dash=look, most=most)


def _look(view: View, label: str) -> str:
    """Dashes tell lines apart without colours, but not where a line runs over itself."""
    if view.data.experiment == "valve_pulse":
        return "x" if label == "before" else "+"
    return "dash" if view.abscissa()[0] == "time" and label == "before" else "solid"


def curve_keys(view: View) -> Iterator[Key]:
    """The entries of the legend."""
    after = "with " + " and ".join(effect.name for effect in view.diagnosis.effects)
    words = {"before": "model as it was" if view.after else "model", "after": after}
    yield Key("measured", "measured", "o")
    for label, _ in view.models:
        yield Key(words[label], label, _look(view, label))
