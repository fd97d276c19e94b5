"""What figures are made of; each mark can be drawn by matplotlib for paper, and by plotly."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Any, Protocol

import numpy as np
from matplotlib.axes import Axes

from model_lab.aliases import Array, Indices

# Okabe and Ito's colours, told apart by colour-blind readers too
COLOURS = {
    "measured": "#333333",
    "before": "#D55E00",
    "after": "#0072B2",
    "floor": "#009E73",
    "tied": "#CC79A7",
    "other": "#8A8A8A",
    "range": "#DDDDDD",
}
DASHES: dict[str, Any] = {"solid": "-", "dash": (0, (4, 1.5)), "dot": (0, (1, 1.2))}
SYMBOLS = {"o": "circle", "x": "x-thin", "+": "cross-thin", ">": "triangle-right"}
PIXELS = 1.6  # on screen for a point on paper
PAPER_POINTS = 200  # of a line on paper: more do not show


class Mark(Protocol):
    """Something that is drawn in a panel."""

    @property
    def points(self) -> int:
        """How many points it has that may be thinned."""

    def draw(self, axes: Axes) -> None:
        """Draw it on paper."""

    def screen(self, most: int) -> tuple[str, dict[str, Any]]:
        """`data` with a trace of plotly of at most so many points, or `shapes` with a shape."""


@dataclass(frozen=True)
class Course:
    """Points (n,) in the unit shown, with markers, joined by a line or both; NaN breaks a line.

    width: of the line [pt]; size: of a marker [pt]; texts: beside the points, in place of markers;
    most: points drawn on paper.
    """

    x: Array
    y: Array
    colour: str
    name: str = ""
    width: float = 0.0
    dash: str = "solid"
    marker: str = ""
    size: float = 4.0
    opacity: float = 1.0
    hollow: bool = False
    texts: Sequence[str] = ()
    most: int = PAPER_POINTS

    @property
    def points(self) -> int:
        """How many points it has that may be thinned."""
        return len(self.x)

    def draw(self, axes: Axes) -> None:
        """Draw it on paper."""
        colour = COLOURS[self.colour]
        for at, height, text in zip(self.x, self.y, self.texts, strict=False):
            axes.annotate(text, (at, height), (4, 0), textcoords="offset points", va="center")
        if self.texts:
            return
        y = np.asarray(self.y)
        kept = envelope(y, self.most) if self.width else evenly(len(y), self.most)
        axes.plot(
            np.asarray(self.x)[kept], y[kept], color=colour, alpha=self.opacity,
            linewidth=self.width, linestyle=DASHES[self.dash] if self.width else "",
            marker=self.marker, markersize=self.size,
            markerfacecolor="white" if self.hollow else colour,
            markeredgewidth=1.0 if self.hollow or self.marker in ("x", "+") else 0.0,
        )  # fmt: skip

    def screen(self, most: int) -> tuple[str, dict[str, Any]]:
        """A trace; of many points the extremes stay."""
        y = np.asarray(self.y, float)
        kept = envelope(y, most)
        modes = [("lines", self.width), ("markers", self.marker), ("text", self.texts)]
        trace = {
            "type": "scatter",
            "x": packed(np.asarray(self.x, float)[kept]),
            "y": packed(y[kept]),
            "mode": "+".join(name for name, used in modes if used),
            "name": escape(self.name),
            "opacity": self.opacity,
            "hoverinfo": "x+y+name" if self.name else "skip" if self.texts else "x+y",
        }
        if self.width:
            width = PIXELS * self.width
            trace["line"] = {"color": COLOURS[self.colour], "width": width, "dash": self.dash}
        if self.marker:
            trace["marker"] = {
                "color": "#FFFFFF" if self.hollow else COLOURS[self.colour],
                "size": PIXELS * self.size,
                "symbol": SYMBOLS[self.marker],
                "line": {"color": COLOURS[self.colour], "width": float(self._edged) * 1.5},
            }
        if self.texts:
            placed = {"textposition": "middle right", "cliponaxis": False}
            trace |= {"text": [f"\u2009{escape(text)}" for text in self.texts], **placed}
        return "data", trace

    @property
    def _edged(self) -> bool:
        return self.hollow or self.marker in ("x", "+")


@dataclass(frozen=True)
class Band:
    """What lies between two lines (n,)."""

    x: Array
    low: Array
    high: Array
    colour: str
    opacity: float = 0.22
    points = 0

    def draw(self, axes: Axes) -> None:
        """Draw it on paper."""
        colour = COLOURS[self.colour]
        axes.fill_between(
            self.x, self.low, self.high, color=colour, alpha=self.opacity, linewidth=0
        )

    def screen(self, most: int) -> tuple[str, dict[str, Any]]:
        """A trace that is filled inside."""
        x, low, high = (np.asarray(part, float) for part in (self.x, self.low, self.high))
        known = np.isfinite(low) & np.isfinite(high)
        around = [np.concatenate([a[known], b[known][::-1]]) for a, b in ((x, x), (high, low))]
        return "data", {
            "type": "scatter", "x": packed(around[0]), "y": packed(around[1]), "fill": "toself",
            "mode": "lines", "line": {"width": 0}, "hoverinfo": "skip",
            "fillcolor": _see_through(self.colour, self.opacity),
        }  # fmt: skip


@dataclass(frozen=True)
class Bars:
    """Lengths (n,) of bars from above to below at the places 0, 1, ..."""

    lengths: Sequence[float]
    colours: Sequence[str]
    points = 0

    def draw(self, axes: Axes) -> None:
        """Draw them on paper."""
        colours = [COLOURS[name] for name in self.colours]
        axes.barh(range(len(colours)), self.lengths, height=0.62, color=colours)

    def screen(self, most: int) -> tuple[str, dict[str, Any]]:
        """A trace of bars."""
        return "data", {
            "type": "bar", "orientation": "h", "x": list(self.lengths), "width": 0.62,
            "y": list(range(len(self.lengths))), "hoverinfo": "x",
            "marker": {"color": [COLOURS[name] for name in self.colours]},
        }  # fmt: skip


@dataclass(frozen=True)
class Strip:
    """A strip across the panel between two values of x, or of y; of no width it is a line.

    width: of the line [pt].
    """

    low: float
    high: float
    colour: str
    of: str = "x"
    opacity: float = 0.25
    width: float = 1.3
    dash: str = "solid"
    points = 0

    def draw(self, axes: Axes) -> None:
        """Draw it on paper."""
        colour = COLOURS[self.colour]
        line, span = (
            (axes.axvline, axes.axvspan) if self.of == "x" else (axes.axhline, axes.axhspan)
        )
        if self.low == self.high:
            line(self.low, color=colour, linewidth=self.width, linestyle=DASHES[self.dash])
        else:
            span(self.low, self.high, color=colour, alpha=self.opacity, linewidth=0)

    def screen(self, most: int) -> tuple[str, dict[str, Any]]:
        """A shape that reaches over the whole panel."""
        other = "y" if self.of == "x" else "x"
        shape = {
            f"{self.of}0": self.low, f"{self.of}1": self.high, f"{other}0": 0, f"{other}1": 1,
            f"{self.of}ref": self.of, f"{other}ref": f"{other} domain", "layer": "below",
        }  # fmt: skip
        if self.low == self.high:
            line = {"color": COLOURS[self.colour], "width": PIXELS * self.width, "dash": self.dash}
            return "shapes", {"type": "line", **shape, "line": line}
        fill = _see_through(self.colour, self.opacity)
        return "shapes", {"type": "rect", **shape, "fillcolor": fill, "line": {"width": 0}}


def envelope(values: Array, most: int) -> Indices:
    """Indices of at most so many of values (n,): ends, and the extremes of every part between.

    >>> envelope(np.array([0.0, 0.0, 9.0, 0.0, 0.0, -9.0, 0.0, 0.0]), 6).tolist()
    [0, 2, 4, 5, 7]
    """
    count = len(values)
    if count <= most:
        return np.arange(count)
    parts = max((most - 2) // 2, 1)
    width = -(-count // parts)
    rows = np.pad(values, (0, -count % width), mode="edge").reshape(-1, width)
    starts = width * np.arange(len(rows))
    found = [[0, count - 1], starts + rows.argmin(axis=1), starts + rows.argmax(axis=1)]
    return np.unique(np.minimum(np.concatenate(found), count - 1))


def evenly(count: int, most: int) -> Indices:
    """Indices of at most so many of `count` points, evenly and with both ends."""
    if count <= most:
        return np.arange(count)
    return np.unique(np.linspace(0, count - 1, most).round().astype(np.intp))


def packed(values: Array) -> dict[str, str]:
    """An array as plotly reads it, in little room."""
    data = np.asarray(values, "<f4").tobytes()
    return {"dtype": "f4", "bdata": base64.b64encode(data).decode("ascii")}


def _see_through(colour: str, opacity: float) -> str:
    return f"{COLOURS[colour]}{round(255 * opacity):02x}"
