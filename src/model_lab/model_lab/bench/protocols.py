"""Protocols that separate effects: courses of the driving input (pressure or stretch) over time.

All go from rest to a peak. `plan` chooses among them, and `synthesize` simulates runs with them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model_lab.aliases import Array


@dataclass(frozen=True)
class Protocol:
    """A course of the input, as corners (time over duration, input over peak).

    description: what a person does at the bench.
    """

    name: str
    description: str
    corners: tuple[tuple[float, float], ...]

    def course(self, duration: float, peak: float, samples: int) -> tuple[Array, Array]:
        """(time [s], input in the unit of `peak`), each (samples,), for a duration [s]."""
        time = np.linspace(0.0, duration, samples)
        at, level = np.array(self.corners).T
        return time, peak * np.interp(time / duration, at, level)

    def fastest(self) -> float:
        """Largest rate of the input, in peaks per duration."""
        at, level = np.array(self.corners).T
        return float(np.max(np.abs(np.diff(level)) / np.diff(at)))


def _triangles(heights: list[float], widths: list[float] | None = None) -> tuple:
    """Corners of triangles one after the other, of these heights and relative widths."""
    widths = widths or [1.0] * len(heights)
    edges = np.concatenate([[0.0], np.cumsum(widths)]) / np.sum(widths)
    corners = [(0.0, 0.0)]
    for start, stop, height in zip(edges[:-1], edges[1:], heights, strict=True):
        corners += [((start + stop) / 2.0, height), (stop, 0.0)]
    return tuple(corners)


def _staircase(levels: list[float], rise: float) -> tuple:
    """Corners of plateaus of equal width, reached within a share `rise` of it."""
    width = 1.0 / len(levels)
    corners = [(0.0, 0.0)]
    for index, level in enumerate(levels):
        corners += [((index + rise) * width, level), ((index + 1) * width, level)]
    return tuple(corners)


PROTOCOLS: tuple[Protocol, ...] = (
    Protocol("slow_ramp", "one slow ramp up and down", _triangles([1.0])),
    Protocol(
        "two_rates",
        "a triangle, then the same eight times as fast, twice",
        _triangles([1.0, 1.0, 1.0], [8.0, 1.0, 1.0]),
    ),
    Protocol("growing_triangles", "triangles of growing height", _triangles([0.4, 0.7, 1.0])),
    Protocol("repeated_triangles", "four equal triangles", _triangles([1.0] * 4)),
    Protocol(
        "step_and_hold",
        "a quick step to the peak, held, back to zero, held",
        _staircase([1.0, 0.0], 0.04),
    ),
    Protocol(
        "staircase", "plateaus up and down", _staircase([0.25, 0.5, 0.75, 1.0, 0.6, 0.3, 0.0], 0.15)
    ),
    Protocol(
        "small_loops",
        "up, then small loops about a mean, then up to the peak and down",
        (
            (0.0, 0.0),
            (0.15, 0.6),
            (0.25, 0.4),
            (0.35, 0.6),
            (0.45, 0.4),
            (0.6, 0.8),
            (0.7, 0.6),
            (0.85, 1.0),
            (1.0, 0.0),
        ),
    ),
)
