"""Outliers: single readings far from those around them, as from a tracker that jumps.

A few of them outweigh all else in a sum of squares. They are found in the recording, without a
model: a sample is wild if it is far from what its neighbours predict, which agree with each other
(after Hampel, 1974), unless the input jumps there too. It is replaced by what the neighbours
predict.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from model_lab.aliases import Array, Mask
from model_lab.measurements.measurement_set import MeasurementSet, Run, WildSample
from model_lab.measurements.preprocess import NORMAL_MEDIAN, noise_of
from model_lab.rules import RULES

NEIGHBOURS = 3  # neighbours on either side
EXPERIMENTS_WITH_WILD_SAMPLES = ("free_bending", "blocked_tip", "uniaxial", "rubber")


def without_wild_samples(data: MeasurementSet, predicted: Array | None = None) -> MeasurementSet:
    """The set with outliers replaced; its field `wild` lists them.

    predicted (samples,): predictions of a model. If they are given, wild samples are sought in the
    residual, as only there they show where readings change fast.
    """
    if not data.has_time or data.experiment not in EXPERIMENTS_WITH_WILD_SAMPLES:
        return data
    (output,) = data.outputs
    if any(not np.isfinite(run.columns.get(output, np.nan)).all() for run in data.runs):
        return data
    ends = np.cumsum([run.samples for run in data.runs])
    said = np.zeros(ends[-1]) if predicted is None else predicted
    models = np.split(said, ends[:-1])
    judged = [_wild_of(*given, output, data, 1) for given in zip(data.runs, models, strict=True)]
    if len(data.wild) + sum(wild.sum() for _, wild in judged) > RULES.wild_pairs * ends[-1]:
        judged = [
            _wild_of(*given, output, data, 2) for given in zip(data.runs, models, strict=True)
        ]
    found, runs = list(data.wild), []
    for number, (run, (moved, wild)) in enumerate(zip(data.runs, judged, strict=True)):
        found += [WildSample(number, int(at), float(moved[at])) for at in np.flatnonzero(wild)]
        readings = run.columns[output] + np.where(wild, moved, 0.0)
        runs.append(replace(run, columns={**run.columns, output: readings}))
    return replace(data, runs=tuple(runs), wild=tuple(found)) if len(found) else data


def _wild_of(
    run: Run, model: Array, output: str, data: MeasurementSet, together: int
) -> tuple[Array, Mask]:
    """What to add to each reading (samples,) to get the prediction of its neighbours, and which are
    wild; up to so many `together`.
    """
    readings = run.columns[output] - model
    if run.samples < RULES.wild_samples:
        return readings, np.zeros(run.samples, bool)
    middle, wild = _far_off(readings, together)
    if not model.any():
        wild[[0, -1]] = False  # a course may begin or end with a jump
    if wild.any():
        wild &= ~_far_off(data.driving(run), together)[1]
    return middle - readings, wild & (wild.mean() <= RULES.most_wild)


def _far_off(values: Array, together: int) -> tuple[Array, Mask]:
    """What a straight line through the neighbours, by the median of slopes (Theil and Sen), says of
    values (samples,) that are far from those beside them, and which are far from it.
    """
    low, high = np.percentile(values, [2.0, 98.0])
    least = max(RULES.wild_noise * noise_of(values), RULES.wild_range * (high - low))
    around = sliding_window_view(np.pad(values, NEIGHBOURS, mode="reflect"), 2 * NEIGHBOURS + 1)
    middle, wild = values.copy(), np.zeros(len(values), bool)
    beside = _beside(np.abs(values[:, None] - around), together)
    asked = np.flatnonzero(beside > RULES.wild_alone * least)
    values, around = values[asked], around[asked]
    places = np.delete(np.arange(-NEIGHBOURS, NEIGHBOURS + 1.0), NEIGHBOURS)
    neighbours = np.delete(around, NEIGHBOURS, axis=1)
    first, second = np.triu_indices(2 * NEIGHBOURS, 1)
    slopes = (neighbours[:, second] - neighbours[:, first]) / (places[second] - places[first])
    level = neighbours - np.median(slopes, axis=1)[:, None] * places
    middle[asked] = np.median(level, axis=1)
    spread = NORMAL_MEDIAN * np.median(np.abs(level - middle[asked, None]), axis=1)
    off = values - middle[asked]
    apart = (values[:, None] - around) * np.sign(off)[:, None]
    alone = _beside(apart, together) > RULES.wild_alone * np.abs(off)
    wild[asked] = alone & (np.abs(off) > np.maximum(RULES.wild_spread * spread, least))
    return middle, wild


def _beside(apart: Array, together: int) -> Array:
    """How far values are apart from those beside them, on the side where that is less."""
    before, after = (
        apart[:, NEIGHBOURS - together : NEIGHBOURS],
        apart[:, NEIGHBOURS + 1 : NEIGHBOURS + 1 + together],
    )
    return np.minimum(before.max(axis=1), after.max(axis=1))
