"""The picture of the pushes: over lines of equal air mass as in Figs 4.1 and 4.2, and over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from softhand_model.gas import AMBIENT_PRESSURE, GAS_CONSTANT, ROOM_TEMPERATURE
from thesis.equilibrium_point.course import Course

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
COLOURS = {"mass": "tab:purple", "pressure": "tab:orange", "volume": "tab:blue"}
LABELS = ("gauge pressure [kPa]", "[kPa]", "volume\n[cm3]", "air, estimated\n[mg]", "force\n[N]")
AIR, AIR_SPAN = 2, 6.0  # row of the air mass, and what it shows to both sides [mg]
LINE_SPACING = 1e-6  # of the lines of equal air mass [kg]


def draw(courses: Sequence[Course], target: Path) -> None:
    """Draw the pushes of one session into a PNG file."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.5, 8.5), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(
        5, len(courses), sharey="row", squeeze=False, height_ratios=(5, 2, 2, 2, 2)
    )
    for column, course in enumerate(courses):
        _draw_plane(panels[0, column], course)
        _draw_course(list(panels[1:, column]), course)
    for panel in panels[0]:
        panel.set_xlim(*_span(np.concatenate([1e6 * course.volume for course in courses])))
        _draw_lines(panel)
    for panel, label in zip(panels[:, 0], LABELS, strict=True):
        panel.set_ylabel(label)
    figure.supxlabel("grey: pressed; dotted: a valve opens", fontsize=9)
    figure.savefig(target, dpi=110)


def _span(values: Array) -> tuple[float, float]:
    margin = 0.08 * float(np.ptp(values))
    return float(values.min()) - margin, float(values.max()) + margin


def _draw_plane(panel: Axes, course: Course) -> None:
    colour = COLOURS[course.push.mode]
    volume, pressure = 1e6 * course.volume, 1e-3 * course.pressure
    panel.plot(volume, pressure, color=colour, linewidth=0.6, alpha=0.5)
    for word, look in (("free", course.before), ("pressed", course.pressed)):
        place = (1e6 * look(course.volume), 1e-3 * look(course.pressure))
        panel.plot(*place, "o", color=colour, markersize=6)
        panel.annotate(word, place, textcoords="offset points", xytext=(6, 4), fontsize=9)
    count = len(course.openings)
    times = {0: "no valve opened", 1: "a valve opened once"}.get(count, f"{count} valve openings")
    panel.set_title(f"{course.push.mode} control: {times}", fontsize=10)
    panel.set_xlabel("volume of the bent finger [cm3]")


def _draw_lines(panel: Axes) -> None:
    """Lines of equal air mass, on which closed valves leave the finger (violet in Fig. 4.2)."""
    low, high = panel.get_xlim()
    bottom, top = panel.get_ylim()
    volume = 1e-6 * np.linspace(low, high, 50)
    heat = GAS_CONSTANT * ROOM_TEMPERATURE
    least = (AMBIENT_PRESSURE + 1e3 * bottom) * volume[0] / heat
    most = (AMBIENT_PRESSURE + 1e3 * top) * volume[-1] / heat
    for mass in np.arange(least, most, LINE_SPACING):
        pressure = mass * heat / volume - AMBIENT_PRESSURE
        panel.plot(1e6 * volume, 1e-3 * pressure, color="0.8", linewidth=0.7, zorder=0)
    panel.set_xlim(low, high)
    panel.set_ylim(bottom, top)


def _draw_course(panels: Sequence[Axes], course: Course) -> None:
    colour, push = COLOURS[course.push.mode], course.push
    rows = (1e-3 * course.pressure, 1e6 * course.volume, 1e6 * course.mass, course.force)
    for panel, values in zip(panels, rows, strict=True):
        panel.axvspan(push.pressed - push.start, push.released - push.start, color="0.92")
        for opening in course.openings:
            panel.axvline(opening, color="black", linewidth=0.8, linestyle=":")
        panel.plot(course.time, values, color=colour, linewidth=1)
    middle = 1e6 * course.before(course.mass)
    panels[AIR].set_ylim(middle - AIR_SPAN, middle + AIR_SPAN)
    panels[-1].set_xlabel("time [s]")
