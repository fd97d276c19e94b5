"""Lines as programs of microcontrollers print them: `pressure:12.3,angle:4.5`, JSON objects, and
with the stamp that a serial monitor puts in front, `14:05:23.121 -> `.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence

Row = list[str]

STAMPED_LINE = re.compile(r"\s*(?P<time>\d{1,2}:\d\d:\d\d(?:[.,]\d+)?)\s*->\s?(?P<rest>.*)$")
PAIR = re.compile(
    r"(?P<name>[^\W\d][^:=,;|\t]*?)\s*[:=]\s*(?P<value>[-+]?(?:\d+(?:[.,]\d+)?|\.\d+)(?:[eE][-+]?\d+)?)"
    r"(?:\s?(?P<unit>[^\s\d,;|:=]+(?![^,;|\t\s])))?"
)
SEPARATORS = re.compile(r"[\s,;|]*")
ALIKE_SHARE = 0.8  # share of the lines that must be of one kind
CLOCK_NAME = "time"


def without_stamps(lines: Sequence[str]) -> tuple[list[str], list[str]]:
    """(lines, stamps): the lines without the stamps in front of them, and the stamps; none where
    not most lines have one.

    >>> without_stamps(["14:05:23.121 -> 1,2", "14:05:23.221 -> 3,4"])
    (['1,2', '3,4'], ['14:05:23.121', '14:05:23.221'])
    """
    filled = [line for line in lines if line.strip()]
    found = [match for match in map(STAMPED_LINE.match, filled) if match]
    if len(found) < max(2.0, ALIKE_SHARE * len(filled)):
        return list(lines), []
    return [match["rest"] for match in found], [match["time"] for match in found]


def named_rows(lines: Sequence[str]) -> tuple[list[Row], list[int]]:
    """(rows, lines): a header and rows of numbers of lines that name each number, and the index of
    the line of each row but the header; empty where not most lines do, or not with the same names.

    >>> named_rows(["ready", *(f"p: {n}.5 kPa, angle = {n}" for n in range(4)), ""])[0][:2]
    [['p [kPa]', 'angle'], ['0.5', '0']]
    """
    read = {place: _named(line) for place, line in enumerate(lines) if line.strip()}
    named = {place: row for place, row in read.items() if len(row) > 1}
    if len(named) < max(2.0, ALIKE_SHARE * len(read)):
        return [], []
    header = next(iter(named.values())).keys()
    same = {place: row for place, row in named.items() if row.keys() == header}
    if len(same) < ALIKE_SHARE * len(named):
        return [], []
    return [list(header), *(list(row.values()) for row in same.values())], list(same)


def _named(line: str) -> dict[str, str]:
    """The numbers of a line by name and unit; empty for another line."""
    if line.lstrip().startswith("{"):
        try:
            found = json.loads(line)
        except ValueError:
            return {}
        return {key: repr(value) for key, value in _numbers(found).items()}
    pairs = list(PAIR.finditer(line))
    if not pairs or SEPARATORS.fullmatch(PAIR.sub("", line)) is None:
        return {}
    return {
        pair["name"].strip() + (f" [{pair['unit']}]" if pair["unit"] else ""): pair["value"]
        for pair in pairs
    }


def _numbers(found: Mapping[str, object], before: str = "") -> dict[str, float]:
    """The numbers of a JSON object, those of objects inside of it by `outer.inner`."""
    numbers: dict[str, float] = {}
    for key, value in found.items():
        if isinstance(value, Mapping):
            numbers |= _numbers(value, f"{before}{key}.")
        elif isinstance(value, int | float) and not isinstance(value, bool):
            numbers[f"{before}{key}"] = value
    return numbers
