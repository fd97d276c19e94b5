"""Inputs whose sensor was at its limit, and sets without the samples in which it was."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.ndimage import median_filter

from model_lab.aliases import Array, Mask
from model_lab.measurements.held_input import DRIVING_COLUMN
from model_lab.measurements.measurement_set import MeasurementSet, Run
from model_lab.rules import RULES


@dataclass(frozen=True)
class Limit:
    """The limit of the sensor of an input, in SI units. runs: how far the output goes on while the
    input stays there, in its SI unit, by the index of a run in which that is seen.
    """

    reading: float
    runs: Mapping[int, float]


def limit_reached(data: MeasurementSet, noise: float) -> Limit | None:
    """The largest reading of an input, if it stays there in a run while the output goes on by far
    more than its noise and comes back.
    """
    if not data.has_time or data.experiment not in DRIVING_COLUMN or len(data.outputs) > 1:
        return None
    largest = max(float(np.max(data.driving(run))) for run in data.runs)
    found = {}
    for index, run in enumerate(data.runs):
        output = run.columns[data.outputs[0]]
        ways = [
            _goes_on(output[start:stop])
            for start, stop, at in _stretches(_at(data.driving(run), largest))
            if at and stop - start >= RULES.notice_clipped
        ]
        most = max(ways, default=0.0)
        if most > RULES.notice_wild * noise:
            found[index] = most
    return Limit(largest, found) if found else None


def _at(readings: Array, limit: float) -> Mask:
    """Which readings (n,) are at the limit."""
    return np.asarray(readings >= (1.0 - RULES.notice_clip_within) * limit)


def _stretches(marked: Mask) -> list[tuple[int, int, bool]]:
    """Start and end of neighbouring samples that are alike in a mask (n,), and whether marked."""
    edges = [0, *(np.flatnonzero(np.diff(marked)) + 1).tolist(), len(marked)]
    return [(start, stop, bool(marked[start])) for start, stop in pairwise(edges)]


def _goes_on(output: Array) -> float:
    """How far an output (n,) goes from the line between its ends, for more than a sample or two; 0
    if it does not come back.
    """
    output = median_filter(output, RULES.limit_median, mode="nearest")
    farthest = float(np.max(np.abs(output - np.linspace(output[0], output[-1], len(output)))))
    comes_back = abs(output[-1] - output[0]) < RULES.notice_clip_back * farthest
    return farthest if comes_back else 0.0


def within_limit(data: MeasurementSet, limit: float) -> MeasurementSet:
    """The set without samples whose input is at the limit of its sensor. What lies between two such
    times is a run of its own, driven with all that was read before.
    """
    if not np.isfinite(limit) or data.experiment not in DRIVING_COLUMN or not data.has_time:
        return data
    parts = tuple(part for run in data.runs for part in _parts(data, run, limit))
    return replace(data, runs=parts) if parts else data


def _parts(data: MeasurementSet, run: Run, limit: float) -> list[Run]:
    beyond = _at(data.driving(run), limit)
    if not beyond.any():
        return [run]
    inputs = ("time", DRIVING_COLUMN[data.experiment])
    kept = [
        (start, stop)
        for start, stop, at in _stretches(beyond)
        if not at and stop - start >= RULES.limit_part
    ]
    parts = []
    for number, (start, stop) in enumerate(kept, 1):
        columns = {name: values[start:stop] for name, values in run.columns.items()}
        before = {
            name: np.concatenate([run.lead.get(name, values[:0]), values[:start]])
            for name, values in run.columns.items()
            if name in inputs
        }
        lead = before if len(before["time"]) else {}
        part = f", part {number}"
        parts.append(
            replace(
                run,
                name=f"{run.name}{part}",
                protocol=f"{run.protocol}{part}",
                columns=columns,
                lead=lead,
            )
        )
    return parts
