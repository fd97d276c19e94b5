"""Bins along an axis: by rank where values are many, one for each value where they are few."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_lab.axes import Axis

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

BINS = 12
SMALLEST_BIN = 5  # samples, on the average
SAME = 1e-8  # of the range
RANKED = 100_000  # samples from which the edges are taken


@dataclass(frozen=True)
class Bins:
    """Bins of one axis: index (samples,) of each sample's, -1 where the axis has no value.

    low, high, center (bins,): smallest, largest and mean value of each in SI units, rising, or the
    numbers of categories.
    """

    axis: Axis
    index: IntArray
    low: Array
    high: Array
    center: Array

    @property
    def count(self) -> int:
        """Number of bins."""
        return len(self.low)


def make_bins(axis: Axis) -> Bins:
    """Bins of an axis, none of them empty."""
    known = np.isfinite(axis.values)
    values = axis.values[known]
    place = np.searchsorted(_inner_edges(_rounded(values), axis), _rounded(values), side="right")
    number = np.bincount(place)
    used = np.flatnonzero(number)
    index = np.full(len(axis.values), -1, dtype=np.int64)
    index[known] = (np.cumsum(number > 0) - 1)[place]
    members = [values[place == each] for each in used]
    low, high, center = (
        np.array([float(of(part)) for part in members]) for of in (np.min, np.max, np.mean)
    )
    return Bins(axis, index, low, high, center)


def _rounded(values: Array) -> Array:
    """Values without the last digits, in which those that should be alike may differ."""
    unit = float(np.ptp(values)) * SAME or 1.0
    return np.round(values / unit) * unit


def _inner_edges(values: Array, axis: Axis) -> Array:
    """Edges between bins: a value on an edge belongs to the bin above."""
    few = _few_values(values)
    if axis.categories or (few is not None and len(few) <= BINS):
        found = np.unique(values) if few is None else few
        return (found[1:] + found[:-1]) / 2.0
    thinned = values[:: max(len(values) // RANKED, 1)]
    found, times = np.unique(thinned, return_counts=True)
    heavy = found[times > len(thinned) / BINS]  # such values get a bin of their own
    rest = thinned[~np.isin(thinned, heavy)]
    count = max(min(BINS, len(rest) // SMALLEST_BIN) - len(heavy), 1)
    ranks = np.quantile(rest, np.linspace(0.0, 1.0, count + 1)[1:-1]) if len(rest) else heavy
    return np.unique(np.concatenate([ranks, heavy, np.nextafter(heavy, np.inf)]))


def _few_values(values: Array) -> Array | None:
    """The different values if they may be few, looked up in a part of the samples first."""
    if len(np.unique(values[: 4 * BINS * SMALLEST_BIN])) > BINS:
        return None
    found = np.unique(values)
    return found if len(found) <= BINS else None
