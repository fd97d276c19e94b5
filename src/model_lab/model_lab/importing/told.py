"""What an import says and asks: the columns with a curve of each, what is open, and the command."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from model_lab.aliases import Array
from model_lab.importing.importing import Maps, Proposal

LEVELS = "▁▂▃▄▅▆▇█"
CURVE_WIDTH = 16  # characters


def table_rows(proposal: Proposal) -> list[list[str]]:
    """Rows of text for every column of the files, the header first."""
    curves = [column.values for source in proposal.sources for column in source.table.columns]
    rows = [["file", "column", "unit", "is", "in", "course"]]
    for row, values in zip(proposal.rows, curves, strict=True):
        rows.append([*row, curve(values)])
    return rows


def curve(values: Array) -> str:
    """A small picture of numbers (rows,) in one line of text.

    >>> curve(np.linspace(0.0, 1.0, 8))
    '▁▂▃▄▅▆▇█'
    """
    known = values[np.isfinite(values)]
    if not len(known):
        return ""
    places = np.linspace(0, len(known) - 1, min(CURVE_WIDTH, len(known))).round().astype(int)
    span = float(np.ptp(known)) or 1.0
    levels = (known[places] - known.min()) / span * (len(LEVELS) - 1)
    return "".join(LEVELS[round(level)] for level in levels)


def asked(proposal: Proposal, maps: Maps, ask: Callable[[str], str]) -> dict[str, tuple[str, str]]:
    """The maps with what the user answers for columns without unit and missing columns."""
    answers = dict(maps)
    for source in proposal.sources:
        for meant in source.meanings:
            if not meant.is_sure and meant.quantity not in answers:
                unit = ask(f"unit of {meant.column} ({meant.quantity})? ").strip()
                answers[meant.quantity] = (meant.column, unit)
    for what in proposal.unsure:
        if what.startswith("the column of "):
            quantity = what.removeprefix("the column of ")
            name, _, unit = ask(f"column of {quantity} (NAME:UNIT)? ").partition(":")
            answers[quantity] = (name.strip(), unit.strip())
    return answers


def again(
    files: Sequence[Path],
    out: Path,
    experiment: str | None,
    maps: Maps,
    hand: str | None,
    shifts: Mapping[str, float],
    messages: Path | None = None,
    decimal: str | None = None,
) -> str:
    """The command that makes the same set again without questions."""
    words = ["model-lab", "import", *map(str, files), "-o", str(out)]
    if experiment:
        words += ["--experiment", experiment]
    for quantity, (name, unit) in maps.items():
        words += ["--map", f"{quantity}={name}{f':{unit}' if unit else ''}"]
    for name, shift in shifts.items():
        words += ["--shift", f"{name}={shift:g}"]
    if messages:
        words += ["--msgs", str(messages)]
    if decimal:
        words += ["--decimal", decimal]
    if hand:
        words += ["--hand", hand]
    return shlex.join([*words, "--yes"])
