"""Tables of measurement files: names, units as written, and numbers of their columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from model_lab.aliases import Array
from model_lab.importing.cells import MISSING, is_data, is_time, read_cells
from model_lab.importing.headers import header

CLOCK = "clock"  # unit of a column that holds times of a clock, which are read as seconds


@dataclass(frozen=True)
class Column:
    """A column of a file: name, unit as the file writes it ("" if it does not), and its numbers
    (rows,), NaN where a cell is empty. Times of a clock are in seconds, their unit is CLOCK.
    """

    name: str
    unit: str
    values: Array

    @property
    def is_clock(self) -> bool:
        """Whether the column was written as times of a clock or dates."""
        return self.unit == CLOCK


@dataclass(frozen=True)
class Table:
    """A file's columns, and the lines that are left out: before the header, after the numbers."""

    path: Path
    columns: tuple[Column, ...]
    left_out: int

    def with_column(self, column: Column) -> Table:
        """The table with one column more."""
        return replace(self, columns=(*self.columns, column))

    @property
    def rows(self) -> int:
        """Number of rows of numbers."""
        return len(self.columns[0].values)

    def column(self, name: str) -> Column | None:
        """The column of that name, in any case of its letters; None without one."""
        found = [one for one in self.columns if one.name.casefold() == name.casefold()]
        return found[0] if found else None


def read_tables(path: Path, messages: Path | None = None) -> tuple[Table, ...]:
    """The tables of a file: the topics of a bag, the structures of a MAT file, or a single one.

    messages: folder of definitions of a bag's own message types.
    """
    if path.suffix.lower() == ".mat":
        from model_lab.importing.matlab import read_matlab  # here, as it loads scipy.io

        return read_matlab(path)
    if path.suffix == ".bag" or (path.is_dir() and (path / "metadata.yaml").is_file()):
        from model_lab.importing.bag_tables import read_bag  # here, as it loads rosbags

        return read_bag(path, messages)
    return (read_table(path),)


def read_table(path: Path) -> Table:
    """The table of a CSV or text file in any dialect, or of a spreadsheet.

    Rows with words between the numbers are left out. Raises DocumentError for what has no table.
    """
    rows = read_cells(path)
    widths = [len(row) for row in rows if is_data(row)]
    width = max(set(widths), key=widths.count)
    data = [index for index, row in enumerate(rows) if is_data(row) and len(row) == width]
    body = [rows[index] for index in data]
    names, units, header_lines = header(rows[: data[0]], width)
    columns = tuple(
        _column(name, unit, [row[place] for row in body])
        for place, (name, unit) in enumerate(zip(names, units, strict=True))
    )
    return Table(path, columns, len(rows) - len(body) - header_lines)


# ---------------------------------------------------------------------- numbers
def _column(name: str, unit: str, cells: Sequence[str]) -> Column:
    known = [cell for cell in cells if cell.lower() not in MISSING]
    if known and all(map(is_time, known)):
        return Column(name, CLOCK, _seconds(cells))
    return Column(name, unit, numbers(cells))


def numbers(cells: Sequence[str]) -> Array:
    """Numbers (rows,) of cells with decimal points or commas; NaN for an empty cell.

    Of a point and a comma in one cell, the last is the decimal sign.

    >>> numbers(["1.234,5", "2,5"]).tolist(), numbers(["1,234.5"]).tolist()
    ([1234.5, 2.5], [1234.5])
    """
    texts = pd.Series(cells, dtype=str).str.replace(r"[' \u00a0]", "", regex=True)
    texts = texts.mask(texts.str.lower().isin(MISSING))
    both = texts.str.contains(".", regex=False) & texts.str.contains(",", regex=False)
    comma = texts.str.contains(",", regex=False)
    if both.any():
        comma_last = (texts.str.rfind(",") > texts.str.rfind("."))[both].any()
        thousands = "." if comma_last else ","
        texts = texts.str.replace(thousands, "", regex=False)
    if comma.any():
        texts = texts.str.replace(",", ".", regex=False)
    return np.asarray(pd.to_numeric(texts, errors="coerce"), float)


def _seconds(cells: Sequence[str]) -> Array:
    """Seconds (rows,) of times of a clock such as 27:19.12, 12:27:19 or 2026-03-01T12:27:19."""
    texts = pd.Series(cells, dtype=str).str.replace(",", ".", regex=False)
    texts = texts.mask(texts.str.lower().isin(MISSING))
    if texts.str.contains(r"\d[-./]\d", regex=True).any() and texts.str.contains("[T ]").any():
        day_first = not texts.dropna().iloc[0][:4].isdecimal()
        stamps = pd.to_datetime(texts, format="mixed", dayfirst=day_first, utc=True)
        return np.asarray((stamps - pd.Timestamp(0, tz="UTC")) / pd.Timedelta(seconds=1), float)
    parts = texts.str.split(":")
    total = parts.map(lambda one: _total(one) if isinstance(one, list) else np.nan)
    return np.asarray(total, float)


def _total(parts: Sequence[str]) -> float:
    seconds = 0.0
    for part in parts:
        seconds = 60.0 * seconds + float(part)
    return seconds
