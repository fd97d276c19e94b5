"""Tables with a column for each level of pressure, and a repeat in each row."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model_lab.importing.numerals import is_number
from model_lab.importing.tables import Column, Table
from model_lab.importing.units import unit_for

FEWEST_LEVELS = 3  # columns named by a number that are levels, by hand
READ_VALUES = "values"  # name of the column with what was read at all levels


def one_row_a_level(table: Table) -> Table:
    """A table with columns such as `10 kPa` and `20 kPa` as one with two columns, pressure and
    values, in which each row of the file is a run; any other table as it is.
    """
    levels = [one for one in table.columns if is_number(one.name)]
    units = {one.unit for one in levels}
    if len(levels) < FEWEST_LEVELS or len(units) > 1 or not unit_for("pressure", levels[0].unit):
        return table
    pressure = np.tile([float(one.name.replace(",", ".")) for one in levels], table.rows)
    values = np.stack([one.values for one in levels], axis=1).ravel()
    runs = [str(row + 1) for row in range(table.rows) for _ in levels]
    columns = (Column("pressure", levels[0].unit, pressure), Column(READ_VALUES, "", values))
    said = (
        f"{table.path.name}: its columns are levels of pressure, and each of its {table.rows} rows "
        f"is a run; say what was read by --map tip_force={READ_VALUES}:N or the like"
    )
    labels = tuple(runs) if table.rows > 1 else ()
    return replace(table, columns=columns, labels=labels, remarks=(*table.remarks, said))
