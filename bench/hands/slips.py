"""Mistakes in how the data of a hand are stated: sets with one, and how a verdict names it."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np

from model_lab.measurements.hands import MARKER_AXES
from model_lab.measurements.measurement_set import MeasurementSet
from softhand_common.numerics.arrays import Array

ATMOSPHERE, PSI, INCH = 101_325.0, 6_894.757, 0.0254  # [Pa], [Pa], [m]
KILOPASCAL, MILLIMETRE = 1e3, 1e-3  # [Pa], [m]: the units that are stated
SLIPS = {  # what: name and column in a verdict, with two names that are drawn where {} stands
    "channels_exchanged": ("exchanged", "{}, {}"),
    "markers_exchanged": ("exchanged", "{}, {}"),
    "axis_reversed": ("mirrored", "all markers"),
    "axes_exchanged": ("mirrored", "all markers"),
    "pressures_in_psi": ("unit", "all pressures"),
    "markers_in_inches": ("unit", "all markers"),
    "absolute_pressures": ("absolute", "all pressures"),
}


def with_slip(
    data: MeasurementSet, kind: str, random: np.random.Generator
) -> tuple[MeasurementSet, tuple[str, str]]:
    """A set with a slip of a kind, at a place that is drawn, and its name and column in a verdict.
    Numbers in psi are read as kPa, those in inches as mm.
    """
    drawn_from = {"channels_exchanged": data.pressures, "markers_exchanged": tuple(data.markers)}
    pairs = list(combinations(drawn_from.get(kind, MARKER_AXES), 2))
    one, other = pairs[random.integers(len(pairs))]

    def read(columns: dict[str, Array]) -> dict[str, Array]:
        places = {name: columns[name] for name in data.outputs}
        pressures = {name: columns[name] for name in data.pressures}
        if kind == "channels_exchanged":
            return {one: columns[other], other: columns[one]}
        if kind == "markers_exchanged":
            pairs = [(f"{one}.{axis}", f"{other}.{axis}") for axis in MARKER_AXES]
        if kind == "axes_exchanged":
            pairs = [(f"{marker}.{one}", f"{marker}.{other}") for marker in data.markers]
        if kind in ("markers_exchanged", "axes_exchanged"):
            return {a: columns[b] for pair in pairs for a, b in (pair, pair[::-1])}
        if kind == "axis_reversed":
            return {name: -column for name, column in places.items() if name.endswith(f".{one}")}
        if kind == "pressures_in_psi":
            return {name: KILOPASCAL / PSI * column for name, column in pressures.items()}
        if kind == "markers_in_inches":
            return {name: MILLIMETRE / INCH * column for name, column in places.items()}
        return {name: column + ATMOSPHERE for name, column in pressures.items()}

    runs = [replace(run, columns={**run.columns, **read(dict(run.columns))}) for run in data.runs]
    name, column = SLIPS[kind]
    return replace(data, runs=tuple(runs)), (name, column.format(one, other))
