"""Impossible values in a run: refused, or kept with a doubt where a slip may explain them.

A strain or a stretch in percent in the place of a stretch, or the gauge pressure of a pulse in the
place of an absolute one, is a slip in how the set is stated. It is kept as it was read, so that
`slips` can find it; no model is driven with it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from model_lab.aliases import Array, Mask
from model_lab.measurements.held_input import DRIVING_COLUMN
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.units import largest, unit_of
from softhand_common.documents.quoted import shortened
from softhand_common.documents.yaml_document import DocumentError

TEMPERATURES = (200.0, 500.0)  # [K] between which a run is believed
STRETCHES = (0.1, 50.0)  # what could be a stretch
STRETCH_NUMBERS = (-90.0, 5000.0)  # what could be one, or a strain, in percent or not
_NOT_STRETCHES = (
    f"a number from {STRETCHES[0]:g} to {STRETCHES[1]:g}",
    "stretch is 1 at rest, that is strain + 1; if it is strain, write columns: {stretch: "
    "{unit: '', is: strain}}, with unit: percent if it is in percent",
)
VACUUM = -110e3  # [Pa], below which not even a gauge pressure lies
_PULSES = (
    "a number above 0",
    "pulses need absolute pressures; if p_in and p_out are gauge pressures, write is: gauge beside "
    "the unit of each under columns",
)
# by column: which values (in SI units) are wrong, what was expected, the mend
_RANGES: dict[str, tuple[Callable[[Array], Mask], str, str]] = {
    "stretch": (lambda values: ~_within(values, STRETCH_NUMBERS), *_NOT_STRETCHES),
    "p_in": (lambda values: values <= VACUUM, *_PULSES),
    "p_out": (lambda values: values <= VACUUM, *_PULSES),
    "temperature": (
        lambda values: ~_within(values, TEMPERATURES),
        f"a temperature of {TEMPERATURES[0]:g} to {TEMPERATURES[1]:g} K",
        "state its unit under columns, such as degC",
    ),
    "duration": (lambda values: values <= 0.0, "a number above 0", "take the row out"),
    "direction": (
        lambda values: np.abs(values) != 1.0,
        "1 (inflate) or -1 (deflate)",
        "take the row out",
    ),
}
_DOUBTS = {
    "stretch": (lambda values: ~_within(values, STRETCHES), *_NOT_STRETCHES),
    "p_in": (lambda values: values <= 0.0, *_PULSES),
    "p_out": (lambda values: values <= 0.0, *_PULSES),
}


def _within(values: Array, ends: tuple[float, float]) -> Mask:
    return (values >= ends[0]) & (values <= ends[1])


def row_name(index: int) -> str:
    """Name of a row in error messages, from its index (from 0) in a file without blank lines.

    >>> row_name(0)
    'row 1 (line 2 of the file)'
    """
    return f"row {index + 1} (line {index + 2} of the file)"


def check_rows(path: Path, columns: Mapping[str, Array]) -> list[str]:
    """Raise DocumentError if time does not rise or a column leaves its range.

    Args:
        path: the file, for the error.
        columns: columns (rows,) in SI units, by name.

    Returns:
        error messages on values that are kept although they are impossible for their column.
    """
    for name, values in columns.items():
        most = largest(unit_of(name))
        _refuse(_wrong(path, name, values, np.abs(values) > most, f"{most:g} at most in size"))
    if "time" in columns:
        check_time(path, columns)
    for name in columns.keys() & _RANGES.keys():
        _refuse(_out_of_range(path, name, columns[name], _RANGES))
    doubts = [
        _out_of_range(path, name, columns[name], _DOUBTS) for name in columns.keys() & _DOUBTS
    ]
    return [doubt for doubt in doubts if doubt is not None]


def require_possible(data: MeasurementSet) -> None:
    """Raise DocumentError if a run has values that were kept although they are impossible."""
    wrong = _impossible(data)
    _refuse(wrong and next(iter(data.doubts), wrong))  # as it was told of the file


def is_possible(data: MeasurementSet) -> bool:
    """Whether all values of all runs are possible for their column."""
    return _impossible(data) is None


def _impossible(data: MeasurementSet) -> str | None:
    for run in data.runs:
        for name in run.columns.keys() & _DOUBTS:
            wrong = _out_of_range(data.folder / run.name, name, run.columns[name], _DOUBTS)
            if wrong is not None:
                return wrong
    return None


def _out_of_range(path: Path, name: str, values: Array, ranges: Mapping) -> str | None:
    is_wrong, expected, mend = ranges[name]
    return _wrong(path, name, values, is_wrong(values), expected, f"; {mend}")


def _refuse(message: str | None) -> None:
    if message is not None:
        raise DocumentError(message)


def _wrong(
    path: Path, name: str, values: Array, wrong: Mask, expected: str, mend: str = ""
) -> str | None:
    """What is wrong with the first of the wrong values (rows,); None where none is wrong."""
    if not wrong.any():
        return None
    index = int(np.argmax(wrong))
    return (
        f"{path}: {row_name(index)}, column {shortened(name)}: expected {expected} in SI "
        f"units, got {values[index]:g}{mend}"
    )


def check_time(
    path: Path, columns: Mapping[str, Array], name_of: Callable[[int], str] = row_name
) -> None:
    """Raise DocumentError where the column `time` (rows,) [s] does not rise.

    name_of: returns the name of a row from its index. The other columns help to say in the message
    what is wrong.
    """
    time = columns["time"]
    wrong = np.diff(time) <= 0.0
    if wrong.any():
        index = int(np.argmax(wrong)) + 1
        same = time[index] == time[index - 1]
        mend = "sort the rows, one run in each file"
        if same:
            mend = "keep one row for each time"
        elif time[index] == time[0]:
            mend = "the clock restarts: write each run into its own file"
        elif (driving := _driving_in_order(columns)) is not None:
            mend = (
                f"the rows are in order, as {driving} goes on smoothly: leave `time` out of "
                "`columns`, or mend the clock; one run in each file"
            )
        raise DocumentError(
            f"{path}: {name_of(index)}, column time: expected a time after "
            f"{time[index - 1]:.9g} s, got {time[index]:.9g} s{' again' if same else ''}; {mend}"
        )


def _driving_in_order(columns: Mapping[str, Array]) -> str | None:
    """The driving column, if sorting the rows by time would make it more ragged than it is."""
    for name in set(DRIVING_COLUMN.values()) & columns.keys():
        values = columns[name]
        ordered = values[np.argsort(columns["time"], kind="stable")]
        if np.abs(np.diff(values)).sum() < np.abs(np.diff(ordered)).sum():
            return name
    return None
