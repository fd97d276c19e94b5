"""Writing of a measurement set to a folder that `load` reads."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path

import numpy as np
import yaml

from model_lab.measurements.hands import PRESSURE_OF, WRIST_POSE
from model_lab.measurements.measurement_set import (
    DEFLATE,
    SET_FORMAT,
    MeasurementSet,
    Run,
    Specimen,
)
from model_lab.measurements.units import Display, column_unit, display_of, unit_of
from softhand_common.documents.output_file import write_files
from softhand_model.model_file import FREE_VALUE

NO_UNITS: Mapping[str, str] = {}


def check_folder(folder: Path, force: bool = False) -> None:
    """Raise ValueError if a path is a file, or, unless `force`, a folder that is not empty.

    Called before long work, so that its result is not lost.
    """
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"{folder}: expected the name of a folder, got a file")
    if folder.exists() and any(folder.iterdir()) and not force:
        raise ValueError(
            f"{folder}: expected an empty or new folder, got one with files; --force overwrites"
        )


def write_set(data: MeasurementSet, folder: Path, force: bool = False) -> None:
    """Write experiment.yaml and one CSV file per run, in units of daily use (kPa, deg, mm).

    Raises ValueError as `check_folder` does, or if the set cannot be written.
    """
    check_folder(folder, force)
    write_files(set_files(data, folder))


def set_files(data: MeasurementSet, folder: Path) -> dict[Path, str]:
    """The texts that `write_set` writes, by path."""
    document = {
        "format": SET_FORMAT,
        "experiment": data.experiment,
        "title": data.title,
        "specimens": {name: specimen_entry(entry) for name, entry in data.specimens.items()},
        **(
            {"markers": {name: m.entry() for name, m in data.markers.items()}}
            if data.markers
            else {}
        ),
        **({} if data.plate is None else {"plate": data.plate.entry()}),
        **({} if data.grasped is None else asdict(data.grasped)),
        "columns": column_entries(data.runs[0].columns),
        "noise": {name: float(level * shown_as(name).factor) for name, level in data.noise.items()},
        "runs": {run.name: run_entry(run) for run in data.runs},
    }
    if data.free_modulus and data.experiment != "rubber":
        document["calibration"] = {"modulus": FREE_VALUE}
    text = yaml.safe_dump(document, sort_keys=False, allow_unicode=True, width=120)
    tables = {folder / f"{run.name}.csv": csv_text(run) for run in data.runs}
    return {folder / "experiment.yaml": text} | tables


def shown_as(name: str) -> Display:
    """The unit and factor with which a column is written: a unit of daily use, or no change if its
    unit is unknown.
    """
    return display_of(unit_of(name) or "")


def column_entries(
    names: Iterable[str], units: Mapping[str, str] = NO_UNITS
) -> dict[str, dict[str, str]]:
    """Entries under `columns` of experiment.yaml, for CSV files with columns of these names; units:
    of columns that have others than usual.
    """
    return {name: {"unit": units.get(name, shown_as(name).unit)} for name in names}


def specimen_entry(specimen: Specimen) -> dict:
    """The entry of a specimen in experiment.yaml, as a dictionary."""
    if specimen.hand is not None:
        return {**specimen.hand.entry(), "batch": specimen.batch}
    values = {
        key: value.tolist() if isinstance(value, np.ndarray) else value
        for key, value in specimen.values.items()
    }
    return {**values, "mount": specimen.mount, "batch": specimen.batch}


def run_entry(run: Run) -> dict:
    """The entry of a run in experiment.yaml, as a dictionary."""
    of_hand = any(name.startswith(PRESSURE_OF) for name in run.columns)
    held = of_hand and WRIST_POSE[-1] not in run.columns
    entry = {
        "specimen": run.specimen,
        "temperature": float(run.temperature),
        "protocol": run.protocol,
        "file": f"{run.name}.csv",
    }
    return (
        entry
        | ({"virgin": True} if run.virgin else {})
        | ({"initial": "steady"} if run.steady else {})
        | ({"mode": run.mode} if run.mode else {})
        | ({"wrist_rpy": [float(a) for a in run.wrist_rpy]} if held else {})
        | ({"stretched_to": float(run.stretched_to)} if run.stretched_to > 1.0 else {})
    )


def csv_text(run: Run, units: Mapping[str, str] = NO_UNITS) -> str:
    """The columns of a run as CSV, in the units of `column_entries`. Its lead comes first, with
    empty cells for outputs.
    """
    names, led = list(run.columns), len(next(iter(run.lead.values()), ()))
    empty = [""] * led
    columns = [
        (_texts(name, run.lead[name], units) if name in run.lead else empty)
        + _texts(name, run.columns[name], units)
        for name in names
    ]
    lines = [",".join(names), *(",".join(row) for row in zip(*columns, strict=True))]
    return "\n".join(lines) + "\n"


def _texts(name: str, values: np.ndarray, units: Mapping[str, str]) -> list[str]:
    if name == "direction":
        return ["deflate" if value == DEFLATE else "inflate" for value in values]
    if name in units:
        unit = column_unit(name, units[name])
        return [f"{(value - unit.offset) / unit.scale:.8g}" for value in values]
    shown = shown_as(name)
    return [f"{shown.factor * value + shown.offset:.8g}" for value in values]
