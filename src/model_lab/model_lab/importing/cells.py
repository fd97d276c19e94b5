"""Cells of a measurement file as text: CSV of any dialect and encoding, or a spreadsheet."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from softhand_common.documents.yaml_document import DocumentError

Row = list[str]

LARGEST_TABLE = 2**28  # [bytes]
JUDGED_LINES = 2000  # by which the delimiter is chosen
SPREADSHEETS = (".xlsx", ".xlsm")
DELIMITERS = (";", "\t", "|", ",", " ")  # in the order in which they are preferred
COMMENT_SIGNS = re.compile(r"^\s*(?:#|%|//|\*)+\s*")
NUMBER = re.compile(r"[+-]?(?:\d+[\d.,' ]*|[.,]\d+)(?:[eE][+-]?\d+)?$")
CLOCK_TEXT = re.compile(r"(?:\d+:)?\d{1,2}:\d{1,2}(?:[.,]\d+)?$")
DATE_TEXT = re.compile(r"(?:\d{4}-\d{1,2}-\d{1,2}|\d{1,2}[./]\d{1,2}[./]\d{2,4})[T ]\d{1,2}:\d{2}")
MISSING = ("", "-", "--", "nan", "na", "n/a", "null", "none", "#n/a", "inf", "-inf")


def read_cells(path: Path) -> list[Row]:
    """Rows of cells of a file, without blank ones; preamble and header are among them.

    A text file is split at the delimiter at which most of its lines become rows of numbers.

    Raises DocumentError for a file that cannot be read, is too large, or holds no row of numbers.
    """
    if path.is_dir() or not path.exists():
        got = "a folder" if path.is_dir() else "nothing there"
        raise DocumentError(f"{path}: expected a CSV file or a spreadsheet, got {got}")
    if path.stat().st_size > LARGEST_TABLE:
        size = path.stat().st_size
        raise DocumentError(f"{path}: expected at most {LARGEST_TABLE} bytes, got {size}")
    sheets = _sheets(path) if path.suffix.lower() in SPREADSHEETS else [_best_split(path)]
    rows = max(sheets, key=count_of_data, default=[])
    if not count_of_data(rows):
        raise DocumentError(
            f"{path}: expected a table with at least two columns of numbers, got none; "
            "CSV, TXT and XLSX files are read"
        )
    return rows


def is_data(cells: Row) -> bool:
    """Whether a row holds what was measured: two numbers or times at least, and no words."""
    known = [cell for cell in cells if cell.lower() not in MISSING]
    return len(known) > 1 and all(is_number(cell) or is_time(cell) for cell in known)


def is_number(cell: str) -> bool:
    """Whether a cell holds a number, with a decimal point or comma.

    >>> is_number("-1.234,5e-3"), is_number("A12")
    (True, False)
    """
    return NUMBER.match(cell) is not None


def is_time(cell: str) -> bool:
    """Whether a cell holds a time of day, a stop watch's time, or a date with a time."""
    return CLOCK_TEXT.match(cell) is not None or DATE_TEXT.match(cell) is not None


def count_of_data(rows: list[Row]) -> int:
    """Number of rows of numbers that have as many cells as most of them."""
    widths = [len(row) for row in rows if is_data(row)]
    return max((widths.count(width) for width in set(widths)), default=0)


def _sheets(path: Path) -> list[list[Row]]:
    """The sheets of a spreadsheet as rows of text."""
    import openpyxl  # here, as only spreadsheets need it

    try:
        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
        sheets = [
            [row for row in map(_texts, sheet.iter_rows(values_only=True)) if any(row)]
            for sheet in book.worksheets
        ]
    # openpyxl raises what its zip and XML readers happen to raise
    except Exception as reason:
        said = " ".join(str(reason).split())
        raise DocumentError(f"{path}: expected a spreadsheet, got {said}") from reason
    book.close()
    return [_without_empty_columns(sheet) for sheet in sheets if sheet]


def _texts(values: tuple[object, ...]) -> Row:
    return ["" if value is None else _text(value) for value in values]


def _text(value: object) -> str:
    return value.isoformat() if hasattr(value, "isoformat") else str(value).strip()


def _without_empty_columns(rows: list[Row]) -> list[Row]:
    width = max(len(row) for row in rows)
    filled = [row + [""] * (width - len(row)) for row in rows]
    kept = [place for place in range(width) if any(row[place] for row in filled)]
    return [[row[place] for place in kept] for row in filled]


def _best_split(path: Path) -> list[Row]:
    """Rows of a text file, split at the delimiter that suits its first lines best."""
    lines = _decoded(path.read_bytes()).splitlines()
    first = lines[:JUDGED_LINES]
    best = max(DELIMITERS, key=lambda delimiter: count_of_data(list(_split(first, delimiter))))
    return list(_split(lines, best))


def _decoded(content: bytes) -> str:
    """The text of a file: UTF-16 with its mark, else UTF-8, else as Windows writes it."""
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return content.decode("utf-16", errors="replace")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252", errors="replace")


def _split(lines: Sequence[str], delimiter: str) -> Iterator[Row]:
    """Rows of lines, without blank ones; comment signs and delimiters at the end do not count."""
    for whole in lines:
        line = COMMENT_SIGNS.sub("", whole).strip(" \r").rstrip(delimiter)
        if not line.strip():
            continue
        if delimiter == " ":
            yield re.split(r"\s+", line.strip())
            continue
        reader = csv.reader(io.StringIO(line), delimiter=delimiter, skipinitialspace=True)
        try:
            yield [cell.strip() for cell in next(reader)]
        except csv.Error:
            yield [line]
