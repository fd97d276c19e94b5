"""Tables of tracked markers of a whole hand, as courses on one clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from model_lab.aliases import Array
from model_lab.importing.hand_columns import (
    OF_PRESSURE,
    WRIST,
    WRIST_ANGLES,
    WRIST_TURN,
)
from model_lab.importing.hand_courses import HandCourse
from model_lab.importing.meaning import Meant
from model_lab.importing.runs import Source, clock_offset, paired
from model_lab.importing.tables import Table
from model_lab.measurements.hands import (
    MARKER_AXES,
    PRESSURE_OF,
    default_markers,
    pressure_columns,
)
from model_lab.measurements.rows import check_time
from model_lab.measurements.units import column_unit
from softhand_common.documents.quoted import listed
from softhand_common.documents.yaml_document import DocumentError
from softhand_common.numerics.rotations import from_rpy, matrices
from softhand_model.hand.hand import HandDescription

MARKERS_PART = "markers"  # beside "pressure": what files of a run must have
LEAST_SEEN = 0.5  # share of the samples in which a marker must be seen, by hand
LEAST_TOLD = 0.02  # share of the samples from which on it is said that they are left out
SPEED_STEP = 0.2  # [s] in which a speed is seen, by hand: a pose is held for longer
LEAST_LENGTH = 0.9  # of a quaternion; of what is none it is anything


@dataclass(frozen=True)
class HandFile:
    """A table and what its columns mean."""

    table: Table
    meanings: tuple[Meant, ...]

    def si(self, quantity: str) -> Array | None:
        """Values (k,) of a quantity in SI units; None if the file does not have it."""
        meant = next((one for one in self.meanings if one.quantity == quantity), None)
        if meant is None:
            return None
        column = next(one for one in self.table.columns if one.name == meant.column)
        name = "tip_angle" if quantity.rpartition(".")[2] in WRIST_ANGLES else quantity
        unit = column_unit(name, meant.unit) if meant.unit else None
        values = column.values * meant.scale
        return values if unit is None else np.asarray(unit.to_si(values))

    @property
    def parts(self) -> Source:
        """The file as a `Source` that says whether it has pressures, markers or both, by which
        files of a run are paired.
        """
        has: dict[str, str] = {}
        for one in self.meanings:
            if one.quantity.rpartition(".")[2] in MARKER_AXES and not one.quantity.startswith(
                WRIST
            ):
                has[MARKERS_PART] = one.column
            elif one.quantity.startswith(PRESSURE_OF):
                has[OF_PRESSURE] = one.column
        return Source(self.table, tuple(Meant(column, part, "") for part, column in has.items()))


def courses_of(
    files: Sequence[HandFile],
    hand: HandDescription,
    shifts: Mapping[str, float],
    wrist: Mapping[str, Sequence[float]],
) -> list[HandCourse]:
    """The course of each run, from one file, or from one file with pressures and one with markers.

    shifts: time [s] to add to the clock of a file, by its name. wrist: roll, pitch and yaw [rad] in
    which the wrist was held, by the name of a file; "" for all others.

    Raises DocumentError for a file without the other one of its run, for a channel without
    pressure, and if neither columns nor `wrist` say how the wrist was held.
    """
    by_path: dict[tuple[Path, int], HandFile] = {
        (one.table.path, id(one.table)): one for one in files
    }
    sources = [one.parts for one in files]
    courses = []
    for members in paired(sources, (OF_PRESSURE, MARKERS_PART)):
        run = [by_path[one.table.path, id(one.table)] for one in members]
        courses.append(_course(run, hand, shifts, wrist))
    return courses


def _course(
    run: Sequence[HandFile],
    hand: HandDescription,
    shifts: Mapping[str, float],
    wrist: Mapping[str, Sequence[float]],
) -> HandCourse:
    seen = next(one for one in run if MARKERS_PART in one.parts.quantities)
    blown = next(one for one in run if OF_PRESSURE in one.parts.quantities)
    paths = tuple(dict.fromkeys(one.table.path for one in (seen, blown)))
    places, remarks = _places_of(seen, hand)
    attitude = _attitude_of(seen, wrist)
    pressures = _pressures_of(blown, hand)
    rows = seen.table.rows
    columns = [pressures] if blown is seen else []
    known = np.isfinite(
        np.concatenate([*places.values(), attitude, *(one.reshape(rows, -1) for one in columns)], 1)
    ).all(axis=1)
    time = _time_of(seen, shifts, one_file=blown is seen)
    known &= np.isfinite(time)
    if blown is not seen:
        driven = _time_of(blown, shifts, one_file=False)
        time, pressures, more = _on_clock_of(time, places, driven, pressures, paths)
        known &= np.isfinite(pressures).all(axis=1)
        remarks += more
    if np.mean(~known) > LEAST_TOLD:
        remarks.append(
            f"{paths[0].name}: {int((~known).sum())} of {rows} samples are left out, as "
            "a value is missing in them"
        )
    if not known.any():
        raise DocumentError(
            f"{paths[0]}: expected samples in which all markers and pressures are known, got none"
        )
    time = time[known] - time[known][0]
    check_time(paths[0], {"time": time}, lambda index: f"sample {index + 1}")
    kept = {name: place[known] for name, place in places.items()}
    at = _triple(seen, WRIST)
    at = at[known] if at is not None else None
    stated = _quaternions(seen) is None
    return HandCourse(
        paths, time, pressures[known], kept, attitude[known], tuple(remarks), at, stated=stated
    )


def _time_of(file: HandFile, shifts: Mapping[str, float], one_file: bool) -> Array:
    """Times (k,) [s] of the rows of a file; without a clock, far apart: each row is a pose."""
    time = file.si("time")
    if time is None:
        if not one_file:
            raise DocumentError(
                f"{file.table.path}: expected a column of time, to join it with the other file of "
                "the run, got none; say --map time=COLUMN:UNIT"
            )
        return np.arange(float(file.table.rows))
    return time + shifts.get(file.table.path.name, 0.0)


def _places_of(file: HandFile, hand: HandDescription) -> tuple[dict[str, Array], list[str]]:
    """Places (k, 3) [m] of markers in the frame of the wrist, and remarks."""
    found, remarks = {}, []
    for name in default_markers(hand):
        place = _triple(file, name)
        if place is None:
            continue
        if np.mean(np.isfinite(place).all(axis=1)) < LEAST_SEEN:
            remarks.append(
                f"{file.table.path.name}: {name} is left out, as it was measured in too few samples"
            )
            continue
        found[name] = place
    if not found:
        raise DocumentError(
            f"{file.table.path}: expected x, y and z of {listed(default_markers(hand))}, got none "
            "that is present in half of the samples"
        )
    at = _triple(file, WRIST)
    if at is None:
        return found, remarks
    turn = _quaternions(file)
    if turn is None:
        raise DocumentError(
            f"{file.table.path}: expected the orientation of the wrist beside its position "
            f"({', '.join(WRIST_TURN)} or {', '.join(WRIST_ANGLES)}), got none"
        )
    remarks.append("places are turned from the world into the frame of the wrist, as measured")
    frames = matrices(turn.T)
    return {
        name: np.einsum("jik,kj->ki", frames, place - at) for name, place in found.items()
    }, remarks


def _triple(file: HandFile, name: str) -> Array | None:
    parts = [file.si(f"{name}.{axis}") for axis in MARKER_AXES]
    known = [part for part in parts if part is not None]
    return np.stack(known, axis=1) if len(known) == len(parts) else None


def _attitude_of(file: HandFile, wrist: Mapping[str, Sequence[float]]) -> Array:
    """Quaternions (k, 4) of the wrist in the world."""
    turn = _quaternions(file)
    if turn is not None:
        return turn
    name = file.table.path.name
    held = wrist.get(name, wrist.get(""))
    if held is None:
        raise DocumentError(
            f"{name}: expected the orientation of the wrist (weight bends the fingers) in columns "
            f"wrist.{', wrist.'.join(WRIST_TURN)} or wrist.{', wrist.'.join(WRIST_ANGLES)}, or by "
            "--wrist ROLL,PITCH,YAW in degrees (0,0,0: fingers up), got neither"
        )
    return np.tile(from_rpy(np.asarray(held, float)), (file.table.rows, 1))


def _quaternions(file: HandFile) -> Array | None:
    """Quaternions (k, 4) of the wrist as measured, None without; NaN where it was not seen."""
    parts = [file.si(f"{WRIST}.{part}") for part in WRIST_TURN]
    known = [part for part in parts if part is not None]
    if len(known) == len(WRIST_TURN):
        turn = np.stack(known, axis=1)
        length = np.linalg.norm(turn, axis=1)
        if not np.nanmedian(np.abs(length - 1.0)) < 1.0 - LEAST_LENGTH:
            raise DocumentError(
                f"{file.table.path}: wrist: expected quaternions of length 1, got "
                f"{float(np.nanmedian(length)):.3g}"
            )
        return np.asarray(turn / np.where(length > LEAST_LENGTH, length, np.nan)[:, None])
    angles = [file.si(f"{WRIST}.{part}") for part in WRIST_ANGLES]
    known = [part for part in angles if part is not None]
    if len(known) < len(WRIST_ANGLES):
        return None
    return np.stack([from_rpy(row) for row in np.stack(known, axis=1)])


def _pressures_of(file: HandFile, hand: HandDescription) -> Array:
    """Pressures (k, channels) [Pa]."""
    found = {name: file.si(name) for name in pressure_columns(hand)}
    missing = [name for name, values in found.items() if values is None]
    if missing:
        raise DocumentError(
            f"{file.table.path}: expected the pressure of each channel of {hand.name} "
            f"({listed(hand.channels)}), got no {missing[0]}; say --map {missing[0]}=COLUMN:UNIT"
        )
    return np.stack([values for values in found.values() if values is not None], axis=1)


def _on_clock_of(
    time: Array,
    places: Mapping[str, Array],
    driven: Array,
    pressures: Array,
    paths: Sequence[Path],
) -> tuple[Array, Array, list[str]]:
    """Times (k,) [s] of the markers, and the pressures (k, channels) [Pa] at them, NaN where the
    other file has none; remarks.
    """
    remarks = []
    good = np.isfinite(driven) & np.isfinite(pressures).all(axis=1)
    driven, pressures = driven[good], pressures[good]
    if not len(driven):
        raise DocumentError(
            f"{paths[-1]}: expected samples in which all pressures are known, got none"
        )
    check_time(paths[-1], {"time": driven - driven[0]}, lambda index: f"sample {index + 1}")
    if min(np.nanmax(time), driven[-1]) <= max(np.nanmin(time), driven[0]):
        remarks.append("the clocks of the two files cannot be compared: both begin at 0")
        time, driven = time - np.nanmin(time), driven - driven[0]
    offset = _offset(time, places, driven, pressures)
    if offset:
        file = paths[0].name
        remarks.append(
            f"{file}: its clock seems {abs(offset):.2f} s {'late' if offset > 0 else 'early'} "
            f"(no times were changed; --shift {file}={-offset:.3g} corrects them)"
        )
    inside = (time >= driven[0]) & (time <= driven[-1])
    at = np.stack([np.interp(time, driven, column) for column in pressures.T], axis=1)
    return time, np.where(inside[:, None], at, np.nan), remarks


def _offset(
    time: Array, places: Mapping[str, Array], driven: Array, pressures: Array
) -> float | None:
    """Time [s] by which the clock of the markers is late, by how fast they and the pressures move;
    None where nothing clearly says so.
    """
    whole = np.concatenate([*places.values()], axis=1)
    seen = np.isfinite(whole).all(axis=1) & np.isfinite(time)
    if seen.sum() < 2:
        return None
    blowing, moving = _speed(driven, pressures), _speed(time[seen], whole[seen])
    return None if min(len(blowing[0]), len(moving[0])) < 2 else clock_offset(*blowing, *moving)


def _speed(time: Array, values: Array) -> tuple[Array, Array]:
    """Times (k,) [s] SPEED_STEP apart, and how fast values (n, m) change there."""
    at = np.arange(time[0], time[-1], SPEED_STEP)
    there = np.stack([np.interp(at, time, column) for column in values.T], axis=1)
    return at[1:] - SPEED_STEP / 2.0, np.linalg.norm(np.diff(there, axis=0), axis=1) / SPEED_STEP
