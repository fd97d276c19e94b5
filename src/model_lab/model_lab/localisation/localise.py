"""Localisation of a misfit: the residual against every axis, with bands, a test and a phrase.

The residual is averaged in bins along each axis. Randomness is by runs: the bands, and the test
whether the means differ by more than chance, come from a wild bootstrap that flips the signs of
whole runs. With few runs each is cut into blocks, and `basis` says so: then differences between
runs that are only scatter may count as found.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from model_lab.aliases import Array, IntArray
from model_lab.localisation.axes import COURSES, MARKER, Axis, axes_of
from model_lab.localisation.bins import BOOTSTRAP_DRAWS, Bins, BlockSums, Curve, make_bins
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.units import Display
from model_lab.rules import RULES

MOST_DIGITS = 6
ORDINALS = {1: "first", 2: "second", 3: "third"}
RUNS, RUN_BLOCKS = "runs", "blocks of runs"


def where_phrase(bins: Bins, error: Array, count: IntArray) -> str:
    """Where on an axis the error lies, as a phrase such as `above 41 kPa`.

    Args:
        bins: the bins of the axis.
        error: sum of squares (bins,) of the mean residual in each bin.
        count: number of samples (bins,) in each bin.
    """
    if not error.sum() > 0.0:
        return "nowhere"
    excess = error / error.sum() - count / count.sum()
    if bins.axis.categories:
        return _category_phrase(bins.axis, excess)
    if bins.count < 2:
        return "everywhere"
    part = _part(excess)
    if part.gain < RULES.part_share:
        return "everywhere"
    if bins.axis.name == "run_order":
        return _run_phrase(bins, part)
    below, above = _edge(bins, part.first), _edge(bins, part.last + 1)
    return _range_phrase(bins.axis, below, above, part.outside)


@dataclass(frozen=True)
class _Part:
    """Neighbouring bins first..last, or all the others (`outside`), and how far they stand out."""

    first: int
    last: int
    outside: bool
    gain: float


def _part(excess: Array) -> _Part:
    """The part of the axis that stands out most; best one that reaches from an end to an edge."""
    count = len(excess)
    total = np.concatenate([[0.0], np.cumsum(excess)])
    parts = [
        _Part(first, last, outside, float(total[last + 1] - total[first]) * (-1 if outside else 1))
        for first in range(count)
        for last in range(first, count)
        for outside in (False, True)
        if (first, last) != (0, count - 1) and not (outside and (first == 0 or last == count - 1))
    ]
    at_end = [part for part in parts if part.first == 0 or part.last == count - 1]
    best, simple = (max(some, key=lambda part: part.gain) for some in (parts, at_end))
    return best if best.gain > simple.gain + RULES.part_inside_share else simple


def _edge(bins: Bins, index: int) -> float | None:
    """Value between the bins index - 1 and index; None at the ends of the axis."""
    if index in (0, bins.count):
        return None
    return float(bins.high[index - 1] + bins.low[index]) / 2.0


def _range_phrase(axis: Axis, below: float | None, above: float | None, outside: bool) -> str:
    """A part of an axis with a scale, from `below` to `above`, open where one is None."""
    if axis.name == "time_since_step" and axis.noun != "pulse duration":
        return _since_phrase(below, above, outside)
    named = axis.name in ("pressure", "pressure_rate", "temperature")
    words = _range_words(axis.display, below, above, outside)
    return words if named else f"{axis.noun} {words}"


def _range_words(display: Display, below: float | None, above: float | None, outside: bool) -> str:
    """Such as `above 41 kPa`; two numbers get as many digits as they need to differ."""
    digits = 2
    if below is not None and above is not None:
        while digits < MOST_DIGITS and display.number(below, digits) == display.number(
            above, digits
        ):
            digits += 1
    low, high = (
        None if value is None else display.number(value, digits) for value in (below, above)
    )
    if low is None:
        words = f"below {high}"
    elif high is None:
        words = f"above {low}"
    else:
        words = f"below {low} or above {high}" if outside else f"between {low} and {high}"
    return f"{words} {display.unit}".rstrip()


def _since_phrase(below: float | None, above: float | None, outside: bool) -> str:
    if below is None and above is not None:
        return f"within {above:.2g} s of a step"
    if above is None and below is not None:
        return f"later than {below:.2g} s after a step"
    words = f"between {below:.2g} and {above:.2g} s after a step"
    return f"except {words}" if outside else words


def _run_phrase(bins: Bins, part: _Part) -> str:
    first, last = round(bins.low[part.first]), round(bins.high[part.last])
    if first == last:
        words = f"{ORDINALS[first]} run" if first in ORDINALS else f"run {first}"
    elif part.first == 0:
        words = f"first {last} runs"
    else:
        words = f"runs {first} to {last}"
    return f"{'all but ' if part.outside else ''}{words} of each specimen"


def _category_phrase(axis: Axis, excess: Array) -> str:
    order = np.argsort(-excess)
    chosen = [int(index) for index in order if excess[index] > 0.0][: RULES.part_names]
    total = 0.0
    for kept, index in enumerate(chosen, start=1):
        total += excess[index]
        if total >= RULES.part_share and total >= RULES.part_covered * excess[excess > 0.0].sum():
            return _named(axis, sorted(chosen[:kept]))
    return "everywhere"


def _named(axis: Axis, chosen: list[int]) -> str:
    names = [axis.categories[index] for index in chosen]
    listed = " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
    if axis.name == "direction":
        subject = f"{axis.noun} " if axis.categories == COURSES else ""
        return f"while {subject}{' or '.join(names)}"
    if axis.name == "mount":
        return f"mounted {listed.replace('_', ' ')}"
    return f"{axis.name}{'s' if len(names) > 1 else ''} {listed}"


@dataclass(frozen=True)
class Dependence:
    """How a residual varies with one axis.

    where: the part of the axis in which the model fails most, as a phrase. p_value: of the null
    hypothesis that the residual does not depend on the axis. share_of_error: share of the mean
    square residual that the bin means explain beyond the overall mean, less what chance would
    explain. basis: what is drawn at random, runs or blocks of runs. exact_p_value: by an exact test
    with random signs of whole runs; None if blocks are drawn. `p_value` detects more but is
    approximate. curves: mean residual along the axis, by output.
    """

    bins: Bins
    where: str
    p_value: float
    share_of_error: float
    basis: str
    exact_p_value: float | None
    curves: Mapping[str, Curve]

    @property
    def against(self) -> str:
        """Name of the axis."""
        return self.bins.axis.name


@dataclass(frozen=True)
class Localisation:
    """How a residual varies with each axis, the largest share of the error first.

    constant: share (0 to 1) of the mean square residual that its means over each output make up.
    """

    axes: tuple[Dependence, ...]
    constant: float

    @property
    def failures(self) -> tuple[Dependence, ...]:
        """The axes with which the residual varies beyond chance, with a p-value corrected for the
        number of axes.
        """
        level = RULES.failure_p_value / max(len(self.axes), 1)
        return tuple(
            axis
            for axis in self.axes
            if axis.p_value <= level and axis.share_of_error >= RULES.failure_share
        )

    @property
    def certain_failures(self) -> tuple[Dependence, ...]:
        """The axes that disprove a model even if its error is within the noise floor: the residual
        varies with them strongly, and far beyond chance by the exact test. The approximate test
        does not suffice, as zeros and gains that scatter from run to run can look like a
        dependence.
        """
        return tuple(
            axis
            for axis in self.axes
            if axis.exact_p_value is not None
            and axis.exact_p_value <= RULES.axis_p_value
            and axis.share_of_error >= RULES.axis_share
        )


def localise(data: MeasurementSet, residual: Array, seed: int = 0) -> Localisation:
    """How the residual (samples,) of a model varies with every axis along which the set varies.

    seed: seed of the random draws; the same seed gives the same answer. Raises ValueError if the
    residual does not have the shape (samples,) of the set.
    """
    table = data.table
    if residual.shape != (table.samples,):
        raise ValueError(f"residual: expected shape ({table.samples},), got {residual.shape}")
    axes = [
        (_of_markers if axis.name == MARKER else _dependence)(data, axis, residual, seed)
        for axis in axes_of(data)
    ]
    axes.sort(key=lambda axis: -axis.share_of_error)
    means = np.bincount(table.output, residual) / np.bincount(table.output)
    mean_square = float(np.mean(residual**2))
    constant = float(np.mean(means[table.output] ** 2)) / mean_square if mean_square else 0.0
    return Localisation(tuple(axes), constant)


def _dependence(data: MeasurementSet, axis: Axis, residual: Array, seed: int) -> Dependence:
    bins = make_bins(axis)
    sums = BlockSums.of(bins, data.table, residual, len(data.outputs))
    flipped = sums.flipped(np.random.default_rng(seed))
    null = sums.explained(flipped)
    observed = float(sums.explained(sums.total())[0])
    total = float(np.sum(residual**2))
    chance = float(null.mean())
    share = (observed - chance) / (total - chance) if total > chance else 0.0
    p_value = _p_value(observed, null)
    exact = None
    if data.table.blocks_are_runs:
        exact = _p_value(observed, sums.explained(sums.signed(np.random.default_rng(seed))))
    basis = RUNS if data.table.blocks_are_runs else RUN_BLOCKS
    curves = sums.curves(data.outputs, flipped)
    counts = np.stack([curve.count for curve in curves.values()])
    means = np.nan_to_num(np.stack([curve.mean for curve in curves.values()]))
    energy = np.sum(counts * means**2, axis=0)
    where = where_phrase(bins, energy, counts.sum(axis=0))
    return Dependence(bins, where, p_value, max(share, 0.0), basis, exact, curves)


def _of_markers(data: MeasurementSet, axis: Axis, residual: Array, seed: int) -> Dependence:
    """How much markers differ in their mean squares, the share of these that is above the mean of
    all; the test exchanges the markers of each run.
    """
    bins, table, random = make_bins(axis), data.table, np.random.default_rng(seed)
    sums = BlockSums.of(bins, table, residual, len(data.outputs))
    cell = table.run * bins.count + bins.index
    of_runs = np.bincount(cell, residual**2, table.runs * bins.count).reshape(table.runs, -1)
    number = np.bincount(bins.index)
    drawn = [random.permuted(of_runs, axis=1).sum(axis=0) for _ in range(BOOTSTRAP_DRAWS)]
    energy = of_runs.sum(axis=0)
    p_value = _p_value(float(np.var(energy)), np.var(drawn, axis=1))
    above = energy / max(float(energy.sum()), 1e-300) - number / number.sum()
    share = float(above[above > 0.0].sum())
    basis = RUNS if table.blocks_are_runs else RUN_BLOCKS
    curves = sums.curves(data.outputs, sums.flipped(random))
    where = where_phrase(bins, energy, number)
    return Dependence(bins, where, p_value, share, basis, None, curves)


def _p_value(observed: float, null: Array) -> float:
    return (1 + int(np.sum(null >= observed * (1.0 - 1e-9)))) / (1 + len(null))
