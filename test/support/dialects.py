"""One run written in the dialects in which laboratories keep their tables.

Written from what the import promises, not from how it reads: text files that differ in delimiter,
signs of numbers, encoding, header, units and clock, spreadsheets, and files of MATLAB.
"""

from __future__ import annotations

import csv
import datetime
import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import openpyxl
import scipy.io

TIME = np.arange(0.0, 12.0, 0.25)  # [s]
PRESSURE = 40.0 * np.sin(np.pi * TIME / 12.0) ** 2  # [kPa]
ANGLE = 2.0 * PRESSURE + 0.01 * PRESSURE**2 - 1.5  # [deg], negative at rest
BEGIN = datetime.datetime(2024, 3, 1, 12, 59, 55, tzinfo=datetime.UTC)
NAMES = ("time [s]", "pressure [kPa]", "tip_angle [deg]")


@dataclass(frozen=True)
class Text:
    """A text file: its header, how numbers are written, and what stands around the table.

    scale: of the pressure in kPa. clock: text of a time [s]. number: text of a number with a point.
    decimal, thousands: signs of numbers. unit_row: a row below the header. before, after: lines
    around the table. between: lines put in after the tenth row. quoted: every cell in quotes.
    trailing: a delimiter at the end of each row, of the header too if `trailing_header`. index: a
    column of row numbers of this name first; text: a column of words of this name last.
    """

    names: tuple[str, ...] = NAMES
    delimiter: str = ","
    decimal: str = "."
    thousands: str = ""
    scale: float = 1.0
    encoding: str = "utf-8"
    mark: bytes = b""
    line_end: str = "\n"
    last_end: bool = True
    clock: Callable[[float], str] | None = None
    number: str = "{:.5f}"
    unit_row: tuple[str, ...] = ()
    before: tuple[str, ...] = ()
    after: tuple[str, ...] = ()
    between: tuple[str, ...] = ()
    header_sign: str = ""
    quoted: bool = False
    trailing: bool = False
    trailing_header: bool = True
    index: str | None = None
    text: str | None = None
    minus: str = "-"
    order: tuple[int, ...] = (0, 1, 2)
    suffix: str = ".csv"

    def write(self, folder: Path) -> Path:
        """The file in this dialect."""
        rows = [self._row(number) for number in range(len(TIME))]
        rows[10:10] = list(self.between)
        header = [self.header_sign + self._line(self._with_more(self.names, self.index, self.text))]
        units = [self._line(self._with_more(self.unit_row, "", ""))] if self.unit_row else []
        if self.trailing and self.trailing_header:
            header = [line + self.delimiter for line in header]
        lines = [*self.before, *header, *units, *rows, *self.after]
        content = self.line_end.join(lines) + (self.line_end if self.last_end else "")
        path = folder / f"run_1{self.suffix}"
        path.write_bytes(self.mark + content.encode(self.encoding))
        return path

    def _row(self, number: int) -> str:
        time = TIME[number]
        cells = (
            self._number(time) if self.clock is None else self.clock(float(time)),
            self._number(PRESSURE[number] * self.scale),
            self._number(ANGLE[number]),
        )
        word = "up" if number < len(TIME) // 2 else "down"
        line = self._line(self._with_more(cells, str(number + 1), word))
        return line + self.delimiter if self.trailing else line

    def _with_more(self, cells: tuple[str, ...], index: str | None, word: str | None) -> list[str]:
        first = [index or ""] if self.index is not None else []
        last = [word or ""] if self.text is not None else []
        return [*first, *(cells[place] for place in self.order), *last]

    def _number(self, value: float) -> str:
        text = self.number.format(value)
        whole, point, rest = text.partition(".")
        if self.thousands:
            whole = f"{int(whole):,}".replace(",", self.thousands)
            whole = "-" + whole if text.startswith("-0") else whole
        text = whole + (self.decimal if point else "") + rest
        return text.replace("-", self.minus, 1) if text.startswith("-") else text

    def _line(self, cells: list[str]) -> str:
        buffer = io.StringIO()
        quoting = csv.QUOTE_ALL if self.quoted else csv.QUOTE_MINIMAL
        if len(self.delimiter) > 1:
            return self.delimiter.join(cells)
        csv.writer(buffer, delimiter=self.delimiter, quoting=quoting, lineterminator="").writerow(
            cells
        )
        return buffer.getvalue()


