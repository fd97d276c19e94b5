"""Cells of a measurement file as text: CSV of any dialect and encoding, or a spreadsheet."""

from __future__ import annotations

import csv
import io
import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from model_lab.importing.clocks import is_time
from model_lab.importing.numerals import is_missing, is_number
from model_lab.importing.serial_lines import CLOCK_NAME, named_rows, without_stamps
from softhand_common.documents.quoted import listed, shortened
from softhand_common.documents.yaml_document import DocumentError

Row = list[str]

LARGEST_TABLE = 2**28  # [bytes]
JUDGED_LINES = 2000  # by which the delimiter is chosen
SPREADSHEETS = (".xlsx", ".xlsm")
OTHER_FORMATS = (".json", ".parquet", ".feather", ".h5", ".hdf5", ".npz", ".npy", ".pkl") + (
    ".xls",
    ".ods",
    ".tdms",
)  # that are not read
DELIMITERS = (";", "\t", "|", ",", " ")  # in the order in which they are preferred
COMMENT_SIGNS = re.compile(r"^\s*(?:#|%|//|\*)+\s*")
LINE_ENDS = re.compile(r"\r*\n|\r")
MARKS = ((b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))  # of byte orders


class Ambiguous(DocumentError):
    """A file can be read in two ways, and only the user knows which is right."""


def read_cells(path: Path, sheet: str = "") -> tuple[list[Row], str]:
    """(rows, delimiter): all rows of cells of a file that are not blank, with preamble and header,
    and the sign between cells; "" for a spreadsheet.

    A text file is split at the delimiter with which most of its lines become rows of numbers.
    sheet: name of the sheet of a spreadsheet; "": the only one that holds rows of numbers.

    Raises DocumentError for a file that cannot be read, is too large, has no such sheet, or holds
    no row of numbers, and Ambiguous if several sheets hold numbers.
    """
    if path.is_dir() or not path.exists():
        got = "a folder" if path.is_dir() else "nothing there"
        raise DocumentError(f"{path}: expected a CSV file or a spreadsheet, got {got}")
    if path.stat().st_size > LARGEST_TABLE:
        size = path.stat().st_size
        raise DocumentError(f"{path}: expected at most {LARGEST_TABLE} bytes, got {size}")
    if path.suffix.lower() in OTHER_FORMATS:
        raise DocumentError(
            f"{path}: expected a CSV or text file, a spreadsheet (XLSX), a MAT file or a bag, got "
            f"{path.suffix}; save it as CSV"
        )
    if path.suffix.lower() in SPREADSHEETS:
        rows, delimiter = _chosen(path, _sheets(path), sheet), ""
    else:
        rows, delimiter = _best_split(path)
    if not count_of_data(rows):
        raise DocumentError(
            f"{path}: expected a table with at least two columns of numbers, got none; "
            "CSV, TXT and XLSX files are read"
        )
    return rows, delimiter


def is_value(cell: str) -> bool:
    """Whether a cell contains a number or a time."""
    return is_number(cell) or is_time(cell)


def is_data(cells: Row) -> bool:
    """Whether a row may be measured data: at least two cells hold numbers or times."""
    known = 0
    for cell in cells:
        known += is_value(cell)
        if known == 2:
            return True
    return False


def is_pure(cells: Row) -> bool:
    """Whether a row is data (see `is_data`) without words."""
    return is_data(cells) and all(is_missing(cell) or is_value(cell) for cell in cells)


def count_of_data(rows: list[Row]) -> int:
    """A count of rows of data that have the most frequent number of cells: rows without words count
    2, others 1.
    """
    counts: dict[int, float] = {}
    for row in rows:
        if is_data(row):
            counts[len(row)] = counts.get(len(row), 0) + (2 if is_pure(row) else 1)
    return int(max(counts.values(), default=0))


def _chosen(path: Path, sheets: Mapping[str, list[Row]], sheet: str) -> list[Row]:
    """The sheet of that name, or the only one that holds rows of numbers."""
    if sheet:
        if sheet not in sheets:
            raise DocumentError(f"{path}: sheet: expected {listed(sheets)}, got {shortened(sheet)}")
        return sheets[sheet]
    filled = _filled(sheets)
    if len(filled) > 1:
        raise Ambiguous(
            f"{path}: expected one sheet with numbers, or sheets `run 1`, `run 2` or `half 1` "
            f"with the same columns, got {listed(filled)}; choose a sheet, as by "
            f"--sheet {shlex.quote(max(filled, key=lambda name: len(filled[name])))}"
        )
    return next(iter(filled.values()), [])


