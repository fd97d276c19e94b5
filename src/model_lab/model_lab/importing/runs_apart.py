"""Runs that share a table: one below the other, or side by side."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from model_lab.importing.cell_words import mode_in
from model_lab.importing.clocks import pauses, restarts
from model_lab.importing.meaning import quantity_of
from model_lab.importing.runs import Source
from model_lab.importing.specimens import SPECIMEN_NAMES
from model_lab.importing.tables import Table, labelled
from softhand_common.documents.quoted import listed

REPEAT = re.compile(
    r"(?:^|[\s_(-])(?:trial|run|test|rep|repeat|repetition|cycle|versuch|messung|lauf|zyklus|essai|"
    r"ensayo|prova)[\s_#]*(?P<number>\d+)(?=$|[\s_)-])",
    re.I,
)  # in the name of a column: which repeat of a measurement it is

SPECIMEN_IN_NAME = re.compile(
    rf"(?:^|[\s_(-])(?P<kind>{SPECIMEN_NAMES})[\s_#]+(?P<name>[A-Za-z]|\d+)(?=$|[\s_)-])",
    re.I,
)  # in the name of a column: which specimen it is of
NUMBER_AT_END = re.compile(r"[\s_#]+(?P<number>\d+)$")
FIRST_RUN = "_1"  # run of a numbered finger, which a number alone at the end would not be
NUMBERED = 3  # columns; two may be two sensors
REPEATED_OUTPUTS = ("tip_angle", "tip_force", "stress")


def parted_at_restarts(source: Source) -> tuple[Source, ...]:
    """The runs of a file whose clock begins anew or pauses before each; the file itself if it never
    does.
    """
    clock = next((one for one in source.meanings if one.quantity == "time"), None)
    if clock is None:
        return (source,)
    time = source.values_of(clock)
    known = np.flatnonzero(np.isfinite(time))
    anew = restarts(time[known])
    begins = known[anew if len(anew) else pauses(time[known])]
    if not len(begins):
        return (source,)
    table, ends = source.table, [0, *begins.tolist(), len(time)]
    remark = (
        f"its clock {'begins anew' if len(anew) else 'goes on after a pause'} in row "
        f"{' and '.join(str(row + 1) for row in begins)}: its "
        f"parts are {len(ends) - 1} runs, and repeats of one protocol where they are driven alike"
    )
    return tuple(
        replace(
            source,
            table=replace(
                table,
                path=labelled(table.path, str(number)),
                columns=tuple(replace(one, values=one.values[a:b]) for one in table.columns),
                remarks=() if a else (*table.remarks, remark),
            ),
        )
        for number, (a, b) in enumerate(pairwise(ends), 1)
    )


def runs_apart(table: Table) -> Iterator[Table]:
    """The tables of the runs that share a table; the table itself if it holds a single run."""
    for run in _by_labels(table):
        for part in _side_by_side(run):
            for of_mode in _modes_apart(part):
                for of_specimen in _specimens_apart(of_mode):
                    yield from _repeats_apart(of_specimen)


def _by_labels(table: Table) -> tuple[Table, ...]:
    """The tables of the runs that a file has one below the other, each with the name of its label;
    without labels, the table itself.
    """
    path = table.path
    parts: list[Table] = []
    for label in dict.fromkeys(table.labels):
        rows = np.array([one == label for one in table.labels])
        columns = tuple(replace(one, values=one.values[rows]) for one in table.columns)
        parts.append(Table(labelled(path, label), columns, () if parts else table.remarks))
    return tuple(parts) or (table,)


def _side_by_side(table: Table) -> tuple[Table, ...]:
    """The tables that stand side by side in a file, each of which begins with a column of the same
    name, such as Time, Pressure, Time, Angle. If there is only one, the table itself.
    """
    first = table.columns[0].name
    starts = [
        place
        for place, column in enumerate(table.columns)
        if column.name in (first, f"{first} ({place + 1})")
    ]
    ends = [*starts[1:], len(table.columns)]
    if len(starts) < 2 or any(end - start < 2 for start, end in zip(starts, ends, strict=True)):
        return (table,)
    parts = (table.columns[start:end] for start, end in zip(starts, ends, strict=True))
    return tuple(
        replace(table, columns=(replace(of_part[0], name=first), *of_part[1:])) for of_part in parts
    )


def _modes_apart(table: Table) -> tuple[Table, ...]:
    """The tables of the modes of a test of rubber that stand side by side, such as Stretch biaxial,
    Stress biaxial, Stretch uniaxial, ...; the table itself unless two modes have two columns each.
    """
    modes = [mode_in(column.name) for column in table.columns]
    found = [mode for mode in dict.fromkeys(modes) if mode and modes.count(mode) > 1]
    if len(found) < 2:
        return (table,)
    pairs = [*zip(table.columns, modes, strict=True)]
    return tuple(
        replace(
            table,
            path=labelled(table.path, mode),
            columns=tuple(column for column, of in pairs if of in (mode, "")),
        )
        for mode in found
    )


def _specimens_apart(table: Table) -> tuple[Table, ...]:
    """The tables of the specimens that stand side by side, such as Pressure, Finger A, Finger B:
    one for each, with the columns of none. With fewer than two, the table itself.
    """
    found = [SPECIMEN_IN_NAME.search(column.name) for column in table.columns]
    names = {one["name"]: one["kind"].capitalize() for one in found if one}
    if len(names) < 2 or all(found):
        return (table,)
    return tuple(
        replace(
            table,
            path=labelled(
                table.path, f"{kind}{name}{FIRST_RUN if _is_of_finger(kind, name) else ''}"
            ),
            columns=tuple(
                replace(
                    column, name=SPECIMEN_IN_NAME.sub(r" \g<kind> ", column.name).strip(" _-()")
                )
                if one
                else column
                for column, one in zip(table.columns, found, strict=True)
                if one is None or one["name"] == name
            ),
        )
        for name, kind in names.items()
    )


def _is_of_finger(kind: str, number: str) -> bool:
    """Whether a number stands for a finger, and not for one of equal strips."""
    return number.isdecimal() and kind.casefold() in ("finger", "actuator", "aktor")


def _numbered(table: Table) -> list[re.Match[str] | None]:
    """Where the names of columns tell a repeat: by a word such as trial, else by the numbers of
    NUMBERED columns or more of the same output and unit, such as Force 1, Force 2, Force 3.
    """
    found = [REPEAT.search(column.name) for column in table.columns]
    if any(found):
        return found
    ends = [NUMBER_AT_END.search(column.name) for column in table.columns]
    kinds = [
        (NUMBER_AT_END.sub("", column.name), column.unit) if end else None
        for column, end in zip(table.columns, ends, strict=True)
    ]
    numbered = [kind for kind in kinds if kind]
    most = max(numbered, key=numbered.count, default=None)
    if most is None or numbered.count(most) < NUMBERED:
        return found
    first = table.columns[kinds.index(most)]
    if quantity_of(replace(first, name=most[0])) not in REPEATED_OUTPUTS:
        return found
    return [end if kind == most else None for kind, end in zip(kinds, ends, strict=True)]


def _repeats_apart(table: Table) -> tuple[Table, ...]:
    """The tables of the repeats that a file has side by side, such as Pressure, Trial 1, Trial 2:
    one for each number, with the columns that have no number. Without such columns, or with a
    single number, the table itself.
    """
    found = _numbered(table)
    numbers = dict.fromkeys(one["number"] for one in found if one)
    if len(numbers) < 2:
        return (table,)
    named = [column.name for column, one in zip(table.columns, found, strict=True) if one]
    remark = f"{listed(named)} are taken as {len(numbers)} runs"
    return tuple(
        replace(
            table,
            columns=tuple(
                replace(column, name=_without_repeat(column.name)) if one else column
                for column, one in zip(table.columns, found, strict=True)
                if one is None or one["number"] == number
            ),
            remarks=(*table.remarks, remark),
        )
        for number in numbers
    )


def _without_repeat(name: str) -> str:
    """The name of a column without the number of the repeat.

    >>> _without_repeat("Angle (trial 2)"), _without_repeat("Trial 2"), _without_repeat("Force 3")
    ('Angle', 'Trial', 'Force')
    >>> _without_repeat("Valve 1 (trial 2)")
    'Valve 1'
    """
    number = REPEAT if REPEAT.search(name) else NUMBER_AT_END
    return number.sub("", name).strip(" _-()") or name.strip(" _-()0123456789#")
