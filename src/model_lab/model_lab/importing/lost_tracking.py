"""Rows in which a tracker saw nothing and wrote 0 for all that it follows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model_lab.aliases import Array
from model_lab.importing.tables import Column, Table
from softhand_common.documents.quoted import listed

LOST_COLUMNS = 3  # columns that are 0 in the same rows, from which on nothing was tracked there
LOST_PLACES = 2  # of them those that are far from 0 in all other rows, as coordinates are
FAR_FROM_ZERO = 0.2  # least size of such a column in the other rows, as a share of the largest
LEAST_PLACES = 5  # different values that it has there; commands and valves have fewer


def without_lost_tracking(table: Table) -> Table:
    """The table with empty cells where several columns are exactly 0 in the same rows, and
    coordinates among them jump there, and a remark on them.
    """
    alike: dict[bytes, list[Column]] = {}
    for column in table.columns:
        zero = column.values == 0.0
        if 0 < zero.sum() < len(zero) / 2:
            alike.setdefault(zero.tobytes(), []).append(column)
    for columns in alike.values():
        if len(columns) >= LOST_COLUMNS and sum(map(_is_place, columns)) >= LOST_PLACES:
            table = _emptied(table, columns)
    return table


def _is_place(column: Column) -> bool:
    seen: Array = np.abs(column.values[column.values != 0.0])
    seen = seen[np.isfinite(seen)]
    far = len(seen) > 0 and seen.min() > FAR_FROM_ZERO * seen.max()
    return bool(far and len(np.unique(seen)) >= LEAST_PLACES)


def _emptied(table: Table, columns: list[Column]) -> Table:
    names = [column.name for column in columns]
    lost = columns[0].values == 0.0
    changed = tuple(
        replace(one, values=np.where(lost, np.nan, one.values)) if one.name in names else one
        for one in table.columns
    )
    remark = (
        f"{int(lost.sum())} rows in which {listed(names)} are all exactly 0 are taken as rows in "
        "which nothing was tracked"
    )
    return replace(table, columns=changed, remarks=(*table.remarks, remark))
