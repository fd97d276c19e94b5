"""Specimens of a measurement set: reading their entries, and what a model requires of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from model_lab.aliases import Array
from model_lab.measurements.hands import read_hand
from model_lab.measurements.measurement_set import UNSTATED_BATCH, MeasurementSet, Specimen
from model_lab.measurements.units import largest
from softhand_common.documents.quoted import listed
from softhand_common.documents.yaml_document import DocumentError, Node, open_fields
from softhand_model.hand.actuator import PROFILES, read_profile
from softhand_model.model_file import Model

DOCUMENT = "experiment.yaml"
KNOWN = {
    "length": ("m", "0.09"),
    "height": ("m", "0.02"),
    "width": ("m", "0.02"),
    "wall": ("m", "0.0025"),
    "side_wall": ("m", "0.0025"),
    "shear_modulus": ("Pa", "67000.0"),
    "mass": ("kg", "0.035"),
    "gauge_length": ("m", "0.033"),
}  # keys that models know: unit, and an example
TAPER_POINTS = 65  # of a taper; straight lines between them miss that of P10 by 0.1 %
LONGEST_SPECIMEN = 10.0  # [m] that a specimen is believed to be
MAY_VANISH = ("side_wall", "mass")
MOUNTS = (
    *("bending_plane_level", "base_up", "base_down"),
    *("level_curling_up", "level_curling_down"),
)


def read_specimens(node: Node, of_hands: bool = False) -> dict[str, Specimen]:
    """Read the specimens (actuators, or hands if `of_hands`), by name; raises DocumentError for an
    entry that is not valid.
    """
    read = _hand if of_hands else _specimen
    specimens = {name: read(name, entry) for name, entry in node.mapping().items()}
    if not specimens:
        raise node.error("at least one specimen")
    return specimens


def require_keys(data: MeasurementSet, specimen: Specimen, keys: Iterable[str], why: str) -> None:
    """Raise DocumentError unless a specimen has numbers for all the keys. why: what needs them, for
    the message.
    """
    for key in keys:
        if key not in specimen.values:
            unit = f" [{KNOWN[key][0]}]" if key in KNOWN else ""
            raise DocumentError(
                f"{data.folder / DOCUMENT}: specimens.{specimen.name}: expected the key {key}{unit}"
                f", which {why} needs, got {listed(specimen.values)}; {_mend(key)}"
            )


def _mend(key: str) -> str:
    add = f"add it, such as {key}: {KNOWN[key][1]}" if key in KNOWN else "add it"
    other = "for an actuator of another kind use --model linear"
    return add if key == "mass" else f"{add}, or {other}"


def require_columns(data: MeasurementSet, columns: Iterable[str], why: str) -> None:
    """Raise DocumentError unless every run has all the columns. why: what needs them, for the
    message.
    """
    for run in data.runs:
        for column in columns:
            if column not in run.columns:
                raise DocumentError(
                    f"{data.folder / DOCUMENT}: runs.{run.name}: expected the column {column}, "
                    f"which {why} needs, got {listed(run.columns)}; record it, and name it "
                    "under `columns` (CSV) or `topics` (bag)"
                )


def made_of(data: MeasurementSet, model: Model) -> MeasurementSet:
    """The set with the shear moduli that the model states for the batches, if it states any, and
    with `free_modulus` if set or model says so.
    """
    free = data.free_modulus or model.free_modulus
    if "modulus" not in model.calibration:
        return replace(data, free_modulus=True) if free and not data.free_modulus else data
    specimens = {name: _made_of(entry, model) for name, entry in data.specimens.items()}
    return replace(data, specimens=specimens, free_modulus=free)


def _made_of(specimen: Specimen, model: Model) -> Specimen:
    stated = specimen.values.get("shear_modulus")
    if stated is None:
        return specimen
    modulus = model.shear_modulus(float(stated), specimen.batch)
    return replace(specimen, values={**specimen.values, "shear_modulus": modulus})


def document_of(folder: Path) -> Path:
    """Path of experiment.yaml, given the folder of a measurement set or that file itself."""
    return (
        folder / DOCUMENT if folder.is_dir() or folder.suffix not in (".yaml", ".yml") else folder
    )


def known_fields(
    node: Node, required: Iterable[str] = (), optional: Iterable[str] = ()
) -> dict[str, Node]:
    """Values, by key, of a mapping that must have all `required` keys and may have `optional` ones.

    Raises DocumentError for a missing or another key; if that looks like a typo, the message names
    the key that is meant.
    """
    open_fields(node, required, optional)
    return node.fields(required, optional)


def _hand(name: str, node: Node) -> Specimen:
    fields = known_fields(node, ["hand"], ["segments", "frame", "batch", "description"])
    batch = fields["batch"].text() if "batch" in fields else UNSTATED_BATCH
    more = fields.get("segments"), fields.get("frame")
    hand = read_hand(fields["hand"], Path(node.file).parent, *more)
    return Specimen(name, batch=batch, hand=hand)


def _specimen(name: str, node: Node) -> Specimen:
    entries = open_fields(node, optional=[*KNOWN, "mount", "batch"])
    values: dict[str, float | Array] = {}
    notes: dict[str, object] = {}
    for key, entry in entries.items():
        if key in KNOWN:
            values[key] = _known(key, entry, entries.get("length"))
        elif _is_number(entry.value):
            values[key] = entry.number()
        elif key not in ("mount", "batch"):
            notes[key] = entry.value
    mount = entries["mount"].choice(MOUNTS) if "mount" in entries else MOUNTS[0]
    batch = entries["batch"].text() if "batch" in entries else UNSTATED_BATCH
    return Specimen(name, values, mount, batch, notes)


def _known(key: str, node: Node, length: Node | None) -> float | Array:
    if key in PROFILES and isinstance(node.value, dict) and length is not None:
        return _taper(key, node, length.positive())
    if key in PROFILES and isinstance(node.value, list):
        return _table(node, zero=key in MAY_VANISH)
    if isinstance(node.value, str):
        raise node.error(f"a number in {KNOWN[key][0] or 'no unit'}, without its unit")
    if KNOWN[key][0] == "m" and _is_number(node.value) and node.value > LONGEST_SPECIMEN:
        raise node.error(
            f"a length in m, {LONGEST_SPECIMEN:g} at most", f"{node.value:g}; 100 mm are 0.1"
        )
    most = largest(KNOWN[key][0])
    return node.number(0.0, most) if key in MAY_VANISH else node.number(above=0.0, high=most)


def bent_length(node: Node, specimen: Specimen, meanings: Iterable[str]) -> float:
    """Length [m] that converts curvature to angle; NaN if none is stated.

    meanings: what the columns of a run hold, as words of `MEANINGS`. Raises DocumentError if the
    length is needed but not stated.
    """
    if "curvature" in meanings and "length" not in specimen.values:
        raise node.error(f"a length of {specimen.name}, which converts curvature to angle", "none")
    return float(specimen.values.get("length", np.nan))


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _taper(key: str, node: Node, length: float) -> Array:
    """A taper as of a hand's actuators, as a profile (n, 2) of [x, value] [m]."""
    x = np.linspace(0.0, length, TAPER_POINTS)
    return np.stack([x, read_profile(node, length, PROFILES[key])(x)], axis=1)


def _table(node: Node, zero: bool) -> Array:
    """A profile (n, 2) of [x, value] with rising x; zero: whether values may be 0."""
    points = [entry.vector(2) for entry in node.items()]
    if not points:
        raise node.error("a number or a list of [x, value]")
    profile = np.array(points)
    if np.any(np.diff(profile[:, 0]) <= 0.0):
        raise node.error("a list of [x, value] with rising x")
    if np.any(profile[:, 1] < 0.0 if zero else profile[:, 1] <= 0.0):
        raise node.error(
            f"a list of [x, value] with values {'of 0 or more' if zero else 'above 0'}"
        )
    return profile
