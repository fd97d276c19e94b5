"""Whether stated probabilities come true: reliability by bins, and expected calibration error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

Array = np.ndarray
EDGES = tuple(np.linspace(0.0, 1.0, 11))  # of bins of equal width
DRAWS = 2000


@dataclass(frozen=True)
class Bin:
    """Verdicts of about one confidence: how many, their mean confidence, how many are right."""

    count: int
    stated: float
    hits: int


def bins_of(stated: Sequence[float], right: Sequence[bool]) -> list[Bin]:
    """Verdicts by stated confidence, in bins of equal width between 0 and 1; none is empty.

    >>> bins_of([0.91, 0.93, 0.15], [True, False, False])
    [Bin(count=1, stated=0.15, hits=0), Bin(count=2, stated=0.92, hits=1)]
    """
    said, true = np.asarray(stated, float), np.asarray(right, bool)
    place = _places(said, EDGES)
    found = [(place == number) for number in range(len(EDGES) - 1)]
    return [
        Bin(int(mine.sum()), float(said[mine].mean()), int(true[mine].sum()))
        for mine in found
        if mine.any()
    ]


def _places(stated: Array, edges: Sequence[float]) -> Array:
    return np.clip(np.searchsorted(edges, stated, side="right") - 1, 0, len(edges) - 2)


def calibration_error(
    stated: Sequence[float], right: Sequence[bool], edges: Sequence[float] = EDGES
) -> float:
    """Expected calibration error: mean distance of confidence and share right over the verdicts,
    in bins between these edges.

    >>> round(calibration_error([0.9, 0.9], [True, False]), 3)
    0.4
    """
    said, true = np.asarray(stated, float), np.asarray(right, float)
    gap = np.bincount(_places(said, edges), said - true, len(edges) - 1)
    return float(np.abs(gap).sum() / max(len(said), 1))


def error_interval(
    stated: Sequence[float], right: Sequence[bool], edges: Sequence[float] = EDGES
) -> tuple[float, float]:
    """95 % bootstrap interval of the expected calibration error."""
    said, true = np.asarray(stated, float), np.asarray(right, bool)
    if not len(said):
        return 0.0, 1.0
    random = np.random.default_rng(0)
    drawn = random.integers(len(said), size=(DRAWS, len(said)))
    found = [calibration_error(said[row], true[row], edges) for row in drawn]
    low, high = np.quantile(found, [0.025, 0.975])
    return float(low), float(high)


def error_by_chance(
    stated: Sequence[float], edges: Sequence[float] = EDGES, level: float | None = None
) -> float:
    """Expected calibration error of as many verdicts whose confidences hold exactly: the mean, or
    the quantile of a level.
    """
    said = np.asarray(stated, float)
    if not len(said):
        return 0.0
    drawn = np.random.default_rng(0).random((DRAWS, len(said))) < said
    found = [calibration_error(said, row, edges) for row in drawn]
    return float(np.mean(found) if level is None else np.quantile(found, level))
