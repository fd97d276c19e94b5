"""Figure of the fitted parameters with their intervals, and of their correlation."""

from __future__ import annotations

import numpy as np

from model_lab.diagnosis.result import Estimate, correlation, estimate
from model_lab.report.drawing import Drawing, Panel, Scale
from model_lab.report.marks import Points
from model_lab.report.view import View

SHOWN_PARAMETERS = 14  # parameters in the figure: one factor a specimen may be many
INTERVAL_HEIGHT = 0.62  # [in]
STRONG_CORRELATION = 0.9  # correlation that is worth a word


def parameter_estimates(view: View) -> dict[str, Estimate]:
    """Estimates of the calibration and of all effects of the best model, by name."""
    fitted = view.best.fit.likelihood.parameters
    return {entry.name: estimate(view.best, index) for index, entry in enumerate(fitted)}


def parameters(view: View) -> Drawing | None:
    """The figure; None for a model without a free parameter."""
    shown = range(len(view.best.fit.values))[-SHOWN_PARAMETERS:]  # those of effects come last
    if not shown:
        return None
    names = [entry.name for entry in view.best.fit.likelihood.parameters]
    caption = (
        "Every fitted parameter with its 95 % interval; the grey bar is the range in which the "
        f"parameter is usually found.{_in_words(view, names)}"
    )
    alt = f"Intervals of {', '.join(names[index] for index in shown)}"
    panels = tuple(_interval(view, index) for index in shown)
    return Drawing("parameters", "Parameters", caption, alt, panels)


def _in_words(view: View, names: list[str]) -> str:
    matrix = correlation(view.best)
    strong = [
        f"{names[i]} and {names[j]} ({matrix[i, j]:.2f})"
        for i in range(len(names))
        for j in range(i)
        if abs(matrix[i, j]) > STRONG_CORRELATION
    ]
    return f" Hardly told apart here: {', '.join(strong[:4])}." if strong else ""


def _interval(view: View, index: int) -> Panel:
    parameter = view.best.fit.likelihood.parameters[index]
    found = estimate(view.best, index)
    colour = "other" if parameter.effect is None else "after"
    level = np.zeros(2)
    marks = (
        Points(np.array(parameter.typical), level, "range", width=9.0),
        Points(np.array(found.interval), level, colour, width=2.2),
        Points(np.array([found.value]), level[:1], colour, marker="o", size=5.0),
    )
    unit = f" {parameter.unit}" if parameter.unit else ""
    low, high = found.interval
    title = f"{parameter.name} = {found.value:.4g}{unit}   [{low:.4g}, {high:.4g}]"
    x, y = Scale(logarithmic=parameter.logarithmic), Scale("", (-1.0, 1.0), hidden=True)
    return Panel(marks, x, y, title, INTERVAL_HEIGHT)
