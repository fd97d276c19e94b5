"""A slip that may be there, and measurement sets whose columns are read in another way."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import yaml

from model_lab.aliases import Array
from model_lab.measurements.meanings import ATMOSPHERE, OF_LENGTH, as_expected
from model_lab.measurements.measurement_set import MeasurementSet, Run
from model_lab.measurements.units import column_unit, display_of, unit_of

MISTAKEN_UNITS: Mapping[str, tuple[str, ...]] = {
    "Pa": ("kPa", "bar", "mbar", "psi", "Pa", "MPa", "mmHg", "kgf/cm**2", "inH2O", "atm", "inHg"),
    "rad": ("deg", "rad", "turn", "mrad"),
    "N": ("N", "mN", "gf", "kgf", "lbf", "ozf"),
    "N m": ("N*mm", "N*m", "N*cm", "kgf*cm", "lbf*inch"),
    "m": ("mm", "m", "cm", "inch", "um"),
    "kg": ("mg", "g", "kg", "oz", "lb"),
    "s": ("s", "ms", "min", "us", "h"),
    "Pa s": ("kPa*s", "Pa*s", "bar*s", "kPa*ms", "psi*s", "mbar*s", "bar*ms", "Pa*ms", "MPa*s"),
    "": ("", "percent"),
}
"""Usual units of a quantity by its SI unit, the commonest first."""
COMMON_UNITS = 5  # of a quantity; those after them are rare
WITHOUT_UNIT = ("direction", "time", "tip_qx", "tip_qy", "tip_qz", "tip_qw")


Change = Callable[[Run], Mapping[str, Array]]
"""New columns (samples,) of a run by name."""


@dataclass(frozen=True)
class Candidate:
    """A slip that a set may have.

    name, column, said, fits, mend: as in `Slip`. mended: the corrected set. rare: whether the slip
    is so rare that another slip is preferred if it fits as well.
    """

    name: str
    column: str
    said: str
    fits: str
    mend: str
    mended: MeasurementSet
    rare: bool = False


def stated_unit(data: MeasurementSet, column: str) -> str:
    """The unit that the set states for a column; if it states none, the unit in which the column
    would be written to a file.
    """
    return data.units.get(column, display_of(unit_of(column) or "").unit)


def factors_of(data: MeasurementSet, column: str) -> list[tuple[str, float]]:
    """(unit, factor) of each usual unit of a column other than the stated one. A number in `unit`
    times the factor is the number in the stated unit.
    """
    stated = column_unit(column, stated_unit(data, column)).scale
    known = MISTAKEN_UNITS.get(unit_of(column) or "", ()) if column not in WITHOUT_UNIT else ()
    factors = [(unit, column_unit(column, unit).scale / stated) for unit in known]
    return [(unit, factor) for unit, factor in factors if not np.isclose(factor, 1.0)]


def is_rare(column: str, unit: str) -> bool:
    """Whether a unit is rarely used for the quantity of a column."""
    return unit in MISTAKEN_UNITS[unit_of(column) or ""][COMMON_UNITS:]


def with_columns(data: MeasurementSet, change: Change, needed: tuple[str, ...]) -> MeasurementSet:
    """The set with columns replaced by those that `change` returns, in every run that has all the
    columns `needed`.
    """
    runs = tuple(
        replace(
            run,
            columns=_changed(run, run.columns, change, needed),
            lead=_changed(run, run.lead, change, needed),
        )
        for run in data.runs
    )
    return replace(data, runs=runs)


def _changed(
    run: Run, columns: Mapping[str, Array], change: Change, needed: tuple[str, ...]
) -> Any:
    """Columns of a run, or those of its lead, changed if they have what is needed."""
    if not all(name in columns for name in needed):
        return columns
    return {**columns, **change(replace(run, columns=columns))}


def with_units(
    data: MeasurementSet, columns: Sequence[str], unit: str, factor: float
) -> MeasurementSet:
    """A copy of the set for the hypothesis that `columns` were recorded in `unit`, not in the unit
    that the set states. factor: one `unit` over one stated unit [-], by which values and noise of
    these columns are multiplied.
    """
    changed = with_columns(
        data, lambda run: {name: factor * run.columns[name] for name in columns}, tuple(columns)
    )
    noise = {
        name: factor * sigma if name in columns else sigma for name, sigma in data.noise.items()
    }
    return replace(changed, noise=noise, units={**data.units, **dict.fromkeys(columns, unit)})


def with_meaning(
    data: MeasurementSet, columns: Sequence[str], word: str, ambient: float = ATMOSPHERE
) -> MeasurementSet:
    """A copy of the set for the hypothesis that `columns` hold another quantity than is expected.

    word: which quantity, by a word of `meanings` such as `absolute`. ambient: pressure of the air
    [Pa].
    """
    meanings = dict.fromkeys(columns, word)

    def read(run: Run) -> dict[str, Array]:
        length = float(data.specimens[run.specimen].values.get(OF_LENGTH, np.nan))
        found = as_expected(run.columns, meanings, ambient, length)
        return {name: found[name] for name in columns}

    return with_columns(data, read, tuple(columns))


def with_renamed(data: MeasurementSet, sources: Mapping[str, str]) -> MeasurementSet:
    """The set with some columns, the keys of `sources`, replaced by the columns that `sources`
    names for them.
    """
    return with_columns(
        data,
        lambda run: {name: run.columns[source] for name, source in sources.items()},
        tuple(sources.values()),
    )


# ---------------------------------------------------------------------- mends
def column_mend(data: MeasurementSet, entries: Mapping[str, Mapping[str, Any]]) -> str:
    """Text for experiment.yaml that corrects how columns are stated, from entries by column: under
    `columns`, or for runs from bags under their `topics`.
    """
    bags = {run.name: {"topics": entries} for run in data.runs if run.name in data.bags}
    document: dict[str, Any] = {"runs": bags} if bags else {}
    if len(bags) < len(data.runs):
        document["columns"] = dict(entries)
    return one_line(document)


def one_line(document: Mapping[str, Any]) -> str:
    """A document as one line of YAML, without the outer braces.

    >>> one_line({"columns": {"pressure": {"unit": "psi"}}})
    'columns: {pressure: {unit: psi}}'
    """
    text = yaml.safe_dump(dict(document), default_flow_style=True, sort_keys=False, width=1e9)
    return text.strip()[1:-1]
