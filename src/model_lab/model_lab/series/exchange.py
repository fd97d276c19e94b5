"""Two runs whose specimens were confused: if they are exchanged, repeats agree far better.

For example, two plugs are exchanged during one run of each specimen. With two repeats of each,
neither run can be called odd; but an exchange has no free parameter, so the scatter that is left
after it tests it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from model_lab.aliases import Array, IntArray
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.series.run_scale import OUTPUT_SCALE, as_good, run_values, within_groups

NORMAL_DRAWS = 9999  # simulated series of normal scatter


def exchanged_pair(
    data: MeasurementSet, residual: Array, group: IntArray
) -> tuple[tuple[int, int], float] | None:
    """Find the two runs of different specimens after whose exchange the scales of repeats agree
    best.

    Returns their indices, and the p-value under the null hypothesis that repeats scatter normally
    and specimens are alike; None if no two runs can be exchanged, or no exchange improves the
    agreement. If several pairs do equally well, as with two repeats each, it is the pair that
    differs most from the other runs.

    residual (samples,): of a model. group (runs,): number of the group of repeats of each run.
    """
    pairs, table, predicted = _pairs(data, group), data.table, data.table.value - residual

    def scales(measured: Array) -> list[Array]:
        every = run_values(table, measured, predicted, data.of_hand)
        return [one.values for one in every if one.quantity == OUTPUT_SCALE]

    as_stated = scales(table.value)
    if not pairs or not as_stated:
        return None
    (stated,) = as_stated
    left = _scatter(
        np.concatenate([scales(_swapped(data, table.value, pair)) for pair in pairs]), group
    )
    before = float(_scatter(stated, group))
    least = float(left.min())
    if not least < before:
        return None
    freedom = len(group) - len(np.unique(group))
    alike = [pair for pair, rest in zip(pairs, left, strict=True) if as_good(rest, least, freedom)]
    about = np.abs(stated - np.median(stated))
    chosen = max(alike, key=lambda pair: about[list(pair)].sum())
    return chosen, _p_value(least / before, pairs, group)


def _p_value(share: float, pairs: Sequence[tuple[int, int]], group: IntArray) -> float:
    """Chance that the best of all exchanges leaves such a share of the scatter of normal values."""
    drawn = np.random.default_rng(0).standard_normal((NORMAL_DRAWS, len(group)))
    whole, count = _scatter(drawn, group), np.bincount(group)
    mean = np.stack([drawn[:, group == each].mean(axis=1) for each in range(len(count))])
    least = whole
    for first, other in pairs:
        one, two = group[first], group[other]
        change = drawn[:, other] - drawn[:, first]
        moved = 2.0 * (mean[one] - mean[two]) + change * (1.0 / count[one] + 1.0 / count[two])
        least = np.minimum(least, whole - change * moved)
    return float((1 + np.sum(least <= share * whole)) / (1 + NORMAL_DRAWS))


def _pairs(data: MeasurementSet, group: IntArray) -> list[tuple[int, int]]:
    """Runs of one protocol and as many samples, of two specimens, each with repeats."""
    runs, repeats = data.runs, np.bincount(group)[group]
    has = [set(data.outputs) <= set(run.columns) for run in runs]
    return [
        (i, j)
        for i, j in combinations(range(len(runs)), 2)
        if runs[i].protocol == runs[j].protocol
        and runs[i].specimen != runs[j].specimen
        and runs[i].samples == runs[j].samples
        and min(repeats[i], repeats[j]) > 1
        and has[i]
        and has[j]
    ]


def _swapped(data: MeasurementSet, measured: Array, pair: tuple[int, int]) -> Array:
    """Measured outputs (samples,) with those of two runs exchanged."""
    run = data.table.run
    first, other = (np.flatnonzero(run == index) for index in pair)
    swapped = measured.copy()
    swapped[first], swapped[other] = measured[other], measured[first]
    return swapped


def _scatter(values: Array, group: IntArray) -> Array:
    """Sum of squares (...,) of values (..., runs) about the means of their repeats."""
    return np.asarray(np.sum(within_groups(values, group) ** 2, axis=-1))
