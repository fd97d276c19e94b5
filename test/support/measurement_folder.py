"""Folders of measurements as a user would write them."""

import copy

import numpy as np
import yaml

SPECIMEN = {
    "length": 0.09,
    "height": 0.02,
    "width": 0.02,
    "wall": 0.002,
    "side_wall": 0.002,
    "shear_modulus": 67000.0,
}
ROWS = "time,pressure,tip_angle\n0.0,0,0\n0.1,10,18\n0.2,20,36\n"
DOCUMENT = {
    "format": "softhand-measurement/1",
    "experiment": "free_bending",
    "title": "one finger",
    "specimens": {"f": SPECIMEN},
    "columns": {
        "time": {"unit": "s"},
        "pressure": {"unit": "kPa"},
        "tip_angle": {"unit": "deg"},
    },
    "runs": {"r1": {"specimen": "f", "temperature": 293.15, "file": "r1.csv"}},
}


def document(**changes):
    """The document of one run, with other values for some of its keys."""
    return copy.deepcopy(DOCUMENT) | changes


def write_set(folder, content=None, files=None):
    """Write a measurement set; files by name, r1.csv if none are given. Returns the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    text = yaml.safe_dump(content or DOCUMENT, sort_keys=False)
    (folder / "experiment.yaml").write_text(text, encoding="utf-8")
    for name, rows in (files or {"r1.csv": ROWS}).items():
        (folder / name).write_text(rows, encoding="utf-8")
    return folder


def csv_text(columns):
    """A CSV file of columns by name."""
    table = np.column_stack(list(columns.values()))
    lines = [",".join(f"{value:.12g}" for value in row) for row in table.tolist()]
    return "\n".join([",".join(columns), *lines]) + "\n"
