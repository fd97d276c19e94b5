"""Columns with the standard deviation of a quantity, such as `Std [deg]` beside `Mean [deg]` in the
table of a paper: the noise of the set.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from model_lab.importing.cell_words import words
from model_lab.importing.runs import Source
from model_lab.importing.tables import Column
from model_lab.measurements.units import column_unit

DEVIATION_WORDS = frozenset(("std", "sd", "stdev", "stddev", "standardabweichung", "stabw"))
STANDARD_DEVIATION = frozenset(("standard", "deviation"))


def stated_noise(sources: Sequence[Source], output: str) -> float | None:
    """The median of the standard deviations that files state of an output, in the unit in which
    the first of them writes the output; None if they state none.
    """
    levels: list[float] = []
    units = [one.unit for source in sources for one in source.meanings if one.quantity == output]
    for source in sources:
        for column in _deviations(source, output):
            try:
                one, other = (column_unit(output, u or "") for u in (column.unit, units[0]))
            except ValueError:  # of another kind, such as percent
                continue
            scale = one.scale / other.scale if column.unit else 1.0
            levels.extend(scale * column.values[np.isfinite(column.values)])
    level = float(np.median(levels)) if levels else 0.0
    return float(f"{level:.3g}") if level > 0.0 else None


def _deviations(source: Source, output: str) -> Iterable[Column]:
    """The columns of a file that state standard deviations of an output: named so, and by no word
    of another quantity's column.
    """
    meant = {one.column: one.quantity for one in source.meanings}
    of_others = {
        word for name, quantity in meant.items() if quantity != output for word in words(name)
    }
    for column in source.table.columns:
        said = set(words(column.name))
        named_so = bool(said & DEVIATION_WORDS) or said >= STANDARD_DEVIATION
        if column.name not in meant and named_so and not said & of_others:
            yield column
