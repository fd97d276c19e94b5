"""What figures are made of: marks that matplotlib draws."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
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
LINE_POINTS = 400  # of a line: more do not show


class Mark(Protocol):
    """Something that is drawn in a panel."""

    def draw(self, axes: Axes) -> None:
        """Draw the mark."""


@dataclass(frozen=True)
class Points:
    """Points (n,) in the unit shown, as markers, joined by a line, or both; NaN breaks the line.

    width: of the line [pt]; 0 for no line. size: of a marker [pt]. texts: texts that are drawn
    beside the points. most: largest number of points that are drawn.
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
    most: int = LINE_POINTS

    def draw(self, axes: Axes) -> None:
        """Draw the mark."""
        colour = COLOURS[self.colour]
        for at, height, text in zip(self.x, self.y, self.texts, strict=False):
            axes.annotate(text, (at, height), (4, 0), textcoords="offset points", va="center")
        if self.texts:
            return
        y = np.asarray(self.y)
        kept = envelope(y, self.most) if self.width else at_random(len(y), self.most)
        axes.plot(
            np.asarray(self.x)[kept], y[kept], color=colour, alpha=self.opacity,
            linewidth=self.width, linestyle=DASHES[self.dash] if self.width else "",
            marker=self.marker, markersize=self.size,
            markerfacecolor="white" if self.hollow else colour,
            markeredgewidth=1.0 if self.hollow or self.marker in ("x", "+") else 0.0,
        )  # fmt: skip


@dataclass(frozen=True)
class Band:
    """The area between two lines `low` and `high` (n,) over x (n,)."""

    x: Array
    low: Array
    high: Array
    colour: str
    opacity: float = 0.22

    def draw(self, axes: Axes) -> None:
        """Draw the mark."""
        colour = COLOURS[self.colour]
        axes.fill_between(
            self.x, self.low, self.high, color=colour, alpha=self.opacity, linewidth=0
        )


@dataclass(frozen=True)
class Bars:
    """Horizontal bars of these lengths (n,), from top to bottom at the places 0, 1, ..."""

    lengths: Sequence[float]
    colours: Sequence[str]

    def draw(self, axes: Axes) -> None:
        """Draw the bars."""
        colours = [COLOURS[name] for name in self.colours]
        axes.barh(range(len(colours)), self.lengths, height=0.62, color=colours)


@dataclass(frozen=True)
class Strip:
    """A strip across the panel between two values of x, or of y if `of` is "y"; a line if both
    values are equal.

    width: of that line [pt].
    """

    low: float
    high: float
    colour: str
    of: str = "x"
    opacity: float = 0.25
    width: float = 1.3
    dash: str = "solid"

    def draw(self, axes: Axes) -> None:
        """Draw the mark."""
        colour = COLOURS[self.colour]
        line, span = (
            (axes.axvline, axes.axvspan) if self.of == "x" else (axes.axhline, axes.axhspan)
        )
        if self.low == self.high:
            line(self.low, color=colour, linewidth=self.width, linestyle=DASHES[self.dash])
        else:
            span(self.low, self.high, color=colour, alpha=self.opacity, linewidth=0)


def envelope(values: Array, most: int) -> Indices:
    """Indices of at most `most` of the values (n,): both ends, and the extremes of every part
    between.

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


def at_random(count: int, most: int) -> Indices:
    """Indices, in order, of at most `most` of `count` points, drawn at random but the same for all
    figures.

    If dots were thinned by their extremes, or evenly, a figure would show stripes that are not in
    the data.
    """
    if count <= most:
        return np.arange(count)
    return np.sort(np.random.default_rng(0).choice(count, most, replace=False))


def evenly(count: int, most: int) -> Indices:
    """Indices of at most `most` of `count` points, evenly spaced and with both ends."""
    if count <= most:
        return np.arange(count)
    return np.unique(np.linspace(0, count - 1, most).round().astype(np.intp))
