"""Columns of numbers from a CSV file, fast, with errors that name the row and the column.

A plain file goes through numpy's reader in one piece. Where that finds something wrong, or where
cells are quoted, the file is read again cell by cell, which tells what is wrong and where.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from model_lab.aliases import Array
from softhand_model.documents.quoted import listed, quoted, shortened
from softhand_model.documents.yaml_document import DocumentError

LONGEST_CELL = 131_072  # characters


def read_columns(
    path: Path, names: Sequence[str], words: Mapping[str, Mapping[str, float]]
) -> dict[str, Array]:
    """Columns (rows,) of a CSV file with a header line, by name, as they are written there.

    Args:
        path: the file; cells are separated by commas, blank lines are passed over.
        names: the columns to read; the others may hold anything.
        words: for columns of text, the number that stands for each word.

    Raises:
        DocumentError: the file cannot be read, lacks a column or has one twice, has no rows, or a
            row is too short or too long or holds something else than finite numbers.
    """
    text = _text(path)
    header = _header(path, text)
    places = [_place(path, header, name) for name in names]
    readers = [_reader(words.get(name)) for name in names]
    body_start = text.index("\n") + 1 if "\n" in text else len(text)
    plain = not any(name in words for name in names) and '"' not in text
    table = _read_fast(text[body_start:], len(header), places) if plain else None
    if table is None:
        table = _read_cell_by_cell(path, text, header, places, readers)
    if len(table) == 0:
        raise DocumentError(
            f"{path}: expected rows of numbers after the header, got none; "
            "record the run again or take it out of `runs`"
        )
    return {name: np.ascontiguousarray(table[:, index]) for index, name in enumerate(names)}


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as reason:
        raise DocumentError(f"{path}: expected a CSV file, got {reason.strerror}") from reason
    except UnicodeDecodeError as reason:
        raise DocumentError(
            f"{path}: expected text in UTF-8, got byte {reason.object[reason.start]:#04x} at "
            f"{reason.start}; save the file as UTF-8"
        ) from reason


def _header(path: Path, text: str) -> list[str]:
    first = text.split("\n", 1)[0].rstrip("\r")
    header = [name.strip() for name in next(_lines(path, first), (1, []))[1]]
    if not any(header):
        raise DocumentError(f"{path}: expected a line of column names first, got {quoted(first)}")
    return header


def _lines(path: Path, text: str) -> Iterator[tuple[int, list[str]]]:
    """Number and cells of every line; DocumentError where quotes or cells are none."""
    csv.field_size_limit(LONGEST_CELL)
    reader = csv.reader(io.StringIO(text), skipinitialspace=True)
    try:
        for cells in reader:
            yield reader.line_num, cells
    except csv.Error as reason:
        raise DocumentError(
            f"{path}: line {reader.line_num}: expected cells of at most {LONGEST_CELL} "
            f"characters, in quotes where they hold line ends, got {reason}"
        ) from reason


def _place(path: Path, header: list[str], name: str) -> int:
    if header.count(name) > 1:
        raise DocumentError(f"{path}: header: expected every column once, got {name} twice")
    if name in header:
        return header.index(name)
    raise DocumentError(
        f"{path}: header: expected the column {name}, got {listed(header)}{_mend(header, name)}"
    )


def _mend(header: list[str], name: str) -> str:
    alone = header[0] if len(header) == 1 else ""
    for sign, called in ((";", "semicolons"), ("\t", "tabs")):
        if sign in alone:
            return f"; separate the columns by commas instead of {called}"
    if all(_is_number(cell) for cell in header):
        return "; write the names of the columns into the first line"
    return f"; name it so in the header, or take {name} out of `columns` if it is not needed"


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


# ---------------------------------------------------------------------- in one piece
def _read_fast(body: str, width: int, places: list[int]) -> Array | None:
    """The table (rows, columns) of a body of plain numbers; None when something is wrong."""
    if not _is_even(body, width):
        return None
    try:
        table = np.loadtxt(
            io.StringIO(body), delimiter=",", usecols=places, comments=None, ndmin=2, dtype=float
        )
    except ValueError:
        return None
    return table if np.isfinite(table).all() else None


def _is_even(body: str, width: int) -> bool:
    """Whether every line has width - 1 commas, and there is a line."""
    signs = np.frombuffer(body.rstrip("\r\n").encode(), dtype=np.uint8)
    ends = np.append(np.flatnonzero(signs == ord("\n")), len(signs))
    commas = np.searchsorted(np.flatnonzero(signs == ord(",")), ends)
    return len(signs) > 0 and bool(np.all(np.diff(commas, prepend=0) == width - 1))


# ---------------------------------------------------------------------- cell by cell
Reader = Callable[[str], float]


def _read_cell_by_cell(
    path: Path, text: str, header: list[str], places: list[int], readers: list[Reader]
) -> Array:
    lines = _lines(path, text)
    next(lines)
    rows: list[list[float]] = []
    for line, cells in lines:
        if not any(cell.strip() for cell in cells) and len(cells) < 2:
            continue
        where = f"{path}: row {len(rows) + 1} (line {line} of the file)"
        if len(cells) != len(header):
            raise DocumentError(f"{where}: expected {len(header)} cells, got {len(cells)}")
        rows.append(
            [
                _cell(f"{where}, column {shortened(header[place])}", cells[place], reader)
                for place, reader in zip(places, readers, strict=True)
            ]
        )
    return np.array(rows, float).reshape(-1, len(places))


def _cell(where: str, cell: str, reader: Reader) -> float:
    try:
        return reader(cell.strip())
    except ValueError as reason:
        shown = quoted(cell) if cell.strip() else "an empty cell"
        raise DocumentError(
            f"{where}: expected {reason}, got {shown}; mend it or take the row out"
        ) from None


def _reader(words: Mapping[str, float] | None) -> Reader:
    return _number if words is None else lambda cell: _word(cell, words)


def _number(cell: str) -> float:
    """A finite number; otherwise a ValueError that says what was expected."""
    try:
        value = float(cell) if "_" not in cell else math.nan
    except ValueError:
        raise ValueError("a number") from None
    if not math.isfinite(value):
        raise ValueError("a finite number")
    return value


def _word(cell: str, words: Mapping[str, float]) -> float:
    if cell in words:
        return words[cell]
    if _is_number(cell) and float(cell) in words.values():
        return float(cell)
    raise ValueError(" or ".join(words))