def _stamp(form: str, digits: int = 3, begin: datetime.datetime = BEGIN) -> Callable[[float], str]:
    """The clock text of a time [s]; `%f` is the fraction of the second in so many digits."""

    def text(seconds: float) -> str:
        moment = begin + datetime.timedelta(seconds=seconds)
        return moment.strftime(form.replace("%f", f"{moment.microsecond:06d}"[:digits]))

    return text


def _epoch(per_second: float, form: str) -> Callable[[float], str]:
    return lambda seconds: form.format(round((BEGIN.timestamp() + seconds) * per_second, 3))


def _epoch_whole(per_second: int) -> Callable[[float], str]:
    whole = round(BEGIN.timestamp())
    return lambda seconds: str(whole * per_second + round(seconds * per_second))


SEMICOLONS = {"delimiter": ";", "decimal": ","}
PASCALS = ("t [s]", "p [Pa]", "angle [deg]")
STAMPED = ("stamp", "pressure [kPa]", "tip_angle [deg]")
TEXTS: dict[str, Text] = {
    "plain": Text(),
    "decimal commas": Text(**SEMICOLONS),
    "German in Latin 1": Text(
        ("Zeit [s]", "Druck [mbar]", "Winkel [°]"), encoding="latin-1", scale=10.0, **SEMICOLONS
    ),
    "German in Windows 1252": Text(
        ("Zeit in s", "Überdruck in kPa", "Krümmungswinkel in °"), encoding="cp1252", **SEMICOLONS
    ),
    "French": Text(("Temps (s)", "Pression (kPa)", "Angle de flexion (°)"), **SEMICOLONS),
    "Spanish": Text(("Tiempo [s]", "Presión [kPa]", "Ángulo [grados]"), **SEMICOLONS),
    "tabs": Text(delimiter="\t", suffix=".tsv"),
    "tabs and decimal commas": Text(delimiter="\t", decimal=",", suffix=".txt"),
    "bars": Text(delimiter="|"),
    "bars with blanks": Text(delimiter=" | "),
    "commas with blanks": Text(delimiter=", "),
    "aligned by blanks": Text(("t_s", "p_kPa", "angle_deg"), delimiter="   ", number="{:10.5f}"),
    "byte order mark": Text(encoding="utf-8-sig"),
    "UTF-16 little": Text(encoding="utf-16-le", mark=b"\xff\xfe", delimiter="\t"),
    "UTF-16 big": Text(encoding="utf-16-be", mark=b"\xfe\xff", **SEMICOLONS),
    "UTF-16 without a mark": Text(encoding="utf-16-le", delimiter="\t"),
    "thousands by commas": Text(PASCALS, thousands=",", scale=1e3, number="{:.2f}"),
    "thousands by points": Text(PASCALS, thousands=".", scale=1e3, number="{:.2f}", **SEMICOLONS),
    "thousands by blanks": Text(PASCALS, thousands=" ", scale=1e3, number="{:.2f}", **SEMICOLONS),
    "thousands by hard blanks": Text(
        PASCALS, thousands="\u202f", scale=1e3, number="{:.2f}", **SEMICOLONS
    ),
    "thousands by apostrophes": Text(
        PASCALS, thousands="'", scale=1e3, number="{:.2f}", delimiter=";"
    ),
    "preamble": Text(before=("Rig: bench 3", "Operator: M. M.", "Rate: 4 Hz", "", "")),
    "preamble of three cells": Text(
        before=("Rig;bench 3;left", "Sensors;2;0,5", "Date;01.03.2024;12:59"), **SEMICOLONS
    ),
    "preamble with numbers": Text(
        before=("Samples,48", "Rate,4", "Offset,0.0,0.0", "Gain,1.0,1.0", "")
    ),
    "footer": Text(after=("", "end of file", "48 rows")),
    "row of units": Text(("Time", "Pressure", "Angle"), unit_row=("s", "kPa", "deg")),
    "row of units in brackets": Text(
        ("Zeit", "Druck", "Winkel"), unit_row=("[s]", "[kPa]", "[°]"), **SEMICOLONS
    ),
    "row of units in parentheses": Text(
        ("Time", "Pressure", "Angle"),
        unit_row=("(s)", "(bar)", "(deg)"),
        scale=0.01,
        number="{:.9f}",
    ),
    "units in parentheses": Text(("Time (s)", "Pressure (kPa)", "Bending angle (deg)")),
    "units after a slash": Text(("t / s", "p / kPa", "alpha / deg"), **SEMICOLONS),
    "units after a slash without blanks": Text(("t/s", "p/kPa", "Winkel/°"), **SEMICOLONS),
    "units after an underscore": Text(("time_s", "pressure_kPa", "tip_angle_deg")),
    "units after a blank": Text(("Time s", "Pressure kPa", "Angle deg")),
    "units after a comma": Text(("Time, s", "Pressure, kPa", "Angle, deg")),
    "units of a program in capitals": Text(("TIME[S]", "PRESSURE[KPA]", "ANGLE[DEG]")),
    "milliseconds": Text(
        ("time_ms", "pressure_kPa", "angle_deg"), clock=lambda s: f"{1e3 * s:.0f}"
    ),
    "microseconds": Text(("t [µs]", "p [kPa]", "angle [deg]"), clock=lambda s: f"{1e6 * s:.0f}"),
    "minutes": Text(("t [min]", "p [kPa]", "angle [deg]"), clock=lambda s: f"{s / 60.0:.8f}"),
    "clock of minutes": Text(
        ("Time", *NAMES[1:]), clock=lambda s: f"{27 + int(s + 19) // 60}:{(s + 19) % 60:05.2f}"
    ),
    "clock of minutes past the hour": Text(("Time", *NAMES[1:]), clock=_stamp("%M:%S.%f", 2)),
    "clock of hours": Text(("Time", *NAMES[1:]), clock=_stamp("%H:%M:%S.%f")),
    "clock with a decimal comma": Text(
        ("Uhrzeit", "Druck [kPa]", "Winkel [Grad]"), clock=_stamp("%H:%M:%S,%f"), **SEMICOLONS
    ),
    "clock over midnight": Text(
        ("Time", *NAMES[1:]), clock=_stamp("%H:%M:%S.%f", begin=BEGIN.replace(hour=23))
    ),
    "clock of twelve hours": Text(("Time", *NAMES[1:]), clock=_stamp("%I:%M:%S.%f %p")),
    "ISO": Text(STAMPED, clock=_stamp("%Y-%m-%dT%H:%M:%S.%fZ")),
    "ISO with an offset": Text(STAMPED, clock=_stamp("%Y-%m-%dT%H:%M:%S.%f+01:00", 6)),
    "ISO with blank and comma": Text(STAMPED, clock=_stamp("%Y-%m-%d %H:%M:%S,%f"), **SEMICOLONS),
    "German dates": Text(
        ("Datum/Uhrzeit", "Druck [kPa]", "Winkel [°]"),
        clock=_stamp("%d.%m.%Y %H:%M:%S,%f"),
        **SEMICOLONS,
    ),
    "American dates": Text(STAMPED, clock=_stamp("%m/%d/%Y %I:%M:%S.%f %p")),
    "epoch in seconds": Text(STAMPED, clock=_epoch(1.0, "{:.3f}")),
    "epoch in milliseconds": Text(("timestamp_ms", *NAMES[1:]), clock=_epoch_whole(1000)),
    "epoch in milliseconds without a unit": Text(STAMPED, clock=_epoch_whole(1000)),
    "epoch in microseconds": Text(("timestamp", *NAMES[1:]), clock=_epoch_whole(10**6)),
    "epoch in nanoseconds": Text(("timestamp", *NAMES[1:]), clock=_epoch_whole(10**9)),
    "all in quotes": Text(quoted=True),
    "decimal commas in quotes": Text(quoted=True, decimal=","),
    "trailing delimiter": Text(trailing=True, **SEMICOLONS),
    "trailing delimiter but of the header": Text(trailing=True, trailing_header=False),
    "comments by number signs": Text(
        before=("# bench 3", "# 4 Hz, two sensors"), between=("# stopped for a look",)
    ),
    "comments by percent signs": Text(before=("% bench 3, left",), delimiter="\t"),
    "comments by slashes": Text(before=("// bench 3",), between=("// stopped",), **SEMICOLONS),
    "header behind a number sign": Text(
        ("t_s", "p_kPa", "angle_deg"), delimiter=" ", header_sign="# ", suffix=".dat"
    ),
    "header behind a percent sign": Text(header_sign="% ", delimiter="\t"),
    "blank rows": Text(between=("", "", ""), after=("", "")),
    "rows of delimiters": Text(between=(";;", ";;"), after=(";;",), **SEMICOLONS),
    "exponents": Text(number="{:.7E}"),
    "exponents and decimal commas": Text(number="{:.7E}", **SEMICOLONS),
    "plus signs": Text(number="{:+.5f}"),
    "minus signs of typesetters": Text(minus="\u2212"),
    "carriage returns": Text(line_end="\r"),
    "Windows": Text(line_end="\r\n", **SEMICOLONS),
    "doubled carriage returns": Text(line_end="\r\r\n"),
    "no last line end": Text(last_end=False),
    "line that names the delimiter": Text(before=("sep=;",), **SEMICOLONS),
    "line that names the comma": Text(before=('"sep=,"',)),
    "row numbers": Text(index="Nr."),
    "row numbers without a name": Text(index=""),
    "words": Text(text="phase"),
    "words without a name": Text(text=""),
    "another order": Text(order=(2, 0, 1)),
    "header of a long program": Text(
        before=(
            "LabVIEW Measurement\t",
            "Separator\tTab",
            "Decimal_Separator\t,",
            "***End_of_Header***\t",
            "Channels\t2\t",
            "***End_of_Header***\t\t",
        ),
        delimiter="\t",
        decimal=",",
        suffix=".lvm",
    ),
}


