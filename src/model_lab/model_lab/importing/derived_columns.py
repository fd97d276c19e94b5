"""Columns that the user asks for as a function of the columns of a file, see `derived`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from model_lab.importing.derived import (
    DERIVATIONS,
    Derivation,
    argument_names,
    calibrated,
    derivation,
)
from model_lab.importing.tables import Column, Table
from model_lab.measurements.units import column_unit
from softhand_common.documents.quoted import shortened
from softhand_common.documents.yaml_document import DocumentError

Maps = Mapping[str, tuple[str, str]]
"""Column and unit ("" for that of the file) by quantity."""


def with_derived(table: Table, maps: Maps) -> Table:
    """The table with the derived columns that the user asks for."""
    for quantity, (name, unit) in maps.items():
        table = _with_column(table, quantity, name, unit)
    return table


def _with_column(table: Table, quantity: str, text: str, unit: str) -> Table:
    """The table with the column that a function of its columns is, if it has them."""
    call = derivation(text)
    if call is None:
        return table
    known = {column.name: column for column in table.columns}
    if call[0] is DERIVATIONS["linear"]:
        return _with_calibrated(table, f"--map {quantity}={text}", unit, call[1])
    if call[0].sized:
        return _with_sized(table, f"--map {quantity}={text}", unit, call)
    names = argument_names(call[1], call[0].parts, list(known))
    if not known.keys() >= set(names):
        return table
    if len(names) not in call[0].sizes:
        raise DocumentError(
            f"--map {quantity}={text}: expected {' or '.join(map(str, call[0].sizes))} columns, "
            f"got {len(names)}"
        )
    values = np.stack([known[name].values for name in names])
    seen = np.isfinite(values).all(axis=0) & values.any(axis=0)
    angle = np.full(values.shape[1], np.nan)
    if seen.any():
        angle[seen] = call[0].values(values[:, seen])
    unit = (unit or known[names[0]].unit) if len(names) == 1 else "rad"
    return table.with_column(Column(text, unit, angle))


def as_derived(name: str, unit: str) -> tuple[str, str]:
    """Column and unit that the user stated for a quantity. For a function with a size, such as
    `elongation(Weg,50mm)`, the unit is "": the function has already used it.
    """
    call = derivation(name)
    return (name, "") if call is not None and call[0].sized else (name, unit)


def _with_calibrated(table: Table, said: str, unit: str, arguments: Sequence[str]) -> Table:
    """The table with a column times a slope, plus an offset, as the option `said` asks for it."""
    name, *constants = arguments
    column, text = table.column(name), said.partition("=")[2]
    if column is None:
        return table
    values = calibrated(column.values, constants)
    if values is None:
        raise DocumentError(
            f"{said}: expected a column, a slope and an offset, as in linear({name},50,-25), "
            f"got {shortened(text)}"
        )
    return table.with_column(Column(text, unit, values))


def _with_sized(table: Table, said: str, unit: str, call: tuple[Derivation, list[str]]) -> Table:
    """The table with a function of one column and a size of the specimen, as the option `said`
    asks for it.
    """
    (function, (name, *rest)), sized, text = call, call[0].sized, said.partition("=")[2]
    column = table.column(name)
    if column is None or sized is None:
        return table
    try:
        scale = column_unit(sized.of, unit or column.unit).scale
    except ValueError as error:
        raise DocumentError(f"{said}: unit of {name}: {error} (--map ...:UNIT)") from None
    ratio = sized.combined(column.values * scale, rest[0]) if len(rest) == 1 else None
    if ratio is None:
        written = f"{text.partition('(')[0]}({name},{sized.example})"
        raise DocumentError(
            f"{said}: expected a column and the {sized.size}, as in {written}, "
            f"got {shortened(text)}"
        )
    values, seen = np.full(len(ratio), np.nan), np.isfinite(ratio)
    if seen.any():
        values[seen] = function.values(ratio[None, seen])
    return table.with_column(Column(text, function.unit, values))
