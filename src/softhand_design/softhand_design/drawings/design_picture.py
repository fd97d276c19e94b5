"""Picture of a designed actuator: what was wanted and reached along it, its walls, and its bend."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from softhand_common.numerics.arrays import Array
from softhand_design.sizing import Design
from softhand_model.hand.actuator import Actuator

MILLI, KILO = 1e-3, 1e3
POINTS = 400
SHOWN_PRESSURES = (0.25, 0.5, 0.75, 1.0)  # shares of the largest
RUBBER_COLOR, CHAMBER, WANTED, REACHED = "#f0a35a", "white", "black", "#c0392b"


def draw_design(design: Design) -> Figure:
    """Picture with the profiles on the left, below them the sections seen from the side and from
    above, and the bend on the right.
    """
    figure = Figure(figsize=(11.0, 7.0), dpi=120, layout="constrained")
    grid = figure.add_gridspec(4, 2, width_ratios=(1.5, 1.0), height_ratios=(1.2, 1.2, 1.0, 1.0))
    actuator, requirements = design.actuator, design.requirements
    x = np.linspace(0.0, actuator.length, POINTS)
    for row, name, wanted, reached, scale in (
        (0, "ratio [1/(m kPa)]", requirements.ratio(x), actuator.actuation_ratio(x), 1.0 / KILO),
        (1, "stiffness [mN m2]", requirements.stiffness(x), actuator.stiffness(x), MILLI),
    ):
        axes = figure.add_subplot(grid[row, 0])
        axes.plot(x / MILLI, wanted / scale, color=WANTED, label="wanted")
        axes.plot(x / MILLI, reached / scale, "--", color=REACHED, label="reached")
        axes.set_ylim(0.0, None)
        axes.set_ylabel(name)
        axes.legend(loc="lower left", fontsize=8)
    height, width, wall, side_wall = actuator.sides(x) / np.array(MILLI)
    side, above = figure.add_subplot(grid[2, 0]), figure.add_subplot(grid[3, 0])
    _fill(side, x, (0.0 * x, height), (0.0 * x, height - wall), "from the side [mm]")
    room = width / 2.0 - side_wall
    _fill(above, x, (-width / 2.0, width / 2.0), (-room, room), "from above [mm]")
    above.set_xlabel("x [mm]")
    _draw_bend(figure.add_subplot(grid[:, 1]), actuator)
    figure.suptitle(
        f"{actuator.name}: {requirements.rubber.name}, "
        f"wall {wall.min():.2f} to {wall.max():.2f} mm, "
        f"{actuator.mass / MILLI:.1f} g, up to {actuator.max_pressure / KILO:.0f} kPa"
    )
    return figure


def _fill(
    axes: Axes, x: Array, outer: tuple[Array, Array], inner: tuple[Array, Array], name: str
) -> None:
    """Rubber around the chamber."""
    axes.fill_between(x / MILLI, *outer, color=RUBBER_COLOR)
    axes.fill_between(x / MILLI, *inner, color=CHAMBER)
    axes.set_ylabel(name)
    axes.set_aspect("equal")


def _draw_bend(axes: Axes, actuator: Actuator) -> None:
    """The passive layer without load, at shares of the largest pressure."""
    x = np.linspace(0.0, actuator.length, POINTS)
    for share in SHOWN_PRESSURES:
        pressure = share * actuator.max_pressure
        curvature = actuator.free_curvature(pressure, x)
        angle = np.concatenate([[0.0], np.cumsum((curvature[1:] + curvature[:-1]) / 2.0) * x[1]])
        across, along = (
            np.concatenate([[0.0], np.cumsum((part[1:] + part[:-1]) / 2.0) * x[1]]) / MILLI
            for part in (np.sin(angle), np.cos(angle))
        )
        name = f"{pressure / KILO:.0f} kPa, {np.degrees(angle[-1]):.0f} deg"
        axes.plot(across, along, label=name)
    axes.set_aspect("equal")
    axes.set_xlabel("[mm]")
    axes.legend(fontsize=8, title="free bend of the passive layer", title_fontsize=8)
