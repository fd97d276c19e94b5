"""Units of valve pulses that contradict each other.

The model of a pulse has a free factor, so no error shows the unit of a duration or of a mass. What
the readings say of each other does: the integral of the pressure drop is at most its first value
times the duration, air leaves into the atmosphere, and no valve of a hand is wider or narrower than
a few sizes.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from model_lab.aliases import Array
from model_lab.fitting.recording_notices import pulse_shares
from model_lab.measurements.measurement_set import INFLATE, MeasurementSet
from model_lab.rules import RULES
from model_lab.slips.columns import (
    Candidate,
    column_mend,
    factors_of,
    is_rare,
    stated_unit,
    with_units,
)

PULSE_PRESSURES, INTEGRALS = ("p_in", "p_out"), ("friction_integral", "injector_integral")
PULSE_GROUPS = (
    ("duration",),
    INTEGRALS,
    PULSE_PRESSURES,
    ("duration", *INTEGRALS),
    (*PULSE_PRESSURES, *INTEGRALS),
    ("mass",),
)
"""Columns whose unit is mistaken together, those of a single kind first."""


def contradict(data: MeasurementSet) -> bool:
    """Whether the columns of a set of pulses cannot all be in the units that are stated."""
    return data.experiment == "valve_pulse" and not _agree(data)


def agreeing_units(data: MeasurementSet) -> list[Candidate]:
    """Units of some columns with which all columns of a set of pulses agree. First are common ones,
    of these the one that leaves the integrals of pressure drops nearest to their largest values.
    """
    found = [candidate for candidate in _other_units(data) if _agree(candidate.mended)]
    return sorted(found, key=lambda one: (one.rare, round(_distance(one.mended), 6)))


def _other_units(data: MeasurementSet) -> Iterator[Candidate]:
    """Groups of columns in each other usual unit, by one factor for a group."""
    groups = (
        tuple(name for name in group if all(name in run.columns for run in data.runs))
        for group in PULSE_GROUPS
    )
    for columns in filter(None, dict.fromkeys(groups)):
        known = {name: factors_of(data, name) for name in columns}
        for unit, factor in known[columns[0]]:
            units = {name: _unit_by(factor, known[name], unit) for name in columns}
            if "" in units.values():
                continue
            mended = data
            for name, other in units.items():
                mended = with_units(mended, (name,), other, factor)
            yield Candidate(
                "unit",
                ", ".join(columns),
                ", ".join(dict.fromkeys(stated_unit(data, name) for name in columns)),
                ", ".join(dict.fromkeys(units.values())),
                column_mend(data, {name: {"unit": other} for name, other in units.items()}),
                mended,
                rare=is_rare(columns[0], unit),
            )


def _unit_by(factor: float, known: list[tuple[str, float]], like: str) -> str:
    """The unit of some with a factor, if there are several the one that names a unit `like` it; ""
    if there is none.

    >>> _unit_by(1e-3, [("Pa*s", 1e-3), ("kPa*ms", 1e-3)], "ms")
    'kPa*ms'
    """
    units = [unit for unit, by in known if np.isclose(by, factor)]
    return max(units, key=lambda unit: like in unit.split("*"), default="")


def _agree(data: MeasurementSet) -> bool:
    """Whether all that the columns of pulses say of each other lies in its usual range."""
    duration, p_in, p_out = (data.column(name) for name in ("duration", *PULSE_PRESSURES))
    leaving = data.column("direction") != INFLATE
    with np.errstate(all="ignore"):  # the model refuses durations of 0
        ranges = (
            (pulse_shares(data), RULES.pulse_shares),
            (duration, RULES.pulse_durations),
            (np.abs(data.table.value) / (p_in * duration), RULES.conductances),
            (p_out[leaving], RULES.atmosphere),
        )
    return all(_is_within(values, limits) for values, limits in ranges)


def _is_within(values: Array, limits: tuple[float, float]) -> bool:
    """Whether the median of values (n,) lies between two limits, or is not known."""
    known = values[np.isfinite(values)]
    return not len(known) or limits[0] <= float(np.median(known)) <= limits[1]


def _distance(data: MeasurementSet) -> float:
    """How far, as a logarithm, the integrals of pressure drops are from their largest values."""
    shares = pulse_shares(data)
    return abs(float(np.log(np.median(shares)))) if len(shares) else 0.0
