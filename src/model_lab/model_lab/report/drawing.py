"""Figures of a report: panels of marks, drawn by matplotlib as pictures for page and paper."""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from html import escape
from typing import Any

import matplotlib as mpl
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from model_lab.report.marks import COLOURS, DASHES, Mark

STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",  # text stays text: small, searchable, read aloud
    "svg.hashsalt": "model-lab",
    "font.family": "DejaVu Sans",
    "axes.titlesize": "medium",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "axes.edgecolor": "#555555",
    "xtick.color": "#555555",
    "ytick.color": "#555555",
    "xtick.labelcolor": "#222222",
    "ytick.labelcolor": "#222222",
    "legend.frameon": False,
    "text.parse_math": False,  # names of users may hold dollar signs
}
FONTS = "'DejaVu Sans', Verdana, sans-serif"  # alike in width, or narrower
PICTURE_WIDTH = 8.0  # [in] of pictures of their own
PANEL_WIDTH = 3.7  # [in] of a panel of a page: of a phone's window
LETTERS, PANEL_LETTERS = 8.5, 10.5  # [pt], the latter 14 pixels
LEGEND_GAP = 0.02  # between a legend and the panels below it, share of the height
LONG_NAMES = 22  # letters of all names that fit beside each other on paper
TITLES = {4: 7.5, 5: 6.5}  # [pt] by columns, where there are many
LETTERS_A_ROW = 120  # of all titles of a row
GLYPHS = {"solid": "━", "dash": "╍", "dot": "┅", "o": "●", "x": "×", "+": "+", "strip": "█"}


@dataclass(frozen=True)
class Scale:
    """An axis of a panel.

    ticks: (place, name) of each tick, listed from top to bottom if the panel has rows. strong:
    (name, colour) of names that are drawn in a colour.
    """

    label: str = ""
    ends: tuple[float, float] | None = None
    logarithmic: bool = False
    ticks: tuple[tuple[float, str], ...] = ()
    hidden: bool = False
    strong: tuple[tuple[str, str], ...] = ()

    def draw(self, axes: Axes, side: str) -> None:
        """Draw the axis; side: x or y."""
        axis = axes.xaxis if side == "x" else axes.yaxis
        axis.set_label_text(self.label)
        if self.logarithmic:
            (axes.set_xscale if side == "x" else axes.set_yscale)("log")
            axis.set_major_locator(LogLocator(subs=(1.0, 3.0), numticks=4))
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.4g}"))
            axis.set_minor_formatter(NullFormatter())
        elif not self.ticks:
            axis.set_major_locator(MaxNLocator(5))
        if self.ticks or self.hidden:
            self._name(axes, side)
        if self.ends:
            (axes.set_xlim if side == "x" else axes.set_ylim)(*self.ends)

    def _name(self, axes: Axes, side: str) -> None:
        axis = axes.xaxis if side == "x" else axes.yaxis
        axis.set_ticks([at for at, _ in self.ticks], [name for _, name in self.ticks])
        long = sum(len(name) for _, name in self.ticks) > LONG_NAMES
        for text, (_, name) in zip(axis.get_ticklabels(), self.ticks, strict=False):
            if side == "x" and long:
                text.set(rotation=20, horizontalalignment="right", rotation_mode="anchor")
            if name in dict(self.strong):
                text.set(color=COLOURS[dict(self.strong)[name]], fontweight="bold")
        if side == "y":
            axes.spines["left"].set_visible(False)
            axes.tick_params(left=False)


@dataclass(frozen=True)
class Panel:
    """Marks between two axes. height [inch]: of the panel."""

    marks: tuple[Mark, ...]
    x: Scale = Scale()
    y: Scale = Scale()
    title: str = ""
    height: float = 2.9

    def draw(self, axes: Axes) -> None:
        """Draw the panel."""
        along = axes.xaxis if self.y.ticks or self.y.hidden else axes.yaxis
        along.grid(True, color="#E3E3E3", linewidth=0.6)
        axes.set_axisbelow(True)
        for mark in self.marks:
            mark.draw(axes)
        self.x.draw(axes, "x")
        self.y.draw(axes, "y")

    def svg(self, name: str, alt: str) -> str:
        """The panel as an SVG element. name: prefix of all ids in it. alt: text that says what it
        shows.
        """
        with styled(PANEL_LETTERS):
            figure = Figure(figsize=(PANEL_WIDTH, self.height), layout="constrained")
            self.draw(figure.subplots())
            stream = io.StringIO()
            figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
        text = stream.getvalue()
        text = re.sub(r"<metadata>.*?</metadata>\s*", "", text, flags=re.DOTALL)
        (box,) = re.findall(r'<svg [^>]*?viewBox="([^"]*)"', text)
        inside = text[text.index(">", text.index("<svg")) + 1 :]
        text = (
            f'<svg viewBox="{box}" role="img" aria-label="{escape(alt)}" '
            f'xmlns:xlink="http://www.w3.org/1999/xlink">{inside}'
        )
        text = re.sub(r'\bid="([^"]+)"', rf'id="{name}-\1"', text)
        text = re.sub(r'(href="|url\()#', rf"\1#{name}-", text)
        return _coarse(text.replace("'DejaVu Sans'", FONTS))


