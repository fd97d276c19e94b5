"""The folder of a measurement set: experiment.yaml and one CSV per run."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import yaml

Array = np.ndarray
FORMAT = "softhand-measurement/1"
IN_SI = {"kPa": 1e3, "bar": 1e5, "deg": np.pi / 180, "ms": 1e-3, "mg": 1e-6, "mN*m": 1e-3}


def in_unit(values: Array | float, unit: str) -> Array | float:
    """SI values in a unit of the files (those not listed are SI)."""
    return values / IN_SI.get(unit, 1.0)


def write_set(
    folder: Path,
    head: dict[str, Any],
    units: dict[str, str],
    noise: dict[str, float] | None,
    runs: dict[str, tuple[dict[str, Any], dict[str, Array]]],
) -> None:
    """Write a set: `runs` holds per name the entry of experiment.yaml and the columns in SI.

    A column that has no unit in `units` is written as it is (names of directions).
    """
    folder.mkdir(parents=True, exist_ok=True)
    document: dict[str, Any] = {"format": FORMAT, **head}
    document["columns"] = {name: {"unit": unit} for name, unit in units.items()}
    if noise is not None:
        stated = {name: float(in_unit(sigma, units[name])) for name, sigma in noise.items()}
        document["noise"] = {name: float(f"{sigma:.3g}") for name, sigma in stated.items()}
    document["runs"] = {}
    for name, (entry, columns) in runs.items():
        document["runs"][name] = {**entry, "file": f"{name}.csv"}
        _write_columns(folder / f"{name}.csv", columns, units)
    text = yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=120)
    (folder / "experiment.yaml").write_text(text)


def append_runs(folder: Path, longer: Path) -> None:
    """Put into a set the runs and specimens that a longer one of the same design has besides."""
    paths = [place / "experiment.yaml" for place in (folder, longer)]
    document, other = (yaml.safe_load(path.read_text()) for path in paths)
    for name, entry in other["runs"].items():
        if name not in document["runs"]:
            document["runs"][name] = entry
            shutil.copy(longer / entry["file"], folder / entry["file"])
    document["specimens"] = {**other["specimens"], **document["specimens"]}
    text = yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=120)
    paths[0].write_text(text)


def _write_columns(path: Path, columns: dict[str, Array], units: dict[str, str]) -> None:
    cells = [_cells(values, units.get(name)) for name, values in columns.items()]
    lines = [",".join(columns), *(",".join(row) for row in zip(*cells, strict=True))]
    path.write_text("\n".join(lines) + "\n")


def _cells(values: Array, unit: str | None) -> list[str]:
    if values.dtype.kind in "US":
        return [str(value) for value in values]
    return [f"{value:.8g}" for value in np.asarray(in_unit(values, unit or ""))]
