"""What an imported set states of its columns: units, and which pressures are absolute."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from model_lab.aliases import Array
from model_lab.importing.many_columns import gauge_entries
from model_lab.importing.runs import ImportedRun, Source
from model_lab.importing.units import ABSOLUTE, GAUGE
from model_lab.measurements.at_rest import lowest
from model_lab.measurements.meanings import AMBIENT, air_pressure
from model_lab.measurements.measurement_set import SAME_TEMPERATURE, TEMPERATURE
from model_lab.measurements.rows import TEMPERATURES
from model_lab.measurements.units import column_unit
from model_lab.rules import RULES
from softhand_common.documents.yaml_document import DocumentError

TEMPERATURE_IN_NAME = re.compile(
    r"(?:^|[\W_])(?P<sign>(?<=[_ ])-)?(?P<degrees>\d{1,3}(?:[.,p]\d+)?)"
    r"(?:_?(?:deg|grad|\u00b0)_?)?C(?![^\W_])"
    r"|temp(?:erature?)?[_\- ]?(?P<after>\d{1,3})(?![^\W_])",
    re.I,
)  # of a run, in degrees Celsius
AIR_COLUMN = "pressure"  # which may be absolute
KELVIN = 273.15  # [K], 0 degC
MEANS_A_RUN = 10  # temperatures of a run that are compared
NOT_CONVERTED = ("time", "strain", "stretch", "temperature")  # in SI units, or with an offset
Columns = dict[str, dict[str, object]]
"""The entry of each column under `columns` of a set."""


def in_one_unit(sources: Sequence[Source]) -> tuple[list[Source], list[str]]:
    """(the same files, each quantity in the unit of the first file that has it, what was converted
    as sentences).
    """
    units: dict[str, str] = {}
    found, said = [], []
    for source in sources:
        meanings = []
        for meant in source.meanings:
            unit, first = meant.unit, units.setdefault(meant.quantity, meant.unit or "")
            if unit and first and unit != first and meant.quantity not in NOT_CONVERTED:
                one, other = (column_unit(meant.quantity, name) for name in (unit, first))
                meant = replace(meant, unit=first, scale=meant.scale * one.scale / other.scale)
                said.append(
                    f"{source.table.path.name}: {meant.quantity} is in {unit}, and was converted "
                    f"to {first} as in the other files"
                )
            meanings.append(meant)
        found.append(replace(source, meanings=tuple(meanings)))
    return found, said


def columns_of(sources: Sequence[Source], runs: Sequence[ImportedRun]) -> Columns:
    """The entries of all columns of the runs in experiment.yaml. Raises DocumentError if files have
    different units.
    """
    columns: Columns = {name: {"unit": unit} for name, unit in _units(sources, runs).items()}
    gauge: Columns = {
        name: {"unit": unit, "is": GAUGE} for name, unit in gauge_entries(sources).items()
    }
    return columns | _absolute(sources, runs) | gauge


def temperatures_of(runs: Sequence[ImportedRun], sources: Sequence[Source]) -> dict[str, float]:
    """Mean temperature [K] of each run whose files have a column of it, by the name of the run."""
    by_file = {source.table.path: source for source in sources}
    found = {}
    for run in runs:
        for source in (by_file[path] for path in run.files if path in by_file):
            meant = next((one for one in source.meanings if one.quantity == "temperature"), None)
            if meant is None or not meant.unit or np.isnan(source.values_of(meant)).all():
                continue
            values = column_unit("temperature", meant.unit).to_si(source.values_of(meant))
            kelvin = float(np.nanmean(values))
            if TEMPERATURES[0] <= kelvin <= TEMPERATURES[1]:
                found[run.name] = round(kelvin, 2)
    return found


def with_temperatures(
    runs: Sequence[ImportedRun], sources: Sequence[Source], needed: Sequence[str]
) -> tuple[ImportedRun, ...]:
    """The runs with a column of their temperature, if all were recorded with it and it changes
    within one by so much that it would be no repeat.
    """
    by_file = {source.table.path: source for source in sources}
    found, most = [], 0.0
    for run in runs:
        members = [by_file[path] for path in run.files if path in by_file]
        course = _temperature_of(members, needed)
        if course is None or len(by_file) < len(sources) or "time" not in run.columns:
            return tuple(runs)
        time, values, unit = course
        kelvin = column_unit(TEMPERATURE, unit).to_si(values)
        if (
            len(kelvin) < MEANS_A_RUN
            or kelvin.min() < TEMPERATURES[0]
            or kelvin.max() > TEMPERATURES[1]
        ):
            return tuple(runs)
        most = max(
            most,
            float(np.ptp([part.mean() for part in np.array_split(kelvin, MEANS_A_RUN)])),
        )
        columns, lead = (
            {**part, TEMPERATURE: np.interp(part["time"], time, values)} if part else part
            for part in (run.columns, run.lead)
        )
        found.append(replace(run, columns=columns, lead=lead))
    return tuple(found) if most > SAME_TEMPERATURE else tuple(runs)


def _temperature_of(
    members: Sequence[Source], needed: Sequence[str]
) -> tuple[Array, Array, str] | None:
    """(time since a run began, temperature, its unit); None if no file of the run has it with a
    time.
    """
    begins, found = [], None
    for source in members:
        for meant in source.meanings:
            if meant.quantity not in (*needed, TEMPERATURE):
                continue
            time, values = source.series(meant.quantity)
            if time is None or not len(time):
                return None
            if meant.quantity != TEMPERATURE:
                begins.append(float(time[0]))
            elif meant.unit:
                found = time, values, meant.unit
    if found is None or not begins:
        return None
    time, values, unit = found
    return time - min(begins), values, unit


def temperatures_in_names(names: Sequence[str]) -> dict[str, float]:
    """Temperature [K] of each run as its name tells it, if all names tell one.

    >>> temperatures_in_names(["warm_35C_1", "cold_-5degC"])
    {'warm_35C_1': 308.15, 'cold_-5degC': 268.15}
    >>> temperatures_in_names(["finger_1_c", "finger_2_c"])
    {}
    >>> temperatures_in_names(["warm_35C_1", "cold"])
    {}
    """
    found = {}
    for name in names:
        match = TEMPERATURE_IN_NAME.search(name)
        if match is None:
            return {}
        degrees = (match["degrees"] or match["after"]).lower().replace(",", ".").replace("p", ".")
        kelvin = round(float(degrees) * (-1.0 if match["sign"] else 1.0) + KELVIN, 2)
        if not TEMPERATURES[0] <= kelvin <= TEMPERATURES[1]:
            return {}
        found[name] = kelvin
    return found


def remarks_on_air(
    columns: Mapping[str, Mapping[str, object]], runs: Sequence[ImportedRun]
) -> Iterable[str]:
    """Remarks on pressures that are absolute, or may be."""
    for name, entry in columns.items():
        if name == AIR_COLUMN and "is" not in entry:
            yield from _remarks_on_rest(str(entry["unit"]), runs)
        if AMBIENT in entry:
            yield (
                f"{name} is absolute: ambient pressure, {entry[AMBIENT]} {entry['unit']}, is "
                "subtracted (in experiment.yaml: ambient)"
            )
        if entry.get("is") == GAUGE:
            yield (
                f"{name} is a gauge pressure: 101.325 kPa of the air are added, unless "
                "experiment.yaml says another pressure beside it (ambient)"
            )


def _remarks_on_rest(unit: str, runs: Sequence[ImportedRun]) -> Iterable[str]:
    """A remark on pressures that are never below about that of the air, in a unit."""
    least, scale = [min(_lowest(run)) for run in runs], column_unit(AIR_COLUMN, unit).scale
    low, high = RULES.atmosphere
    if low < scale * min(least) and scale * max(least) < high:
        yield (
            f"no {AIR_COLUMN} is below {min(least):.6g} {unit}, about that of the air: if they are "
            f"absolute, say --map '{AIR_COLUMN}=COLUMN:{unit} abs'"
        )


def _units(sources: Sequence[Source], runs: Sequence[ImportedRun]) -> dict[str, str]:
    """Unit of every column of the set."""
    units = {"time": "s"}
    for source in sources:
        for meant in source.meanings:
            name = "stretch" if meant.quantity == "strain" else meant.quantity
            unit = "" if name == "stretch" else "s" if name == "time" else meant.unit or ""
            if units.setdefault(name, unit) != unit:
                raise DocumentError(
                    f"{source.table.path}: {name}: expected {units[name]} as in the other files, "
                    f"got {unit}; say it by --map {name}=COLUMN:UNIT"
                )
    kept = dict.fromkeys(name for run in runs for name in run.columns)
    return {name: units[name] for name in kept}


def _absolute(sources: Sequence[Source], runs: Sequence[ImportedRun]) -> Columns:
    """The entry of a pressure that the files call absolute; the air's is what they show at rest."""
    every = (one for source in sources for one in source.meanings)
    meant = {one.kind: one for one in every if one.quantity == AIR_COLUMN}
    if len(meant) > 1:
        got = " and ".join(f"{one.column} ({kind or GAUGE})" for kind, one in meant.items())
        raise DocumentError(
            f"{sources[0].table.path}: expected all pressures absolute or all gauge, got {got}; "
            "import the files one by one"
        )
    if ABSOLUTE not in meant:
        return {}
    unit = meant[ABSOLUTE].unit or ""
    scale = column_unit(AIR_COLUMN, unit).scale
    air = air_pressure([scale * level for run in runs for level in _lowest(run)]) / scale
    return {AIR_COLUMN: {"unit": unit, "is": ABSOLUTE, AMBIENT: float(f"{air:.6g}")}}


def _lowest(run: ImportedRun) -> list[float]:
    return lowest(np.array([*run.lead.get(AIR_COLUMN, ()), *run.columns[AIR_COLUMN]]))
