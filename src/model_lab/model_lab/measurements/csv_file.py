"""Columns of numbers from a CSV file, fast, with errors that name the row and the column.

A plain file goes through numpy's reader in one piece. Where that finds something wrong, or where
cells are quoted, the file is read again cell by cell, which tells what is wrong and where.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from model_lab.aliases import Array
from softhand_common.documents.quoted import listed, quoted, shortened
from softhand_common.documents.yaml_document import DocumentError

LONGEST_CELL = 131_072  # characters
LARGEST_FILE = 2**28  # [bytes]
LONGEST_PREAMBLE = 100  # lines before a header, in which it is looked for
IMPORT = "`model-lab import FILE... -o SET` makes a set of the files as they are"


class TableError(DocumentError):
    """An error in a table. `without_content` is the message without the content of the file."""

    def __init__(self, where: str, expected: str, got: str) -> None:
        self.without_content = f"{where}: expected {expected}"
        super().__init__(f"{self.without_content}, got {got}")


def read_columns(
    path: Path,
    names: Sequence[str],
    words: Mapping[str, Mapping[str, float]],
    late: Sequence[str] = (),
) -> dict[str, Array]:
    """Columns (rows,) of a CSV file with a header line, by name, in the units of the file.

    Args:
        path: the file; cells are separated by commas, blank lines are ignored.
        names: columns to read; other columns may hold anything.
        words: for each column of text, the number that stands for each word.
        late: names of columns that may begin with empty cells, which become NaN.

    Raises:
        DocumentError: the file cannot be read, is a folder or a device, or is larger than
            LARGEST_FILE.
        TableError (a DocumentError): the file lacks a column, has one twice, or has no rows; or a
            row is too short, too long, or holds something other than finite numbers.
    """
    text = _text(path)
    header = _header(path, text)
    places = [_place(path, text, header, name) for name in names]
    readers = [_late() if name in late else _reader(words.get(name)) for name in names]
    body_start = text.index("\n") + 1 if "\n" in text else len(text)
    plain = not any(name in words for name in names) and '"' not in text
    table = _read_fast(text[body_start:], len(header), places) if plain else None
    if table is None:
        table = _read_cell_by_cell(path, text, header, places, readers)
    if len(table) == 0:
        raise TableError(
            str(path),
            "rows of numbers after the header",
            "none; record the run again, or remove it from `runs`",
        )
    for name, values in zip(names, table.T, strict=True):
        if np.isnan(values[-1]):
            where = f"{path}: column {shortened(name)}"
            raise TableError(
                where, "numbers (cells may be empty only at the beginning)", "only empty cells"
            )
    return {name: np.ascontiguousarray(table[:, index]) for index, name in enumerate(names)}


def _text(path: Path) -> str:
    try:
        if path.exists() and not path.is_file():  # a device may have no end
            raise DocumentError(f"{path}: expected a CSV file, got a folder or a device")
        size = path.stat().st_size
        if size > LARGEST_FILE:
            raise DocumentError(f"{path}: expected at most {LARGEST_FILE} bytes, got {size}")
        return path.read_text(encoding="utf-8-sig")
    except OSError as reason:
        raise DocumentError(f"{path}: expected a CSV file, got {reason.strerror}") from reason
    except UnicodeDecodeError as reason:
        raise TableError(
            str(path),
            "text in UTF-8",
            f"byte {reason.object[reason.start]:#04x} at {reason.start}; save the file as UTF-8, "
            f"or {IMPORT}",
        ) from reason


def _header(path: Path, text: str) -> list[str]:
    first = text.split("\n", 1)[0].rstrip("\r")
    header = [name.strip() for name in next(_lines(path, first), (1, []))[1]]
    if not any(header):
        raise TableError(str(path), "names of the columns in the first line", quoted(first))
    return header


def _lines(path: Path, text: str) -> Iterator[tuple[int, list[str]]]:
    """Number and cells of every line; DocumentError where quotes or cells are none."""
    csv.field_size_limit(LONGEST_CELL)
    reader = csv.reader(io.StringIO(text), skipinitialspace=True)
    try:
        for cells in reader:
            yield reader.line_num, cells
    except csv.Error as reason:
        raise TableError(
            f"{path}: line {reader.line_num}",
            f"cells of at most {LONGEST_CELL} characters, in quotes if they contain line ends",
            str(reason),
        ) from reason


def _place(path: Path, text: str, header: list[str], name: str) -> int:
    if header.count(name) > 1:
        raise TableError(f"{path}: header", "every column once", f"{name} twice")
    if name in header:
        return header.index(name)
    raise TableError(
        f"{path}: header", f"the column {name}", f"{listed(header)}{_mend(text, header, name)}"
    )


def _mend(text: str, header: list[str], name: str) -> str:
    for number, line in enumerate(text.split("\n", LONGEST_PREAMBLE)[:LONGEST_PREAMBLE], 1):
        if number > 1 and name in re.split(r"[,;\t]", line.replace(" ", "").rstrip("\r")):
            return f"; line {number} has it: where other lines come before the header, {IMPORT}"
    alone = header[0] if len(header) == 1 else ""
    for sign, called in ((";", "semicolons"), ("\t", "tabs")):
        if sign in alone:
            return f"; where columns are separated by {called}, {IMPORT}"
    if all(_is_number(cell) for cell in header):
        return "; write the names of the columns into the first line"
    return f"; name it so in the header, or remove {name} from `columns` if it is not needed"


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
            raise TableError(where, f"{len(header)} cells", str(len(cells)))
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
        raise TableError(where, str(reason), f"{shown}; correct it or remove the row") from None


def _reader(words: Mapping[str, float] | None) -> Reader:
    return _number if words is None else lambda cell: _word(cell, words)


def _late() -> Reader:
    """A reader of numbers that takes empty cells as NaN until the first number."""
    begun = False

    def read(cell: str) -> float:
        nonlocal begun
        if not cell and not begun:
            return math.nan
        begun = True
        return _number(cell)

    return read


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
