"""Findings as Markdown tables: rows, and columns where several things have the same figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeAlias

LEAST_THINGS = 3  # that share their figures, for a table of columns
Row: TypeAlias = tuple[str, str, str, str]  # what, thesis, ours, met
Things: TypeAlias = dict[str, dict[str, Row]]  # rows by thing and figure


def tables(rows: Sequence[Row], judged: bool) -> str:
    """Tables of rows whose `what` is free, or "thing: figure".

    At least three things with the same two or more figures share a table of columns. The thesis's
    value stands in a row of its own if it is the same for all things, else beside ours.

    >>> rows = [(f"{box}: {of}", "< 2", "1.5", "-") for box in "ABC" for of in ("drift", "noise")]
    >>> print(tables([("pulses", "122", "108", "-"), *rows], judged=False))
    | what | thesis | here |
    | --- | --- | --- |
    | pulses | 122 | 108 |
    <BLANKLINE>
    | what | drift | noise |
    | --- | --- | --- |
    | thesis | < 2 | < 2 |
    | A | 1.5 | 1.5 |
    | B | 1.5 | 1.5 |
    | C | 1.5 | 1.5 |
    """
    things = _things(rows)
    placed = {row for of_thing in things.values() for row in of_thing.values()}
    free = [row for row in rows if row not in placed]
    columns = 4 if judged else 3
    head = ("what", "thesis", "here", "met")
    parts = [[head[:columns], *(row[:columns] for row in free)]] if free or not things else []
    parts += [_columns(things)] if things else []
    return "\n\n".join(map(_markdown, parts))


def _things(rows: Sequence[Row]) -> Things:
    """Things with the same figures, none if they are too few; judged rows are left alone."""
    found: Things = {}
    for row in rows:
        thing, colon, figure = row[0].partition(": ")
        if colon and row[3] == "-":
            found.setdefault(thing, {})[figure] = row
    figures = [tuple(of_thing) for of_thing in found.values()]
    alike = len(set(figures)) == 1 and len(figures[0]) > 1
    return found if alike and len(found) >= LEAST_THINGS else {}


def _columns(things: Things) -> list[tuple[str, ...]]:
    figures = list(next(iter(things.values())))
    theses = {of: {rows[of][1] for rows in things.values()} for of in figures}
    common = {of: next(iter(seen)) if len(seen) == 1 else "-" for of, seen in theses.items()}
    told = [("thesis", *common.values())] if set(common.values()) != {"-"} else []
    lines = [
        (thing, *(_cell(rows[of], common) for of in figures)) for thing, rows in things.items()
    ]
    return [("what", *figures), *told, *lines]


def _cell(row: Row, common: Mapping[str, str]) -> str:
    """Our value, with the thesis's where it is not that of all things."""
    own = row[1] not in ("-", common[row[0].partition(": ")[2]])
    return f"{row[2]} (thesis: {row[1]})" if own else row[2]


def _markdown(lines: Sequence[Sequence[str]]) -> str:
    ruled = [lines[0], ("---",) * len(lines[0]), *lines[1:]]
    return "\n".join(f"| {' | '.join(line)} |" for line in ruled)
