"""Postures of people, from files of the user; such data are not shipped (8.2.3, Figs 8.11, 8.12).

A folder holds a CSV file for each person or data set. Its first line names the columns. The column
`grasp` (a number or a word) says which grasp a row belongs to; all others are coordinates of the
posture in one unit: fingertips [mm], or joint angles [deg]. Rows of the same grasp are repeats and
are averaged.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

GRASP = "grasp"
FEWEST = 5  # grasps of a person


def human_postures(folder: Path) -> dict[str, Array]:
    """Postures (grasps, coordinates) of each file of a folder, by its name.

    Raises ValueError for a folder without files, and for a file that is unusable.
    """
    files = sorted(folder.glob("*.csv"))
    if not files:
        raise ValueError(f"human: expected a folder with CSV files, got none in {folder}")
    return {file.stem: read_postures(file) for file in files}


def read_postures(file: Path) -> Array:
    """Mean posture (grasps, coordinates) of each grasp of a file; raises ValueError that names
    file, line, expected and got.
    """
    with file.open(newline="", encoding="utf-8") as lines:
        rows = list(csv.reader(lines))
    names = [name.strip() for name in rows[0]] if rows else []
    if names.count(GRASP) != 1 or len(names) < 3:
        raise ValueError(
            f"{file}:1: expected the column {GRASP} and two or more coordinates, got {names}"
        )
    by_grasp: dict[str, list[list[float]]] = {}
    for number, row in enumerate(rows[1:], 2):
        if row:
            grasp, place = _row(f"{file}:{number}", row, names)
            by_grasp.setdefault(grasp, []).append(place)
    if len(by_grasp) < FEWEST:
        raise ValueError(f"{file}: expected {FEWEST} grasps or more, got {len(by_grasp)}")
    return np.array([np.mean(places, axis=0) for places in by_grasp.values()])


def _row(where: str, row: list[str], names: list[str]) -> tuple[str, list[float]]:
    if len(row) != len(names):
        raise ValueError(f"{where}: expected {len(names)} values, got {len(row)}")
    at = names.index(GRASP)
    texts = row[:at] + row[at + 1 :]
    try:
        place = [float(text) for text in texts]
    except ValueError:
        raise ValueError(f"{where}: expected numbers, got {texts}") from None
    if not np.isfinite(place).all():
        raise ValueError(f"{where}: expected finite numbers, got {texts}")
    return row[at].strip(), place
