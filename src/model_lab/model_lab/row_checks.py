"""Checks of what a run holds, by row: time rises, and no value lies where none can."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from softhand_model.document import DocumentError

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# by column: which values (in SI units) are wrong, what was expected, the mend
_RANGES: dict[str, tuple[Callable[[Array], Mask], str, str]] = {
    "stretch": (
        lambda values: values <= 0.0,
        "a number above 0",
        "stretch is 1 at rest, that is strain + 1",
    ),
    "p_in": (lambda values: values <= 0.0, "a number above 0", "pulses need absolute pressures"),
    "p_out": (lambda values: values <= 0.0, "a number above 0", "pulses need absolute pressures"),
    "duration": (lambda values: values <= 0.0, "a number above 0", "take the row out"),
    "direction": (
        lambda values: np.abs(values) != 1.0,
        "1 (inflate) or -1 (deflate)",
        "take the row out",
    ),
}


def row_name(index: int) -> str:
    """How a row is called in errors, given its index from 0 in a file without blank lines.

    >>> row_name(0)
    'row 1 (line 2 of the file)'
    """
    return f"row {index + 1} (line {index + 2} of the file)"


def check_rows(path: Path, columns: Mapping[str, Array]) -> None:
    """Raise DocumentError where time does not rise or a column leaves its range.

    Args:
        path: the file, for the error.
        columns: (rows,) in SI units by name.
    """
    if "time" in columns:
        _check_time(path, columns["time"])
    for name in columns.keys() & _RANGES.keys():
        is_wrong, expected, mend = _RANGES[name]
        wrong = is_wrong(columns[name])
        if wrong.any():
            index = int(np.argmax(wrong))
            raise DocumentError(
                f"{path}: {row_name(index)}, column {name}: expected {expected} in SI units, "
                f"got {columns[name][index]:g}; {mend}"
            )


def _check_time(path: Path, time: Array) -> None:
    wrong = np.diff(time) <= 0.0
    if wrong.any():
        index = int(np.argmax(wrong)) + 1
        same = time[index] == time[index - 1]
        mend = "keep one row for each time" if same else "sort the rows, one run in each file"
        raise DocumentError(
            f"{path}: {row_name(index)}, column time: expected a time after "
            f"{time[index - 1]:.9g} s, got {time[index]:.9g} s{' again' if same else ''}; {mend}"
        )
