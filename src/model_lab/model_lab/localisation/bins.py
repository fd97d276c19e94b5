"""Bins along an axis, and the sums of a residual in them under a bootstrap of blocks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model_lab.aliases import Array, IntArray
from model_lab.localisation.axes import Axis
from model_lab.measurements.sample_table import SampleTable

AXIS_BINS = 12
SMALLEST_BIN = 5  # samples, on the average
EQUAL_VALUES = 1e-8  # of the range
RANKED_SAMPLES = 100_000  # samples from which the edges are taken
BOOTSTRAP_DRAWS = 999
BAND_LEVEL = 95.0  # [percent]


@dataclass(frozen=True)
class Bins:
    """Bins of one axis.

    index (samples,): bin of each sample; -1 where the axis has no value. low, high, center (bins,):
    smallest, largest and mean value of each bin in SI units, rising; for categories, their numbers.
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
    """Divide an axis into bins, none of them empty."""
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
    unit = float(np.ptp(values)) * EQUAL_VALUES or 1.0
    return np.round(values / unit) * unit


def _inner_edges(values: Array, axis: Axis) -> Array:
    """Edges between bins: a value on an edge belongs to the bin above."""
    few = _few_values(values)
    if axis.categories or (few is not None and len(few) <= AXIS_BINS):
        found = np.unique(values) if few is None else few
        return (found[1:] + found[:-1]) / 2.0
    thinned = values[:: max(len(values) // RANKED_SAMPLES, 1)]
    found, times = np.unique(thinned, return_counts=True)
    heavy = found[times > len(thinned) / AXIS_BINS]  # such values get a bin of their own
    rest = thinned[~np.isin(thinned, heavy)]
    count = max(min(AXIS_BINS, len(rest) // SMALLEST_BIN) - len(heavy), 1)
    ranks = np.quantile(rest, np.linspace(0.0, 1.0, count + 1)[1:-1]) if len(rest) else heavy
    return np.unique(np.concatenate([ranks, heavy, np.nextafter(heavy, np.inf)]))


def _few_values(values: Array) -> Array | None:
    """The different values if they may be few, looked up in a part of the samples first."""
    if len(np.unique(values[: 4 * AXIS_BINS * SMALLEST_BIN])) > AXIS_BINS:
        return None
    found = np.unique(values)
    return found if len(found) <= AXIS_BINS else None


@dataclass(frozen=True)
class Curve:
    """Mean residual of one output in each bin of an axis, such as pressure or time.

    mean, low, high (bins,): the mean and the limits of its 95 % band, in SI units; NaN in a bin
    without samples. low and high are NaN, too, if all samples of a bin belong to one block (a run,
    or a part of one), as the band follows from how blocks differ. count (bins,): number of samples.
    """

    mean: Array
    low: Array
    high: Array
    count: IntArray


@dataclass(frozen=True)
class BlockSums:
    """Sums of the residual (value) and numbers of samples (number) in each block, output and bin:
    (blocks, outputs, bins).
    """

    value: Array
    number: Array

    @classmethod
    def of(cls, bins: Bins, table: SampleTable, residual: Array, outputs: int) -> BlockSums:
        """The sums of a residual (samples,) over the blocks of a table. outputs: their number."""
        known = bins.index >= 0
        shape = (int(table.block[-1]) + 1, outputs, bins.count)
        cell = (table.block[known] * outputs + table.output[known]) * bins.count
        cell += bins.index[known]
        size = int(np.prod(shape))
        value = np.bincount(cell, residual[known], size).astype(float)
        number = np.bincount(cell, minlength=size).astype(float)
        return cls(value.reshape(shape), number.reshape(shape))

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return len(self.value)

    def explained(self, sums: Array) -> Array:
        """Sums of squares (draws,) that bin means explain beyond the mean of each output.

        sums (draws, outputs, bins): sums of a residual in the bins, such as `total`; the numbers of
        samples are those of this object.
        """
        number = self.number.sum(axis=0)
        squares = np.sum(sums**2 / np.where(number > 0.0, number, 1.0), axis=-1)
        mean = np.sum(sums, axis=-1) ** 2 / np.maximum(np.sum(number, axis=-1), 1.0)
        return np.sum(squares - mean, axis=-1)

    def total(self) -> Array:
        """Sums of the residual over all blocks, (1, outputs, bins)."""
        return self.value.sum(axis=0, keepdims=True)

    def flipped(self, random: np.random.Generator) -> Array:
        """Sums (draws, outputs, bins) of the residual under the hypothesis that the bins do not
        differ.

        A wild bootstrap: each block takes a sign at random. The sign applies to a block's
        deviations from the bin means of the *other* blocks, so that neither a real dependence nor
        the fitting of the means is taken for noise.
        """
        signs = random.choice((-1.0, 1.0), (BOOTSTRAP_DRAWS, self.blocks))
        return np.tensordot(signs, self._deviations(), 1)

    def signed(self, random: np.random.Generator) -> Array:
        """Sums (draws, outputs, bins) where the whole residual of each block takes a sign at
        random.

        A test with them is exact for any number of blocks, if blocks are independent and their
        residuals symmetric about 0.
        """
        signs = random.choice((-1.0, 1.0), (BOOTSTRAP_DRAWS, self.blocks))
        return np.tensordot(signs, self.value, 1)

    def _deviations(self) -> Array:
        """Sums (blocks, outputs, bins) less those at the bin means of the other blocks."""
        others = self.number.sum(axis=0) - self.number
        mean = (self.value.sum(axis=0) - self.value) / np.where(others > 0.0, others, 1.0)
        return self.value - self.number * mean

    def curves(self, outputs: tuple[str, ...], flipped: Array) -> dict[str, Curve]:
        """Mean residual with its band, by name of the output; flipped: sums as `flipped` returns
        them.
        """
        number = self.number.sum(axis=0)
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = self.value.sum(axis=0) / number
            reach = np.percentile(np.abs(flipped), BAND_LEVEL, axis=0) / number
        reach[np.count_nonzero(self.number, axis=0) < 2] = np.nan
        return {
            name: Curve(
                mean[index],
                mean[index] - reach[index],
                mean[index] + reach[index],
                number[index].astype(np.int64),
            )
            for index, name in enumerate(outputs)
        }