# ---------------------------------------------------------------------- spreadsheets
def _rows() -> list[list[object]]:
    return [list(map(float, row)) for row in zip(TIME, PRESSURE, ANGLE, strict=True)]


def _save(book: openpyxl.Workbook, folder: Path) -> Path:
    path = folder / "run_1.xlsx"
    book.save(path)
    return path


def _sheet(folder: Path, rows: list[list[object]], change: Callable | None = None) -> Path:
    book = openpyxl.Workbook()
    for row in rows:
        book.active.append(row)
    if change is not None:
        change(book)
    return _save(book, folder)


def _second_sheet(book: openpyxl.Workbook) -> None:
    notes = book.create_sheet("Notes", 0)
    notes.append(["bench 3"])
    notes.append(["operator", "M. M."])


def _merged_title(book: openpyxl.Workbook) -> None:
    book.active.merge_cells("A1:C1")


def _shifted(folder: Path) -> Path:
    book = openpyxl.Workbook()
    for number, row in enumerate([list(NAMES), *_rows()]):
        for place, value in enumerate(row):
            book.active.cell(number + 4, place + 2, value)
    return _save(book, folder)


def _dates(folder: Path) -> Path:
    moments = [BEGIN.replace(tzinfo=None) + datetime.timedelta(seconds=t) for t in TIME.tolist()]
    rows = [[when, *row[1:]] for when, row in zip(moments, _rows(), strict=True)]
    return _sheet(folder, [["Datum", *NAMES[1:]], *rows])


