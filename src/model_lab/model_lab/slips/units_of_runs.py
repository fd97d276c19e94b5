"""Runs of which a column is in another unit than in their repeats, has the other sign, or is an
absolute pressure: repeats that reach 0.28 and 28 show it without a model.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import median_filter

from model_lab.aliases import Mask
from model_lab.measurements.at_rest import lowest
from model_lab.measurements.drives import SPIKE
from model_lab.measurements.held_input import DRIVING_COLUMN
from model_lab.measurements.meanings import AMBIENT, air_pressure
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.rules import RULES
from model_lab.slips.columns import (
    Candidate,
    factors_of,
    is_rare,
    stated_unit,
    with_meaning,
    with_units,
)
from softhand_common.documents.quoted import listed

AS_STATED, OPPOSITE = "as stated", "negative"
FEWEST = 2  # one run alone is an odd run


def units_of_runs(data: MeasurementSet) -> Iterator[Candidate]:
    """The slips of runs that differ from their repeats by the factor of a unit, the sign or the
    pressure of the air; at most one for each column.
    """
    driving = DRIVING_COLUMN.get(data.experiment)
    groups = data.groups() if driving else []
    for column in (driving, *data.outputs):
        if column is None or column not in data.runs[0].columns:
            continue
        if column == "pressure":
            absolute = _parted(_absolute(data, column), groups)
            if absolute:
                yield _candidate(data, column, "absolute", absolute)
                continue
        found = [_names_of(data, column, group) for group in groups]
        names = np.full(len(data.runs), AS_STATED, object)
        for group, of_group in zip(groups, found, strict=True):
            names[group] = of_group
        others = sorted(set(names) - {AS_STATED})
        if len(others) == 1 and others[0]:
            runs = _parted(names == others[0], groups)
            if runs:
                yield _candidate(data, column, others[0], runs)


def _parted(other: Mask, groups: Sequence[Sequence[int]]) -> list[int]:
    """Indices of the runs that are `other` (runs,), if some repeats are and some are not."""
    mixed = any(0 < other[group].sum() < len(group) for group in groups)
    runs = np.flatnonzero(other).tolist()
    return runs if mixed and FEWEST <= len(runs) <= len(other) - FEWEST else []


def _absolute(data: MeasurementSet, column: str) -> Mask:
    """Whether the pressures of each run (runs,) begin at that of the air."""
    low, high = RULES.atmosphere
    least = np.array([min(lowest(run.columns[column])) for run in data.runs])
    return np.asarray((least > low) & (least < high))


def _names_of(data: MeasurementSet, column: str, group: Sequence[int]) -> list[str]:
    """What a column of each repeat is: AS_STATED, OPPOSITE, or in a unit; "" where it is none of
    these. As stated is the repeat against which all others are known, else most are as stated.
    """
    misses, least = RULES.unit_of_runs
    read = [data.runs[index].columns[column] for index in group]
    values = [median_filter(value, SPIKE, mode="nearest") for value in read]
    peaks = [(value - value[0])[np.argmax(np.abs(value - value[0]))] for value in values]
    known = {AS_STATED: 1.0, OPPOSITE: -1.0} | {
        unit: 1.0 / factor
        for unit, factor in factors_of(data, column)
        if not is_rare(column, unit) and abs(np.log(factor)) > least
    }
    found = [[_nearest(peak, first, known, misses) for peak in peaks] for first in peaks]
    return max(found, key=lambda names: ("" not in names, names.count(AS_STATED)))


def _nearest(peak: float, usual: float, known: Mapping[str, float], misses: float) -> str:
    """Name of the known factor by which a peak is that of the usual one, or misses it by at most
    this logarithm; "" if there is none.
    """
    for name, factor in known.items():
        ratio = peak / (usual * factor) if usual else 0.0
        if ratio > 0.0 and abs(np.log(ratio)) < misses:
            return name
    return ""


def _candidate(data: MeasurementSet, column: str, name: str, runs: Sequence[int]) -> Candidate:
    """The slip of a column of some runs, by index."""
    alone = replace(data, runs=tuple(data.runs[index] for index in runs))
    said = stated_unit(data, column)
    if name == "absolute":
        air = air_pressure([min(lowest(run.columns[column])) for run in alone.runs])
        mended = with_meaning(alone, (column,), name, air)
        fits, said = "absolute pressure", "gauge pressure"
        how = f"as absolute ones ({AMBIENT} {air / 1e3:.4g} kPa)"
    elif name == OPPOSITE:
        mended = with_meaning(alone, (column,), name)
        fits, said, how, name = f"minus {column}", column, "with the other sign", "sign"
    else:
        factor = dict(factors_of(data, column))[name]
        mended = with_units(alone, (column,), name, factor)
        fits, how, name = name, f"in {name}", "unit"
    changed = list(data.runs)
    for index, run in zip(runs, mended.runs, strict=True):
        changed[index] = run
    names = listed([run.name for run in alone.runs])
    return Candidate(
        name,
        f"{column} of {names}",
        said,
        fits,
        f"runs: import these anew, with readings of {column} {how}, or correct their files",
        replace(data, runs=tuple(changed)),
    )