def filled_sheets(path: Path) -> list[str]:
    """Names of the sheets of a spreadsheet that hold rows of numbers; none for another file."""
    if path.suffix.lower() not in SPREADSHEETS or not path.is_file():
        return []
    return list(_filled(_sheets(path)))


def _filled(sheets: Mapping[str, list[Row]]) -> dict[str, list[Row]]:
    return {name: rows for name, rows in sheets.items() if count_of_data(rows)}


def _sheets(path: Path) -> dict[str, list[Row]]:
    """The sheets of a spreadsheet as rows of text, by name."""
    import openpyxl  # here, as only spreadsheets need it

    try:
        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
        sheets = {
            sheet.title: [row for row in map(_texts, sheet.iter_rows(values_only=True)) if any(row)]
            for sheet in book.worksheets
        }
    # openpyxl raises what its zip and XML readers happen to raise
    except Exception as reason:
        said = " ".join(str(reason).split())
        raise DocumentError(f"{path}: expected a spreadsheet, got {said}") from reason
    book.close()
    return {name: _without_empty_columns(sheet) for name, sheet in sheets.items() if sheet}


def _texts(values: tuple[object, ...]) -> Row:
    return ["" if value is None else _text(value) for value in values]


def _text(value: object) -> str:
    return value.isoformat() if hasattr(value, "isoformat") else str(value).strip()


def _without_empty_columns(rows: list[Row]) -> list[Row]:
    width = max(len(row) for row in rows)
    filled = [row + [""] * (width - len(row)) for row in rows]
    kept = [place for place in range(width) if any(row[place] for row in filled)]
    return [[row[place] for place in kept] for row in filled]


def _best_split(path: Path) -> tuple[list[Row], str]:
    """Rows of a text file, split at the delimiter that suits its first lines best."""
    lines, stamps = without_stamps(LINE_ENDS.split(_decoded(path.read_bytes())))
    rows, places = named_rows(lines)
    if rows:
        stamped = [stamps[place] for place in places] if stamps else []
        return _with_stamps(rows, ["", *stamped] if stamps else []), ""
    first = lines[:JUDGED_LINES]
    best = max(DELIMITERS, key=lambda delimiter: count_of_data(list(_split(first, delimiter))))
    if stamps:
        split = [next(_split([line], best), []) for line in lines]
        return _with_stamps(split, stamps), best
    return _without_last(list(_split(lines, best))), best


def _with_stamps(rows: list[Row], stamps: Sequence[str]) -> list[Row]:
    """Rows with the stamps of their lines in a first column, whose name is that of a time."""
    if not stamps:
        return rows
    return [
        [stamp if any(map(is_value, row)) else CLOCK_NAME, *row]
        for stamp, row in zip(stamps, rows, strict=True)
        if row
    ]


def _decoded(content: bytes) -> str:
    """The text of a file: UTF-16 by its mark or zeros, else UTF-8, else as Windows writes it."""
    encoding = next((name for mark, name in MARKS if content.startswith(mark)), "")
    if not encoding and b"\0" in content[:4]:
        encoding = "utf-16-be" if content[0] == 0 else "utf-16-le"
    if encoding:
        return content.decode(encoding, errors="replace")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252", errors="replace")


def _split(lines: Sequence[str], delimiter: str) -> Iterator[Row]:
    """Rows of lines, without those that are blank or of delimiters; comment signs do not count."""
    for whole in lines:
        line = COMMENT_SIGNS.sub("", whole).strip(" ")
        if not line.strip().strip(delimiter):
            continue
        if delimiter == " ":
            yield re.split(r"\s+", line.strip())
            continue
        reader = csv.reader(io.StringIO(line), delimiter=delimiter, skipinitialspace=True)
        try:
            yield [cell.strip() for cell in next(reader)]
        except csv.Error:
            yield [line]


def _without_last(rows: list[Row]) -> list[Row]:
    """Rows without their last cells, such as a delimiter at the end makes, that are empty in all
    rows of numbers.
    """
    widest = max((len(row) for row in rows if is_data(row)), default=0)
    while widest and all(not row[-1] for row in rows if len(row) == widest and is_data(row)):
        rows = [row[:-1] if len(row) == widest else row for row in rows]
        widest -= 1
    return rows
