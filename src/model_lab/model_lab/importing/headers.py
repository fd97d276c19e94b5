"""Names and units of columns, from the lines above the numbers."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise

from model_lab.importing.cells import Row
from model_lab.importing.numerals import is_number
from model_lab.importing.units import is_unit, unit_in_header

LEAST_FILLED = 4  # columns from which on a header may lack the name of the last
LENGTHS = ("m", "cm", "mm")  # units of places; elsewhere such words may be part of a name
MOST_LEVELS = 6  # lines of a header that are looked at; motion capture writes five
LENGTH_UNITS, POSITION = "length units", "position"  # as OptiTrack's Motive writes
WRITTEN_LENGTHS = {"meters": "m", "centimeters": "cm", "millimeters": "mm"}
LABVIEW_X, LABVIEW_UNITS, LABVIEW_DIMENSION = "X_Value", "Y_Unit_Label", "X_Dimension"
IDENTIFIER = re.compile(r"[0-9A-Fa-f:]*[0-9][0-9A-Fa-f:]*$")  # of a body, which no one reads


def header(before: Sequence[Row], width: int) -> tuple[list[str], list[str], int]:
    """(names, units as written, number of header lines) of `width` columns.

    before: rows of cells above the numbers. If the last line has the same name several times, as in
    files of motion capture, where x and y stand below each body, words of the lines above are put
    before it: `tip x`.
    """
    levels = _levels(before, width)
    if not levels:
        return [f"column {place + 1}" for place in range(width)], [""] * width, 0
    for units, above in pairwise(levels):
        if _is_row_of_units(units):
            return _unique(above), [cell.strip("[]() ") for cell in units], 2
    parts = [unit_in_header(cell) for cell in levels[0]]
    repeated = {name for name, _ in parts if [one for one, _ in parts].count(name) > 1}
    for place, (name, unit) in enumerate(parts):
        if unit.isdecimal() and name in repeated:  # the number of a channel
            parts[place] = levels[0][place], ""
    names = [name for name, _ in parts]
    used = 1
    for number, level in enumerate(levels[1:], 2):
        if len(set(names)) == len(names):
            break
        if _tells_apart(names, level):
            names = [
                f"{above} {name}".strip() if above else name
                for above, name in zip(level, names, strict=True)
            ]
            used = number
    units = [unit for _, unit in parts]
    lengths = _of_tracker(before, levels) or units
    units = [one or length for one, length in zip(units, lengths, strict=True)]
    return _unique(names), units if any(units) else _of_labview(before, names) or units, used


def _of_labview(before: Sequence[Row], names: Sequence[str]) -> list[str]:
    """Units that the header of a LabVIEW measurement file states; none if it is no such file."""
    labels = {row[0]: row[1:] for row in before if row}
    if names[0] != LABVIEW_X or LABVIEW_UNITS not in labels:
        return []
    dimension = next(iter(labels.get(LABVIEW_DIMENSION, ["Time"])), "")
    units = ["s" if dimension == "Time" else "", *labels[LABVIEW_UNITS]]
    return [*units, *[""] * len(names)][: len(names)]


def _of_tracker(before: Sequence[Row], levels: Sequence[Row]) -> list[str]:
    """Units of the positions in a file of motion capture, which states one length unit for all;
    none if it does not.
    """
    for row in before:
        for key, value in pairwise(row):
            if key.strip().casefold() == LENGTH_UNITS:
                unit = WRITTEN_LENGTHS.get(value.strip().casefold(), "")
                cells = zip(*levels, strict=True)
                return [unit if POSITION in map(str.casefold, above) else "" for above in cells]
    return []


def _levels(before: Sequence[Row], width: int) -> list[Row]:
    """The lines of the header, the last first, each with a cell for every column."""
    levels: list[Row] = []
    for row in reversed(before[-MOST_LEVELS:]):
        cells = _filled(row, width)
        if cells is None:
            if not levels and row is before[-1]:
                continue  # a line between the header and the numbers
            break
        levels.append(cells)
    return levels


def _filled(row: Row, width: int) -> Row | None:
    """The cells of a line of the header; None for another line.

    Units in brackets are put back to their names, where blanks part columns. A last cell may be
    missing, and there may be one beyond the numbers, such as that of a comment.
    """
    if len(row) == width:
        return row
    together = re.sub(r"\s+(?=[\[(])", "", " ".join(row)).split(" ")
    if len(together) == width:
        return together
    if len(row) == width - 1 >= LEAST_FILLED - 1:
        return [*row, ""]
    return row[:width] if len(row) == width + 1 and all(row) else None


def _is_row_of_units(cells: Row) -> bool:
    """Whether each cell is a unit, in brackets or not, or empty; one at least is one."""
    texts = [cell.strip("[]() ") for cell in cells]
    return any(texts) and all(text in ("", "-", *LENGTHS) or is_unit(text) for text in texts)


def _tells_apart(names: Sequence[str], level: Row) -> bool:
    """Whether the cells of a line above are words that differ where names are the same."""
    words = [cell for cell in level if cell]
    if all(IDENTIFIER.match(word) or is_number(word) for word in words):
        return False
    return len(set(zip(level, names, strict=True))) > len(set(names))


def _unique(names: Sequence[str]) -> list[str]:
    """Names of columns, none empty and none twice."""
    found: list[str] = []
    for place, name in enumerate(names):
        plain = name.strip().strip('"') or f"column {place + 1}"
        found.append(plain if plain not in found else f"{plain} ({place + 1})")
    return found