def _times(folder: Path) -> Path:
    moments = [BEGIN.replace(tzinfo=None) + datetime.timedelta(seconds=t) for t in TIME.tolist()]
    rows = [[when.time(), *row[1:]] for when, row in zip(moments, _rows(), strict=True)]
    return _sheet(folder, [["Uhrzeit", *NAMES[1:]], *rows])


def _texts(folder: Path) -> Path:
    rows = [[f"{value:.5f}".replace(".", ",") for value in row] for row in _rows()]
    return _sheet(folder, [list(NAMES), *rows])


def _chart_of_more(folder: Path) -> Path:
    rows = [[*row, None, "up"] for row in _rows()]
    return _sheet(folder, [[*NAMES, None, "phase"], *rows, [None], ["mean", 20.0, 45.0]])


SHEETS: dict[str, Callable[[Path], Path]] = {
    "sheet": lambda folder: _sheet(folder, [list(NAMES), *_rows()]),
    "sheet with title rows": lambda folder: _sheet(
        folder, [["Bench 3"], ["Date", "1 March"], [], list(NAMES), *_rows()]
    ),
    "sheet with a merged title": lambda folder: _sheet(
        folder, [["Bench 3, left finger"], list(NAMES), *_rows()], _merged_title
    ),
    "sheet with a row of units": lambda folder: _sheet(
        folder, [["Zeit", "Druck", "Winkel"], ["s", "kPa", "°"], *_rows()]
    ),
    "second sheet": lambda folder: _sheet(folder, [list(NAMES), *_rows()], _second_sheet),
    "table not in the corner": _shifted,
    "dates of a sheet": _dates,
    "times of a sheet": _times,
    "numbers as text": _texts,
    "sheet with an empty column and a sum": _chart_of_more,
}


