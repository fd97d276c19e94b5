"""Figures of a sweep: its maps, and the shares of success of its groups."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from softhand_trials.sweep.success_map import SuccessMap

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROWS = {"once": "once", "filtered": "3 x 3 mean", "share": "jittered"}  # of maps, and their names
COLUMN, ROW, BAR_WIDTH = 2.2, 1.8, 0.35  # [in]


def draw_maps(figure: Figure, maps: Mapping[str, SuccessMap]) -> None:
    """Draw each map in a column of its own: successes without jitter, their mean over 3x3 cells
    with the border of the region, and the share of jittered trials that succeed.
    """
    panels = figure.subplots(len(ROWS), len(maps), sharex=True, sharey=True, squeeze=False)
    for column, (name, found) in enumerate(maps.items()):
        for panel, row in zip(panels[:, column], ROWS, strict=True):
            _draw_panel(panel, found, getattr(found, row).astype(float))
        panels[0, column].set_title(name.replace("_", " "), fontsize=8)
        panels[-1, column].set_xlabel("y [mm]")
    for panel, label in zip(panels[:, 0], ROWS.values(), strict=True):
        panel.set_ylabel(f"{label}\nx [mm]")


def _draw_panel(panel: Any, found: SuccessMap, values: np.ndarray) -> None:
    half = 0.5 * found.pitch
    ends = [found.ys[0] - half, found.ys[-1] + half, found.xs[0] - half, found.xs[-1] + half]
    panel.imshow(
        values, origin="lower", extent=[1e3 * end for end in ends], cmap="Greens", vmin=0, vmax=1
    )
    drawable = min(found.region.shape) > 1  # a contour needs two cells either way
    if drawable and found.region.any() and not found.region.all():
        panel.contour(1e3 * found.ys, 1e3 * found.xs, found.region, [0.5], colors="k", linewidths=1)


def maps_figure(maps: Mapping[str, SuccessMap]) -> Figure:
    """The maps as a figure."""
    figure = _figure(1.0 + COLUMN * len(maps), 0.6 + ROW * len(ROWS))
    draw_maps(figure, maps)
    return figure


def shares_figure(
    names: Sequence[str], shares: Sequence[float], intervals: Sequence[tuple[float, float]]
) -> Figure:
    """Shares of success [-] as bars with their intervals (low, high) [-]."""
    figure = _figure(7.0, 1.0 + BAR_WIDTH * len(names))
    axes = figure.subplots()
    low, high = np.array(intervals, float).reshape(-1, 2).T
    places, values = np.arange(len(names)), np.array(shares, float)
    errors = np.clip([values - low, high - values], 0.0, None)
    axes.barh(places, values, xerr=errors, color="#74a574", ecolor="k", capsize=3)
    axes.set_yticks(places, list(names))
    axes.invert_yaxis()
    axes.set_xlim(0.0, 1.0)
    axes.set_xlabel("share of success with 95 % interval")
    return figure


def _figure(width: float, height: float) -> Figure:
    from matplotlib.figure import Figure  # takes longer to load than a sweep to begin

    return Figure(figsize=(width, height), layout="constrained")
