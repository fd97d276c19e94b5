"""Whether stated probabilities come true: reliability by bins, and expected calibration error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

Array = np.ndarray
BINS = 10
DRAWS = 2000


@dataclass(frozen=True)
class Bin:
    """Verdicts of about one confidence: how many, their mean confidence, how many are right."""

    count: int
    stated: float
    hits: int


def bins_of(stated: Sequence[float], right: Sequence[bool], bins: int = BINS) -> list[Bin]:
    """Verdicts by stated confidence, in bins of equal width between 0 and 1; none is empty.

    >>> bins_of([0.91, 0.93, 0.15], [True, False, False])
    [Bin(count=1, stated=0.15, hits=0), Bin(count=2, stated=0.92, hits=1)]
    """
    said, true = np.asarray(stated, float), np.asarray(right, bool)
    place = _places(said, bins)
    found = [(place == number) for number in range(bins)]
    return [
        Bin(int(mine.sum()), float(said[mine].mean()), int(true[mine].sum()))
        for mine in found
        if mine.any()
    ]


def _places(stated: Array, bins: int) -> Array:
    return np.minimum((stated * bins).astype(int), bins - 1)


def calibration_error(stated: Sequence[float], right: Sequence[bool], bins: int = BINS) -> float:
    """Expected calibration error: mean distance of confidence and share right over the verdicts.

    >>> round(calibration_error([0.9, 0.9], [True, False]), 3)
    0.4
    """
    said, true = np.asarray(stated, float), np.asarray(right, float)
    gap = np.bincount(_places(said, bins), said - true, bins)
    return float(np.abs(gap).sum() / max(len(said), 1))


def error_interval(
    stated: Sequence[float], right: Sequence[bool], seed: int = 0
) -> tuple[float, float]:
    """95 % bootstrap interval of the expected calibration error."""
    said, true = np.asarray(stated, float), np.asarray(right, bool)
    if not len(said):
        return 0.0, 1.0
    random = np.random.default_rng(seed)
    drawn = random.integers(len(said), size=(DRAWS, len(said)))
    found = [calibration_error(said[row], true[row]) for row in drawn]
    low, high = np.quantile(found, [0.025, 0.975])
    return float(low), float(high)


def error_by_chance(stated: Sequence[float], seed: int = 0) -> float:
    """Mean expected calibration error of as many verdicts whose confidences hold exactly."""
    said = np.asarray(stated, float)
    random = np.random.default_rng(seed)
    drawn = random.random((DRAWS, len(said))) < said
    return float(np.mean([calibration_error(said, row) for row in drawn])) if len(said) else 0.0