# ---------------------------------------------------------------------- MATLAB
VECTORS = {"time_s": TIME, "pressure_kPa": PRESSURE, "angle_deg": ANGLE}


def _mat(folder: Path, content: dict[str, object], **options: object) -> Path:
    path = folder / "run_1.mat"
    scipy.io.savemat(path, content, **options)
    return path


def _cells(names: tuple[str, ...]) -> np.ndarray:
    return np.array([*names], dtype=object)


MATRIX = np.stack([TIME, PRESSURE, ANGLE], axis=1)
MATLAB: dict[str, Callable[[Path], Path]] = {
    "vectors": lambda folder: _mat(folder, VECTORS),
    "columns": lambda folder: _mat(folder, VECTORS, oned_as="column"),
    "version 4": lambda folder: _mat(folder, VECTORS, format="4"),
    "compressed": lambda folder: _mat(folder, VECTORS, do_compression=True),
    "structure": lambda folder: _mat(folder, {"data": VECTORS}),
    "structure in a structure": lambda folder: _mat(
        folder, {"log": {"name": "bench 3", "signals": VECTORS}}
    ),
    "matrix with a cell of names": lambda folder: _mat(
        folder, {"data": MATRIX, "names": _cells(NAMES)}
    ),
    "matrix with a cell of names in a structure": lambda folder: _mat(
        folder, {"log": {"values": MATRIX, "header": _cells(NAMES)}}
    ),
    "matrix in rows": lambda folder: _mat(
        folder, {"data": MATRIX.T.copy(), "labels": _cells(NAMES)}
    ),
}
WRITERS: dict[str, Callable[[Path], Path]] = {
    **{name: dialect.write for name, dialect in TEXTS.items()},
    **SHEETS,
    **{f"MATLAB: {name}": write for name, write in MATLAB.items()},
}
"""Every dialect by name: writes the run into a folder and returns the file."""
