"""Where a model fails: its residual against every axis, with bands and a test by runs.

The residual is averaged in bins along each axis. Runs are the units that are drawn: the bands, and
the test whether the means differ by more than chance, come from a wild bootstrap that turns the
signs of whole runs. With few runs each is cut into blocks, and `basis`
says so: then what differs between runs by mere scatter counts as found.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_lab.axes import Axis, axes_of
from model_lab.binning import Bins, make_bins
from model_lab.block_sums import BlockSums, Curve, SampleLayout, layout_of
from model_lab.measurement import MeasurementSet
from model_lab.where import where_phrase

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

SIGNIFICANCE = 0.05  # over all axes together
SMALLEST_SHARE = 0.02
RUNS, RUN_BLOCKS = "runs", "blocks of runs"


@dataclass(frozen=True)
class Dependence:
    """How a residual varies with one axis.

    where: the part of the axis in which the model fails most. p_value: of the null hypothesis that
    the residual does not depend on the axis. share_of_error: of the residual's mean square that the
    bin means explain about the overall mean, less what chance would. basis: what is drawn at
    random. curves: by output.
    """

    bins: Bins
    where: str
    p_value: float
    share_of_error: float
    basis: str
    curves: Mapping[str, Curve]

    @property
    def against(self) -> str:
        """Name of the axis."""
        return self.bins.axis.name


@dataclass(frozen=True)
class Localisation:
    """A residual against all axes, the largest share of the error first.

    constant: share of the residual's mean square that its overall mean makes up.
    """

    axes: tuple[Dependence, ...]
    constant: float

    @property
    def failures(self) -> tuple[Dependence, ...]:
        """The axes against which the residual varies beyond chance, tested all together."""
        level = SIGNIFICANCE / max(len(self.axes), 1)
        return tuple(
            axis
            for axis in self.axes
            if axis.p_value <= level and axis.share_of_error >= SMALLEST_SHARE
        )


def localise(data: MeasurementSet, residual: Array, seed: int = 0) -> Localisation:
    """The residual (samples,) of a model against every axis along which the set varies.

    The samples are laid out run by run, within them output by output. Same seed, same answer.
    Raises ValueError when the residual does not fit the set.
    """
    samples = sum(run.samples for run in data.runs) * len(data.outputs)
    if residual.shape != (samples,):
        raise ValueError(f"residual: expected shape ({samples},), got {residual.shape}")
    layout = layout_of(data)
    axes = [_dependence(data, layout, axis, residual, seed) for axis in axes_of(data)]
    axes.sort(key=lambda axis: -axis.share_of_error)
    means = np.bincount(layout.output, residual) / np.bincount(layout.output)
    mean_square = float(np.mean(residual**2))
    constant = float(np.mean(means[layout.output] ** 2)) / mean_square if mean_square else 0.0
    return Localisation(tuple(axes), constant)


def _dependence(
    data: MeasurementSet, layout: SampleLayout, axis: Axis, residual: Array, seed: int
) -> Dependence:
    bins = make_bins(axis)
    sums = BlockSums.of(bins, layout, residual, len(data.outputs))
    turned = sums.turned(np.random.default_rng(seed))
    null = sums.explained(turned)
    observed = float(sums.explained(sums.total())[0])
    total = float(np.sum(residual**2))
    chance = float(null.mean())
    share = (observed - chance) / (total - chance) if total > chance else 0.0
    p_value = (1 + int(np.sum(null >= observed * (1.0 - 1e-9)))) / (1 + len(null))
    basis = RUNS if layout.blocks_are_runs else RUN_BLOCKS
    curves = sums.curves(data.outputs, turned)
    counts = np.stack([curve.count for curve in curves.values()])
    means = np.nan_to_num(np.stack([curve.mean for curve in curves.values()]))
    energy = np.sum(counts * means**2, axis=0)
    where = where_phrase(bins, energy, counts.sum(axis=0))
    return Dependence(bins, where, p_value, max(share, 0.0), basis, curves)
