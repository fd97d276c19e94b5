"""Rows of the table from the values of the seeds, and the table as text."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from typing import Any

from bench.pneumatics.figures import GROUPS, Figure
from bench.row import at_least, at_most, stated

Row = dict[str, Any]
Values = Mapping[tuple[str, int], Sequence[float]]  # of the figures of a group, for a seed


def rows_of(groups: Sequence[str], values: Values) -> list[Row]:
    """A row a figure; a group that no seed could measure is left out."""
    rows = []
    for group in groups:
        of_group = {seed: found for (name, seed), found in values.items() if name == group}
        for place, figure in enumerate(GROUPS[group] if of_group else ()):
            per_seed = {seed: float(found[place]) for seed, found in sorted(of_group.items())}
            rows.append(row_of(figure, per_seed))
    return rows


def row_of(figure: Figure, per_seed: Mapping[int, float]) -> Row:
    """The worst of the seeds against the target, with all of them beside it."""
    values = list(per_seed.values())
    worst = figure.worst(values)
    if figure.limit is None:
        row = stated(figure.name, worst, figure.unit)
    elif figure.most:
        row = at_most(figure.name, worst, figure.unit, figure.limit)
    else:
        row = at_least(figure.name, worst, figure.unit, figure.limit)
    median = statistics.median(values)
    return {**row, "median": median, "thesis": figure.thesis, "per_seed": dict(per_seed)}


def text_of(rows: Sequence[Row]) -> str:
    """The table.

    >>> print(text_of([row_of(Figure("drift", "mg", "2.5", 2.5), {0: 1.0, 1: 3.0})]))
    what   thesis  worst  median  target  met  per seed
    drift  2.5     3 mg   2 mg    <= 2.5  NO   1, 3
    """
    words = {True: "yes", False: "NO", None: "-"}
    lines = [["what", "thesis", "worst", "median", "target", "met", "per seed"]]
    for row in rows:
        worst, median = (f"{row[k]:.3g} {row['unit']}".strip() for k in ("value", "median"))
        seeds = ", ".join(f"{value:.3g}" for value in row["per_seed"].values())
        target, met = str(row["target"] or "-"), words[row["met"]]
        lines.append([row["name"], row["thesis"], worst, median, target, met, seeds])
    widths = [max(len(line[k]) for line in lines) for k in range(len(lines[0]))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )
