"""How the figures of a report look, and how one becomes a picture inside the page."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from html import escape
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from model_lab.aliases import Indices

# Okabe and Ito's colours, told apart by colour-blind readers too
COLOURS = {
    "measured": "#333333",
    "before": "#D55E00",
    "after": "#0072B2",
    "floor": "#009E73",
    "tied": "#CC79A7",
    "other": "#8A8A8A",
}
STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",  # text stays text: small, searchable, read aloud
    "svg.hashsalt": "model-lab",
    "font.family": "DejaVu Sans",
    "font.size": 8.5,
    "axes.titlesize": 8.5,
    "axes.labelsize": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "axes.edgecolor": "#555555",
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "xtick.color": "#555555",
    "ytick.color": "#555555",
    "xtick.labelcolor": "#222222",
    "ytick.labelcolor": "#222222",
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.2,
    "text.parse_math": False,  # names of users may hold dollar signs
}
FONTS = "'DejaVu Sans', Verdana, sans-serif"  # alike in width, or narrower
WIDTH = 10.0  # [in] of all figures, so that their letters are alike
GAP = 0.02  # between a legend and the panels below it, share of the height
MOST_POINTS = 200  # of a curve: more do not show


@dataclass(frozen=True)
class Drawing:
    """A figure of the page: `name` for its anchor, what it shows for those who do not see it, and
    how it is drawn.
    """

    name: str
    title: str
    caption: str
    alt: str
    height: float
    draw: Callable[[Figure], None]
    width: float = WIDTH

    def figure(self) -> Figure:
        """The figure, drawn; call within `styled()`."""
        figure = Figure(figsize=(self.width, self.height), layout="constrained")
        self.draw(figure)
        return figure

    def svg(self) -> str:
        """The figure as an SVG element, its ids made unique to it."""
        with styled():
            stream = io.StringIO()
            self.figure().savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
        text = stream.getvalue()
        text = text[text.index("<svg") :]
        text = re.sub(r"<metadata>.*?</metadata>\s*", "", text, flags=re.DOTALL)
        text = re.sub(r'<svg [^>]*?viewBox="([^"]*)"[^>]*>', self._opening, text, count=1)
        text = re.sub(r'\bid="([^"]+)"', rf'id="{self.name}-\1"', text)
        text = re.sub(r'(href="|url\()#', rf"\1#{self.name}-", text)
        text = text.replace("'DejaVu Sans'", FONTS)
        return _coarse(text)

    def _opening(self, found: re.Match[str]) -> str:
        return (
            f'<svg viewBox="{found.group(1)}" role="img" aria-label="{escape(self.alt)}" '
            f'xmlns:xlink="http://www.w3.org/1999/xlink" style="max-width:{self.width:g}in">'
            f"<title>{escape(self.title)}</title>"
        )


def styled() -> AbstractContextManager[None]:
    """Context in which figures are drawn and written in the style of the report."""
    return mpl.rc_context(STYLE)


def _coarse(text: str) -> str:
    """Coordinates to a hundredth of a point, which nobody sees; numbers to read stay."""

    def rounded(found: re.Match[str]) -> str:
        return re.sub(r"-?\d+\.\d{3,}", lambda m: f"{float(m.group()):.2f}", found.group())

    return re.sub(r'\s(?:d|x|y|transform)="[^"]*"', rounded, text)


def thinned(count: int, most: int = MOST_POINTS) -> Indices:
    """Indices (n,) of at most so many of `count` points, evenly and with both ends."""
    if count <= most:
        return np.arange(count)
    return np.unique(np.linspace(0, count - 1, most).round().astype(np.intp))


def light_grid(axes: Axes, which: Literal["x", "y", "both"] = "y") -> None:
    """Thin lines behind the data."""
    axes.grid(True, axis=which, color="#E3E3E3", linewidth=0.6)
    axes.set_axisbelow(True)


def line_handle(label: str, text: str, **style: Any) -> Line2D:
    """A legend's entry for a line in the colour of a label."""
    return Line2D([], [], color=COLOURS[label], label=text, **style)


def floor_handle() -> Patch:
    """A legend's entry for the strip of the noise floor."""
    return Patch(color=COLOURS["floor"], alpha=0.3, linewidth=0, label="noise floor")


def legend_above(figure: Figure, handles: list[Any], columns: int) -> None:
    """A legend above all panels; matplotlib before 3.7 has no place `outside` for it."""
    legend = figure.legend(handles=handles, loc="upper left", ncols=columns)
    share = legend.get_window_extent().height / figure.bbox.height + GAP
    figure.set_layout_engine("constrained", rect=(0.0, 0.0, 1.0, 1.0 - share))


def by_rows(axes: Iterable[Axes], used: int, columns: int) -> None:
    """Hide the axes of a grid beyond `used`, and show tick labels above them."""
    every = list(axes)
    for index in range(used, len(every)):
        every[index].set_visible(False)
        if index >= columns:
            every[index - columns].xaxis.set_tick_params(labelbottom=True)
