"""Tables of measurement files: names of their columns, units as written, and numbers."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from model_lab.aliases import Array
from model_lab.importing.cell_words import directions, mode_in, words
from model_lab.importing.cells import (
    Ambiguous,
    Row,
    filled_sheets,
    is_data,
    is_value,
    read_cells,
)
from model_lab.importing.clocks import is_time, may_be_hours, seconds
from model_lab.importing.headers import header
from model_lab.importing.numerals import (
    Roles,
    decimal_sign,
    is_missing,
    is_number,
    numbers,
    roles,
)
from model_lab.importing.units import unit_in_header
from softhand_common.documents.quoted import listed, shortened
from softhand_common.documents.yaml_document import DocumentError

CLOCK = "clock"  # unit of a column that holds times of a clock, which are read as seconds
SHORT_CLOCK = "clock of two parts"  # ... such as 12:27, hours and minutes or minutes and seconds
MOST_UNREADABLE = 0.05  # share of a column's cells, beyond which they are no accident
LABEL_WORDS = (
    *("specimen", "sample", "finger", "actuator", "prototype", "trial", "run", "test", "rep"),
    *("repeat", "repetition", "experiment", "protocol", "probe", "versuch", "messung", "lauf"),
    *("wdh", "wiederholung", "durchgang", "replicate"),
    *("protokoll", "essai", "echantillon", "eprouvette", "ensayo", "muestra", "probeta", "prova"),
    *("prufkorper", "pruefkoerper", "probekorper", "campione"),
    *("id", "no", "nr", "num", "number", "name", "nummer"),
)  # of which the name of a column consists that says to which run its rows belong
LABEL_SIGN = re.compile(r"\W+")  # what a label of a run cannot have in the name of a file
NAMED_SHEET = re.compile(r"\d|(?:specimen|finger|actuator|sample|probe)[\s_-]*\w$", re.I)
"""Names of sheets that number the runs or name a specimen."""
WHOLE_NUMBER = re.compile(r"\d+(?:[.,]0*)?")
LEAST_ROWS_OF_RUN = 3  # fewer are no run, by hand


@dataclass(frozen=True)
class Column:
    """A column of a file.

    unit: as the file writes it; "" if it does not. values (rows,): NaN where a cell is empty. Times
    of a clock are in seconds, and their unit is CLOCK.
    """

    name: str
    unit: str
    values: Array

    @property
    def is_clock(self) -> bool:
        """Whether the column was written as times of a clock or dates."""
        return self.unit in (CLOCK, SHORT_CLOCK)


@dataclass(frozen=True)
class Table:
    """The columns of a file, and remarks on what was left out.

    labels (rows,): which specimen and repeat each row belongs to, as columns such as Specimen and
    Trial say; empty if the file has no such columns.
    """

    path: Path
    columns: tuple[Column, ...]
    remarks: tuple[str, ...] = ()
    labels: tuple[str, ...] = ()

    def with_column(self, column: Column) -> Table:
        """The table with one more column."""
        return replace(self, columns=(*self.columns, column))

    @property
    def rows(self) -> int:
        """Number of rows of numbers."""
        return len(self.columns[0].values)

    def column(self, name: str) -> Column | None:
        """The column with that name, whatever the case of its letters, or with that name and unit
        as the header writes them; None if there is none.
        """
        for asked in (name, unit_in_header(name)[0]):
            found = [one for one in self.columns if one.name.casefold() == asked.casefold()]
            if found:
                same = asked == name or (found[0].unit and found[0].unit in name)
                return found[0] if same else None
        return None


def read_tables(
    path: Path, messages: Path | None = None, decimal: str = "", sheet: str = ""
) -> tuple[Table, ...]:
    """The tables of a file: the topics of a bag, the structures of a MAT file, the sheets of a
    spreadsheet if they are numbered or name specimens, and have the same columns, or a single one.

    messages: folder of definitions of message types that a bag does not define; None: no folder.
    decimal, sheet: see `read_table`.
    """
    if path.suffix.lower() == ".mat":
        from model_lab.importing.matlab import read_matlab  # here, as it loads scipy.io

        return read_matlab(path)
    if path.suffix == ".bag" or (path.is_dir() and (path / "metadata.yaml").is_file()):
        from model_lab.importing.bag_tables import read_bag  # here, as it loads rosbags

        return read_bag(path, messages)
    sheets = [] if sheet else filled_sheets(path)
    if len(sheets) > 1 and all(map(NAMED_SHEET.search, sheets)):
        tables = [read_table(path, decimal, name) for name in sheets]
        if len({tuple((one.name, one.unit) for one in table.columns) for table in tables}) == 1:
            return tuple(
                replace(table, path=labelled(path, name))
                for table, name in zip(tables, sheets, strict=True)
            )
    return (read_table(path, decimal, sheet),)


def labelled(path: Path, label: str) -> Path:
    """Path that stands for the part of a file with that label."""
    return path.with_name(f"{path.stem}_{LABEL_SIGN.sub('-', label.strip())}{path.suffix}")


def read_table(path: Path, decimal: str = "", sheet: str = "") -> Table:
    """The table of a CSV or text file in any dialect, or of a spreadsheet.

    decimal: its decimal sign; "": found out from its numbers. sheet: name of the sheet of a
    spreadsheet; "": the only one that holds numbers. Columns of words and rows without numbers are
    left out. Single cells that cannot be read become NaN.

    Raises DocumentError for a file without a table or with two, and for more than a few cells that
    cannot be read; Ambiguous if several sheets hold numbers, or numbers may be read in two ways.
    """
    rows, delimiter = read_cells(path, sheet)
    widths = [len(row) for row in rows if is_data(row)]
    width = max(set(widths), key=widths.count)
    kept = _measured_columns([row for row in rows if len(row) == width and is_data(row)])
    good = [index for index, row in enumerate(rows) if len(row) == width and _fits(row, kept)]
    first = _first_below_header(rows, good[0], width)
    between = range(first, good[-1] + 1)
    names, units, header_lines = header(rows[:first], width)
    _refuse_second_table(path, [rows[index] for index in between], names, width)
    body = [rows[index] for index in between if len(rows[index]) == width and is_data(rows[index])]
    remarks = _left_out(len(rows) - len(body) - header_lines)
    remarks += _unreadable(path, body, {place: names[place] for place in kept})
    told = [place for place in range(width) if _is_label(names[place], [r[place] for r in body])]
    labels = _labels([[row[place] for row in body] for place in told])
    worded = [place for place in _places(width, kept) if place not in told]
    found = {place: directions(row[place] for row in body) for place in worded}
    turned = {place: values for place, values in found.items() if values is not None}
    remarks += [f"the words of {names[n]} are left out" for n in worded if n not in turned]
    if labels:
        by = " and ".join(names[place] for place in told)
        remarks.append(f"the rows of {path.name} are {len(set(labels))} runs, by {by}")
    seen = roles(cell for row in body for cell in row)
    columns = tuple(
        _column(
            path, names[place], units[place], [row[place] for row in body], seen, delimiter, decimal
        )
        for place in kept
        if place not in told
    )
    columns += tuple(Column(names[place], "", np.array(values)) for place, values in turned.items())
    return Table(path, columns, tuple(remarks), labels)


def _is_label(name: str, cells: Sequence[str]) -> bool:
    """Whether a column says which specimen or repeat its rows belong to: its name consists of such
    words alone, or its cells are modes of a test of rubber; and it has few different words or whole
    numbers, each in several rows.

    >>> _is_label("Trial no", 3 * ["1"] + 3 * ["2"])
    True
    >>> _is_label("test pressure", 3 * ["1"] + 3 * ["2"])
    False
    >>> _is_label("kind", 3 * ["biaxial"] + 3 * ["pure shear"])
    True
    """
    named = {word for word in words(name) if not word.isdecimal()}
    is_mode = all(map(mode_in, set(cells)))
    if not is_mode and not (named and named <= set(LABEL_WORDS)):
        return False
    rows = Counter(cells)
    whole = all(not is_number(cell) or WHOLE_NUMBER.fullmatch(cell.strip()) for cell in rows)
    return whole and len(rows) > 1 and min(rows.values()) >= LEAST_ROWS_OF_RUN and "" not in rows


def _labels(columns: Sequence[Sequence[str]]) -> tuple[str, ...]:
    """One text for each row of the columns of labels: words first, then numbers.

    >>> _labels([["1", "2"], ["thin", "thin"]])
    ('thin_1', 'thin_2')
    """
    ordered = sorted(columns, key=lambda cells: all(map(is_number, cells)))
    plain = [[LABEL_SIGN.sub("-", cell.strip()) for cell in cells] for cells in ordered]
    return tuple("_".join(row) for row in zip(*plain, strict=True)) if plain else ()


def _first_below_header(rows: Sequence[Row], good: int, width: int) -> int:
    """Index of the first row of numbers below the header; good: of the first without words."""
    worded = [len(row) == width and not is_data(row) for row in rows[:good]]
    if not any(worded):
        return good
    below = good - worded[::-1].index(True)
    return next(n for n in range(below, good + 1) if len(rows[n]) == width and is_data(rows[n]))


def _places(width: int, kept: Sequence[int]) -> list[int]:
    return [place for place in range(width) if place not in kept]


def _measured_columns(rows: Sequence[Row]) -> list[int]:
    """Places of the columns that hold numbers or times in most of the rows that hold anything."""
    kept = []
    for place in range(len(rows[0])):
        known = [row[place] for row in rows if not is_missing(row[place])]
        if sum(map(is_value, known)) * 2 >= len(known):
            kept.append(place)
    return kept


def _fits(row: Row, kept: Sequence[int]) -> bool:
    """Whether a row has no words where numbers are expected, and two numbers at least."""
    known = [row[place] for place in kept if not is_missing(row[place])]
    return len(known) > 1 and all(map(is_value, known))


def _refuse_second_table(path: Path, rows: Sequence[Row], names: list[str], width: int) -> None:
    """Raise DocumentError where another header stands between rows of numbers."""
    for row in rows:
        words = [cell for cell in row if cell and not is_value(cell)]
        if len(row) != width or len(words) < width or width < 2:
            continue
        if [unit_in_header(cell)[0] for cell in row] != names:
            raise DocumentError(
                f"{path}: expected one table, got a second one, which begins with {listed(row)}; "
                "keep each table in a file of its own"
            )


def _left_out(lines: int) -> list[str]:
    are = "line without numbers is" if lines == 1 else "lines without numbers are"
    return [f"{lines} {are} left out"] if lines else []


def _unreadable(path: Path, body: Sequence[Row], names: Mapping[int, str]) -> list[str]:
    """Remarks on cells that are no numbers. Raises DocumentError where these are many."""
    remarks = []
    for place, name in names.items():
        wrong = [row[place] for row in body if not _is_known(row[place])]
        if len(wrong) > MOST_UNREADABLE * len(body):
            raise DocumentError(
                f"{path}: column {shortened(name)}: expected numbers, got {shortened(wrong[0])} "
                f"and {len(wrong) - 1} more cells without a number"
            )
        if wrong:
            remarks.append(
                f"{len(wrong)} cells of {name} are not numbers and are left out; the first is "
                f"{shortened(wrong[0])}"
            )
    return remarks


def _is_known(cell: str) -> bool:
    return is_missing(cell) or is_value(cell)


# ---------------------------------------------------------------------- numbers
def _column(
    path: Path,
    name: str,
    unit: str,
    cells: Sequence[str],
    others: Roles,
    delimiter: str,
    decimal: str,
) -> Column:
    known = [cell for cell in cells if _is_known(cell) and not is_missing(cell)]
    if known and all(map(is_time, known)):
        return Column(name, SHORT_CLOCK if may_be_hours(known) else CLOCK, seconds(cells))
    try:
        sign = decimal or decimal_sign(known, others, point=delimiter in ("", ","))
    except ValueError as reason:
        raise Ambiguous(
            f"{path}: column {shortened(name)}: expected a clear decimal sign, got {reason}; "
            "state it with --decimal point or --decimal comma"
        ) from reason
    return Column(name, unit, numbers([cell if is_number(cell) else "" for cell in cells], sign))
