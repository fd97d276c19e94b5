"""Picture of the maps of all objects: success in each engine, where these differ, and by what most
trials of a cell failed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from softhand_trials.sweep.success_map import SuccessMap
from thesis.chapter_8.map_evidence import differing_cells
from thesis.chapter_8.object_map import MAIN, cells_of, maps_of
from thesis.frame import Figure, Results

PICTURE = (18.0, 5.0)  # [in]
COLOURS = "tab10"
CAUSES_SHOWN = 9  # by colour; the rest is grey


def draw_map(figure: Figure, results: Results) -> None:
    """A column an object: share of success in each engine (grey: no trial), crosses where the
    verdicts of two engines differ, and the commonest cause of failures of each cell.
    """
    maps, apart = maps_of(results), differing_cells(results)
    sweeps = [name for name in results["sweeps"] if name.startswith(MAIN)]
    panels = figure.subplots(len(sweeps) + 1, len(maps), sharex=True, sharey=True, squeeze=False)
    causes = _commonest(results["sweeps"][MAIN])
    for column, (name, found) in enumerate(maps.items()):
        panels[0, column].set_title(name.replace("_", " "), fontsize=8)
        panels[-1, column].set_xlabel("y [mm]")
        for panel, sweep in zip(panels[:, column], sweeps, strict=False):
            if name in results["sweeps"][sweep]:
                _draw_share(panel, found, cells_of(results, sweep, name))
                _cross(panel, apart.get(name, []))
            else:
                panel.text(0.5, 0.5, "refused", ha="center", transform=panel.transAxes)
                panel.set_aspect("equal")
        failed = results["sweeps"][MAIN][name]["failed"]
        _draw_causes(panels[-1, column], found, failed, causes)
    labels = [sweep.removeprefix(f"{MAIN}_") for sweep in sweeps]
    labels[0] = results["engine"]
    for panel, label in zip(panels[:, 0], [*labels, "fails by"], strict=True):
        panel.set_ylabel(f"{label}\nx [mm]")
    _legend(figure, causes)


def _extent(found: SuccessMap) -> list[float]:
    half = 0.5 * found.pitch
    ends = found.ys[0] - half, found.ys[-1] + half, found.xs[0] - half, found.xs[-1] + half
    return [1e3 * end for end in ends]


def _draw_share(panel: Any, found: SuccessMap, cells: Mapping[int, np.ndarray]) -> None:
    """Share of all trials of a cell, that without jitter among them."""
    share = np.ma.mean(np.ma.masked_invalid(list(cells.values())), axis=0)
    panel.imshow(share, origin="lower", extent=_extent(found), cmap="Greens", vmin=0, vmax=1)
    panel.set_facecolor("0.7")


def _cross(panel: Any, cells: Sequence[tuple[float, float]]) -> None:
    if cells:
        x, y = 1e3 * np.array(cells).T
        panel.plot(y, x, "x", color="tab:red", markersize=5)


def _commonest(tallies: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Causes of failures of all objects, the commonest first."""
    counts: Counter[str] = Counter()
    for found in tallies.values():
        counts.update({cause: len(cells) for cause, cells in found["failed"].items()})
    return [cause for cause, _ in counts.most_common(CAUSES_SHOWN)]


def _draw_causes(
    panel: Any, found: SuccessMap, failed: Mapping[str, Sequence[Any]], causes: Sequence[str]
) -> None:
    """The commonest cause of each cell by colour; white: no failure, grey: another cause."""
    by_cell: dict[tuple[float, ...], Counter[str]] = {}
    for cause, cells in failed.items():
        for cell in cells:
            by_cell.setdefault(tuple(cell), Counter())[cause] += 1
    image = np.ones((len(found.xs), len(found.ys), 4))
    for cell, counts in by_cell.items():
        cause = counts.most_common(1)[0][0]
        x, y = (np.argmin(np.abs(a - v)) for a, v in zip((found.xs, found.ys), cell, strict=True))
        image[x, y] = _colour(causes, cause)
    panel.imshow(image, origin="lower", extent=_extent(found))


def _colour(causes: Sequence[str], cause: str) -> tuple[float, ...]:
    from matplotlib import colormaps

    if cause not in causes:
        return (0.8, 0.8, 0.8, 1.0)
    return tuple(colormaps[COLOURS](causes.index(cause)))


def _legend(figure: Figure, causes: Sequence[str]) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    crosses = Line2D([], [], color="tab:red", marker="x", linestyle="", label="engines differ")
    patches = [Patch(color=_colour(causes, cause), label=cause) for cause in causes]
    figure.legend(handles=[crosses, *patches], loc="outside lower center", ncols=10, fontsize=8)
