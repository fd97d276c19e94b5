"""Balance of elastic side and load, solved for many sections, rows and trial values at once.

The elastic side grows with the stretch, so there is one root; effects give no derivative, so slopes
are secants. Arrays are (lanes, rows, sections) as in `effects.stages`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Elastic = Callable[[Array], Array]
"""Elastic side [-] at a stretch [-]."""
Correction = Callable[[Array, Array, Array], Array]
"""Change of the stretch [-] that balances the sections, given stretch, elastic side and its slope,
by which the elastic side is taken to go on in a straight line.
"""

LOWEST, HIGHEST = 0.05, 60.0  # stretch, where the search for a root ends
DIFFERENCE = 1e-6  # of the first slope
SMALLEST_SLOPE = 0.02  # softened rubber has 0.1 and more
SETTLED = 3e-8  # last step of the stretch: the error after it is of the order of its square
SECANTS = 12
HALVES = 24
BALANCED = 1e-6  # of the load: what more is left over than this is no balance


@dataclass(frozen=True)
class Balanced:
    """Stretch [-] that balances the load, slope [-] of the elastic side there, and whether the
    balance was found everywhere.
    """

    stretch: Array
    slope: Array
    settled: bool = True


def rough_stretch(load: Array) -> Array:
    """Stretch [-] at which q(lambda) is about the load [-]: within 3 %, where iterations start.

    >>> rough_stretch(np.array([-1.0, 0.0, 1.0, 3.0])).round(2).tolist()
    [0.83, 1.0, 1.37, 3.06]
    """
    above, below = np.maximum(load, 0.0), np.minimum(load, 0.0)
    stretched = 0.25 * above + np.cbrt(1.0 + (0.75 * above) ** 3)
    return np.where(load > 0.0, stretched, 1.0 / np.cbrt(1.0 - 0.75 * below))


def balance(elastic: Elastic, load: Array, start: Balanced | None = None) -> Balanced:
    """Stretch at which the elastic side carries the load [-], from a start nearby if there is one.

    Where the elastic side never reaches the load the stretch ends at LOWEST or HIGHEST.

    >>> found = balance(lambda stretch: stretch - stretch**-3, np.array([3.0 - 3.0**-3]))
    >>> found.stretch.round(9).tolist()
    [3.0]
    """

    def correction(_stretch: Array, stress: Array, slope: Array) -> Array:
        return (load - stress) / slope

    if start is None:
        start = first_slope(elastic, rough_stretch(load))
    found = iterate(elastic, correction, start)
    return found if found.settled else _bracketed(elastic, load)


def first_slope(elastic: Elastic, stretch: Array) -> Balanced:
    """A start for the iteration at a stretch, with the slope by a small difference."""
    rise = elastic(stretch + DIFFERENCE) - elastic(stretch)
    return Balanced(stretch, np.maximum(rise / DIFFERENCE, SMALLEST_SLOPE))


def iterate(
    elastic: Elastic, correction: Correction, start: Balanced, settled: float = SETTLED
) -> Balanced:
    """Where a secant iteration from a start comes to; it ends with a step within `settled`."""
    stretch, slope = start.stretch, start.slope
    stress = elastic(stretch)
    for _ in range(SECANTS):
        change = correction(stretch, stress, slope)
        # half the way to 0 at most, so that lambda**-3 stays tame
        moved = np.minimum(np.maximum(stretch + change, 0.5 * stretch), HIGHEST)
        if np.abs(change).max() <= settled:
            return Balanced(moved, slope)
        stress_before, stress, change = stress, elastic(moved), moved - stretch
        slope = _secant(stress - stress_before, change, slope)
        stretch = moved
    return Balanced(stretch, slope, settled=False)


def _secant(rise: Array, run: Array, before: Array) -> Array:
    """Slope over the last step, or the one before it where rounding would blur it."""
    long = np.abs(run) > 1e-10
    return np.where(long, np.maximum(rise / np.where(long, run, 1.0), SMALLEST_SLOPE), before)


def _bracketed(elastic: Elastic, load: Array) -> Balanced:
    """As `balance`, for elastic sides on which secants go astray: halves first."""
    whole = np.zeros_like(elastic(np.maximum(load, 1.0)) + load)
    low, high = whole + LOWEST, whole + HIGHEST
    for _ in range(HALVES):
        middle = 0.5 * (low + high)
        below = elastic(middle) < load
        low, high = np.where(below, middle, low), np.where(below, high, middle)

    def correction(stretch: Array, stress: Array, slope: Array) -> Array:
        return np.clip((load - stress) / slope, low - stretch, high - stretch)

    found = iterate(elastic, correction, first_slope(elastic, 0.5 * (low + high)))
    excess = np.abs(elastic(found.stretch) - load)
    return replace(found, settled=bool(np.all(excess <= BALANCED * (1.0 + np.abs(load)))))
