"""The next experiment, as a course to drive."""

from __future__ import annotations

from matplotlib.figure import Figure

from model_lab.display import display_of
from model_lab.report.drawing import COLOURS, Drawing, light_grid
from model_lab.report.view import View


def proposal(view: View) -> Drawing | None:
    """Course of the input in the proposed experiment; None when none is proposed, or pulses."""
    planned = view.diagnosis.next_experiment
    if planned is None or planned["duration"] is None:
        return None
    kelvin = display_of("K").shown(planned["temperature"])
    mount = str(planned["mount"]).replace("_", " ")
    caption = (
        f"{str(planned['description']).capitalize()}, within {planned['duration']:.3g} s, with "
        f"specimen {planned['specimen']} at {kelvin}, mounted {mount}. In it the explanations that "
        f"are still tied differ by {planned['separation']:.3g} sigma of the noise of a run."
    )
    return Drawing(
        "next", "Next experiment", caption, f"Course of the input: {planned['description']}", 2.3,
        lambda figure: _draw(figure, view),
    )  # fmt: skip


def _draw(figure: Figure, view: View) -> None:
    planned = view.diagnosis.next_experiment or {}
    inputs = planned["inputs"]
    name = "stretch" if "stretch" in inputs else "pressure"
    display = display_of("" if name == "stretch" else "Pa")
    axes = figure.subplots()
    light_grid(axes)
    shown = [display.factor * value for value in inputs[name]]
    axes.plot(inputs["time"], shown, color=COLOURS["after"], linewidth=1.6)
    axes.set_xlabel("time [s]")
    axes.set_ylabel(f"{name} [{display.unit or '-'}]")
