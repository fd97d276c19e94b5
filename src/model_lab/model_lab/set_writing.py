"""Writing a measurement set to a folder in the layout that `loading` reads."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import yaml

from model_lab.measurement import DEFLATE, MeasurementSet, Run, Specimen

FORMAT = "softhand-measurement/1"
SHOWN = {"rad": ("deg", 180.0 / np.pi), "Pa": ("kPa", 1e-3), "kg": ("mg", 1e6)}
UNITS = {
    "time": "s",
    "pressure": "Pa",
    "tip_angle": "rad",
    "tip_force": "N",
    "stretch": "",
    "stress": "Pa",
    "duration": "s",
    "p_in": "Pa",
    "p_out": "Pa",
    "friction_integral": "Pa s",
    "injector_integral": "Pa s",
    "mass": "kg",
    "torque_x": "N m",
    "torque_y": "N m",
    "torque_z": "N m",
}


def write_set(data: MeasurementSet, folder: Path, force: bool = False) -> None:
    """Write experiment.yaml and a CSV a run, in the units that people read at the bench.

    Raises ValueError when the folder holds something already, unless `force`.
    """
    if folder.exists() and any(folder.iterdir()) and not force:
        raise ValueError(
            f"{folder}: expected an empty or new folder, got one with files; --force overwrites"
        )
    folder.mkdir(parents=True, exist_ok=True)
    names = list(data.runs[0].columns)
    document = {
        "format": FORMAT,
        "experiment": data.experiment,
        "title": data.title,
        "specimens": {name: _specimen(entry) for name, entry in data.specimens.items()},
        "columns": {name: {"unit": _shown(name)[0]} for name in names if name != "direction"}
        | ({"direction": {"unit": ""}} if "direction" in names else {}),
        "noise": {name: float(level * _shown(name)[1]) for name, level in data.noise.items()},
        "runs": {run.name: _run(run) for run in data.runs},
    }
    text = yaml.safe_dump(document, sort_keys=False, allow_unicode=True, width=120)
    (folder / "experiment.yaml").write_text(text, encoding="utf-8")
    for run in data.runs:
        _write_csv(run, folder / f"{run.name}.csv")


def _shown(name: str) -> tuple[str, float]:
    """Unit in the CSV of a column and the factor from SI."""
    unit = UNITS.get(name, "")
    return SHOWN.get(unit, (unit, 1.0))


def _specimen(specimen: Specimen) -> dict:
    values = {
        key: value.tolist() if isinstance(value, np.ndarray) else value
        for key, value in specimen.values.items()
    }
    return {**values, "mount": specimen.mount, "batch": specimen.batch}


def _run(run: Run) -> dict:
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
    )


def _write_csv(run: Run, path: Path) -> None:
    names = list(run.columns)
    columns = [_texts(name, run.columns[name]) for name in names]
    lines = [",".join(names), *(",".join(row) for row in zip(*columns, strict=True))]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _texts(name: str, values: np.ndarray) -> list[str]:
    if name == "direction":
        return ["deflate" if value == DEFLATE else "inflate" for value in values]
    factor = _shown(name)[1]
    return [f"{value * factor:.8g}" for value in values]
