"""Output and questions of an import: the columns with a small plot of each, open questions, and the
command.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from model_lab.aliases import Array
from model_lab.importing.derived import OPEN_AREA, OPEN_LENGTH
from model_lab.importing.derived_columns import Maps
from model_lab.importing.importing import Proposal
from model_lab.measurements.hands import Grasped, Plate

LEVELS = "▁▂▃▄▅▆▇█"
CURVE_WIDTH = 16  # characters
SHOWN_ALIKE = 2  # files with the same columns of which each column is shown


def table_rows(proposal: Proposal) -> list[list[str]]:
    """Rows of text for a table of all columns of the files, the header first. Of more than
    SHOWN_ALIKE files with the same columns, the others have one row each.
    """
    rows, known = [["file", "column", "unit", "is", "in", "course"]], list(proposal.rows)
    alike: dict[tuple[tuple[str, ...], ...], list[str]] = {}
    for source in proposal.sources:
        columns = source.table.columns
        own, known = known[: len(columns)], known[len(columns) :]
        files = alike.setdefault(tuple(row[1:] for row in own), [])
        files.append(source.table.path.name)
        if len(files) > SHOWN_ALIKE and len(own) > 1:
            rows.append([files[-1], f"as in {files[0]}", "", "", "", ""])
            continue
        rows += [[*row, curve(column.values)] for row, column in zip(own, columns, strict=True)]
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
    """The `maps` together with the answers of the user on columns without unit, on missing columns,
    and on sizes of the specimen; ask: puts a question and returns the answer.
    """
    answers = dict(maps)
    for source in proposal.sources:
        for meant in source.meanings:
            if not meant.is_sure and meant.quantity not in answers:
                unit = ask(f"unit of {meant.column} ({meant.quantity})? ").strip()
                answers[meant.quantity] = (meant.column, unit)
    for what, how in proposal.unsure.items():
        option, _, wanted = how.rpartition("', ")
        size = next((word for word in (OPEN_LENGTH, OPEN_AREA) if wanted.startswith(word)), None)
        if size:
            quantity, _, call = option.removeprefix("--map '").partition("=")
            answer = ask(f"{wanted.removeprefix(size).strip()}? ").strip()
            answers[quantity] = (call.replace(size, answer), "")
        if what.startswith("the column of "):
            quantity = what.removeprefix("the column of ")
            name, _, unit = ask(f"column of {quantity} (NAME:UNIT)? ").partition(":")
            answers[quantity] = (name.strip(), unit.strip())
    return answers


@dataclass(frozen=True)
class Said:
    """What the user stated about the files by options of the command."""

    experiment: str | None
    maps: Maps
    hand: str | None
    shifts: Mapping[str, float]
    messages: Path | None = None
    decimal: str | None = None
    specimens: Mapping[str, str] = field(default_factory=dict)
    stretched_to: Mapping[str, float] = field(default_factory=dict)
    sheets: Mapping[str, str] = field(default_factory=dict)
    wrist: Mapping[str, Sequence[float]] = field(default_factory=dict)
    modes: Mapping[str, str] = field(default_factory=dict)
    split_restarts: bool = False
    touched: Grasped | Plate | None = None

    @property
    def words(self) -> list[str]:
        """The options with their values, as words of a command line."""
        given = {
            "--experiment": self.experiment,
            "--msgs": self.messages,
            "--decimal": self.decimal,
            "--hand": self.hand,
        }
        words = [word for option, value in given.items() if value for word in (option, str(value))]
        for quantity, (name, unit) in self.maps.items():
            words += ["--map", f"{quantity}={name}{f':{unit}' if unit else ''}"]
        for name, shift in self.shifts.items():
            words += ["--shift", f"{name}={shift:g}"]
        for name, specimen in self.specimens.items():
            words += ["--specimen", f"{name}={specimen}" if name else specimen]
        for name, stretch in self.stretched_to.items():
            words += ["--stretched-to", f"{name}={stretch:g}" if name else f"{stretch:g}"]
        for name, sheet in self.sheets.items():
            words += ["--sheet", f"{name}={sheet}" if name else sheet]
        for name, mode in self.modes.items():
            words += ["--mode", f"{name}={mode}" if name else mode]
        words += ["--split-restarts"] if self.split_restarts else []
        for name, held in self.wrist.items():
            angles = ",".join(f"{angle:g}" for angle in np.rad2deg(held))
            words += ["--wrist", f"{name}={angles}" if name else angles]
        if isinstance(self.touched, Grasped):
            words += ["--object", self.touched.object, "--scene", self.touched.scene]
        elif self.touched:
            words += ["--plate", f"{self.touched.friction:g},{self.touched.height:g}"]
        return words


def again(files: Sequence[Path], out: Path, said: Said) -> str:
    """The command line that makes the same set again without questions."""
    words = ["model-lab", "import", *map(str, files), "-o", str(out), *said.words, "--yes"]
    return shlex.join(words)