@dataclass(frozen=True)
class Key:
    """An entry of a legend. look: a dash style, a marker, or `strip`."""

    text: str
    colour: str
    look: str = "solid"

    @property
    def hue(self) -> str:
        """Name of the colour on the page."""
        return COLOURS[self.colour]

    @property
    def glyph(self) -> str:
        """A character that looks like the mark."""
        return GLYPHS[self.look]

    def handle(self) -> Artist:
        """The mark of the entry, for a legend of matplotlib."""
        if self.look == "strip":
            alpha = 0.3 if self.colour == "floor" else 1.0
            return Patch(color=self.hue, alpha=alpha, linewidth=0, label=self.text)
        if self.look in DASHES:
            return Line2D([], [], color=self.hue, label=self.text, linestyle=DASHES[self.look])
        return Line2D(
            [], [], color=self.hue, label=self.text, linestyle="", marker=self.look, markersize=4
        )


FLOOR_KEY = Key("noise floor", "floor", "strip")


@dataclass(frozen=True)
class Drawing:
    """A figure of the page. name: anchor of the figure. alt: text in place of the picture. keys:
    entries of the legend.
    """

    name: str
    title: str
    caption: str
    alt: str
    panels: tuple[Panel, ...]
    keys: tuple[Key, ...] = ()

    def pictures(self) -> list[tuple[str, str]]:
        """(title, SVG text) of every panel."""
        return [
            (panel.title, panel.svg(f"{self.name}-{place}", panel.title or self.alt))
            for place, panel in enumerate(self.panels)
        ]


def paint(figure: FigureBase, panels: Sequence[Panel], columns: int) -> None:
    """Draw panels in a grid of one figure; equal scales are labelled once. columns: number of
    panels side by side.
    """
    alike_x, alike_y = (
        len({getattr(panel, side) for panel in panels}) == 1 and len(panels) > 1 for side in "xy"
    )
    columns = min(columns, len(panels))
    rows = -(-len(panels) // columns)
    grid = figure.subplots(rows, columns, sharex=alike_x, sharey=alike_y, squeeze=False)
    for place, (axes, panel) in enumerate(zip(grid.flat, panels, strict=False)):
        panel.draw(axes)
        title = _short(panel.title, columns)
        axes.set_title(title, loc="left", pad=3, fontsize=TITLES.get(columns))
        if alike_x:
            axes.set_xlabel("")
        if alike_y and (place % columns or alike_x):
            axes.set_ylabel("")
    if alike_x:
        figure.supxlabel(panels[0].x.label, fontsize=LETTERS)
    if alike_x and alike_y:
        figure.supylabel(panels[0].y.label, fontsize=LETTERS)
    _hide(grid.flat, len(panels), columns)


def styled(letters: float = LETTERS) -> AbstractContextManager[None]:
    """Context in which figures are drawn in the style of the report. letters: font size [pt]."""
    return mpl.rc_context(STYLE | {"font.size": letters})


def _short(title: str, columns: int) -> str:
    """As much of a title as a panel has room for."""
    room = LETTERS_A_ROW // columns
    return title if len(title) <= room else f"{title[: room - 1]}…"


def _coarse(text: str) -> str:
    """Coordinates rounded to an invisible tenth of a point; numbers to read stay. Markers of one
    group share its style.
    """

    def rounded(found: re.Match[str]) -> str:
        return re.sub(r"-?\d+\.\d{2,}", lambda m: f"{float(m.group()):.1f}", found.group())

    def shared(found: re.Match[str]) -> str:
        uses = re.sub(r' style="[^"]*"', "", found.group(2))
        return f"<g {found.group(1)} {found.group(3)}>{uses}</g>"

    group = r'<g (clip-path="[^"]*")>\s*((?:<use [^>]*?( style="[^"]*")/>\s*)+)</g>'
    return re.sub(r'\s(?:d|x|y|transform)="[^"]*"', rounded, re.sub(group, shared, text))


def legend_above(figure: Figure, keys: Sequence[Key]) -> None:
    """Draw a legend above all panels. (Before 3.7, matplotlib cannot place one outside of the
    panels.)
    """
    handles = [key.handle() for key in keys]
    columns = 3 if max(len(key.text) for key in keys) > LONG_NAMES else 6
    legend = figure.legend(handles=handles, loc="upper left", ncols=columns)
    share = legend.get_window_extent().height / figure.bbox.height + LEGEND_GAP
    figure.set_layout_engine("constrained", rect=(0.0, 0.0, 1.0, 1.0 - share))


def _hide(axes: Iterable[Axes], used: int, columns: int) -> None:
    """Hide the axes of a grid beyond `used`, and show tick labels above them."""
    every = list(axes)
    for index in range(used, len(every)):
        every[index].set_visible(False)
        if index >= columns:
            every[index - columns].xaxis.set_tick_params(labelbottom=True)
