"""Poses that a hand held in free air, as a set `hand_pose`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from model_lab.aliases import Array, IntArray
from model_lab.importing.importing import ImportedSet
from model_lab.importing.runs import ImportedRun
from model_lab.measurements.hands import (
    HAND_POSE,
    HandSpecimen,
    default_markers,
    marker_columns,
    pressure_columns,
)
from model_lab.measurements.measurement_set import SET_FORMAT
from softhand_common.documents.quoted import listed
from softhand_common.documents.yaml_document import DocumentError
from softhand_common.numerics.rotations import to_rpy

# by hand: above the noise of pressures, below what tells two poses apart
HOLD = 0.8  # [s] for which a pose must be held
MARGIN = 0.25  # [s] of it at either end that are left out
TIP_SHIFT, PRESSURE_SHIFT = 1e-3, 1e3  # [m], [Pa] by which it may change within the margin
SAME_ATTITUDE = np.deg2rad(2.0)  # of the wrist, within a run and between repeats
NO_AIR, SAME_PRESSURE = 2e3, 4e3  # [Pa] below which a hand is empty; between repeats
KPA, MM = 1e-3, 1e3  # units of the set over those of ROS


@dataclass(frozen=True)
class HandCourse:
    """What files tell of a hand over time.

    time (k,) [s]. pressures (k, channels) [Pa]: gauge pressures. places (k, 3) [m]: positions of
    each marker, by name, in the frame of the wrist. wrist (k, 4): orientation of the wrist in the
    world, as quaternions x, y, z, w.
    """

    files: tuple[Path, ...]
    time: Array
    pressures: Array
    places: Mapping[str, Array]
    wrist: Array
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True)
class Pose:
    """A pose that was held, as means over its time.

    time [s], pressures (channels,) [Pa], places (markers, 3) [m] of the markers in the frame of the
    wrist, wrist (4,): orientation of the wrist in the world, as a quaternion.
    """

    time: float
    pressures: Array
    places: Array
    wrist: Array


def set_of_poses(courses: Sequence[HandCourse], specimen: HandSpecimen) -> ImportedSet:
    """The set of all poses that were held for at least HOLD seconds, with wrist and hand at rest.
    In a file whose samples are farther apart than that, each sample is a pose.

    A run ends where the wrist turns or the hand is empty of air again; runs with the same poses are
    repeats of a protocol. Samples in motion are left out. Whether the hand touches something is not
    tested.

    Raises DocumentError for courses without poses, or with different markers.
    """
    hand, markers = specimen.description, _markers_of(courses)
    runs: list[ImportedRun] = []
    entries: dict[str, object] = {}
    protocols: list[list[Pose]] = []
    for course in courses:
        for poses in _runs(held_poses(course)):
            number = _protocol(poses, protocols)
            name = f"r{len(runs) + 1}"
            columns = _columns(poses, pressure_columns(hand), markers)
            runs.append(ImportedRun(name, columns, {}, course.files))
            entries[name] = {
                "specimen": "hand",
                "protocol": f"poses_{number + 1}",
                "wrist_rpy": [round(float(angle), 6) for angle in to_rpy(poses[0].wrist)],
                "file": f"{name}.csv",
            }
    files = list(dict.fromkeys(path for course in courses for path in course.files))
    if not runs:
        raise DocumentError(
            f"{listed(map(str, files))}: expected runs of at least two poses, each held for {HOLD} "
            "s, got none; wait longer in each pose"
        )
    units = {"time": {"unit": "s"}}
    units |= {name: {"unit": "kPa"} for name in pressure_columns(hand)}
    units |= {name: {"unit": "mm"} for name in marker_columns(markers)}
    document = {
        "format": SET_FORMAT,
        "experiment": HAND_POSE,
        "title": f"imported from {files[0].name}"[:80],
        "specimens": {"hand": specimen.entry()},
        "columns": units,
        "runs": entries,
    }
    usual = default_markers(hand)
    if list(markers) != list(usual):
        document["markers"] = {name: usual[name].entry() for name in markers}
    remarks = [remark for course in courses for remark in course.remarks]
    remarks += _remarks(len(runs), len(protocols), specimen.segments)
    return ImportedSet(document, tuple(runs), tuple(dict.fromkeys(remarks)))


def _markers_of(courses: Sequence[HandCourse]) -> list[str]:
    """Names of the markers that all courses have; raises DocumentError where they differ."""
    first = list(courses[0].places)
    for course in courses:
        if list(course.places) != first:
            raise DocumentError(
                f"{course.files[0]}: expected the markers {listed(first)} as in "
                f"{courses[0].files[0]}, got {listed(course.places)}"
            )
    return first


def _remarks(runs: int, protocols: int, segments: int | None) -> list[str]:
    remarks = ["the hand must have touched nothing but air: contacts are not looked for"]
    if segments:
        remarks.append(
            f"a simulated hand of {segments} rigid segments an actuator; it is predicted with as "
            "many (`segments` in experiment.yaml; a real hand has none)"
        )
    if protocols < 2:
        remarks.append("all runs have the same poses: hold others, so that some can be held out")
    if runs == protocols:
        remarks.append("no poses were repeated: repeats show how far the hand scatters by itself")
    return remarks


# ---------------------------------------------------------------------- poses
def held_poses(course: HandCourse) -> list[Pose]:
    """The poses that were held in a course; if its samples are far apart, each one is a pose."""
    time, places = course.time, np.stack([*course.places.values()], axis=1)
    if len(time) < 2 or float(np.median(np.diff(time))) >= HOLD:
        spans = [(index, index + 1) for index in range(len(time))]
    else:
        flat = places.reshape(len(places), -1)
        at_rest = _at_rest(time, flat, course.pressures, course.wrist)
        edges = np.flatnonzero(np.diff(np.concatenate([[0], at_rest.astype(int), [0]])))
        spans = [
            (first, last)
            for first, last in zip(edges[::2], edges[1::2], strict=True)
            if time[last - 1] - time[first] >= HOLD - 2.0 * MARGIN
        ]
    return [
        Pose(
            float(time[first:last].mean()),
            course.pressures[first:last].mean(axis=0),
            places[first:last].mean(axis=0),
            course.wrist[(first + last) // 2],
        )
        for first, last in spans
    ]


def _at_rest(time: Array, places: Array, pressures: Array, turns: Array) -> Array:
    """Whether (k,) means over MARGIN before and behind each sample are the same but for noise."""
    first = np.searchsorted(time, time - MARGIN)
    last = np.searchsorted(time, time + MARGIN, side="right")
    now = np.arange(len(time))
    shifts = [
        np.abs(_mean(values, now, last) - _mean(values, first, now + 1)).max(axis=1) / largest
        for values, largest in ((places, TIP_SHIFT), (pressures, PRESSURE_SHIFT))
    ]
    shifts.append(_turned(turns[first], turns[last - 1]) / SAME_ATTITUDE)
    return np.asarray(np.max(shifts, axis=0) < 1.0)


def _mean(values: Array, first: IntArray, last: IntArray) -> Array:
    """Means (k, n) of the rows of values (k, n) from each first to before each last."""
    sums = np.vstack([np.zeros(values.shape[1]), np.cumsum(values, axis=0)])
    return np.asarray((sums[last] - sums[first]) / (last - first)[:, None])


def _turned(one: Array, other: Array) -> Array:
    """Angle [rad] between the attitudes of quaternions (..., 4)."""
    return np.asarray(2.0 * np.arccos(np.clip(np.abs(np.sum(one * other, axis=-1)), 0.0, 1.0)))


# ---------------------------------------------------------------------- runs
def _runs(poses: Sequence[Pose]) -> list[list[Pose]]:
    """Poses with the wrist held in one way, from one empty hand to before the next."""
    runs: list[list[Pose]] = []
    for pose in poses:
        last = runs[-1] if runs else []
        turned = bool(last) and _turned(last[0].wrist, pose.wrist) > SAME_ATTITUDE
        again = pose.pressures.max() < NO_AIR and any(p.pressures.max() >= NO_AIR for p in last)
        if not last or turned or again:
            runs.append([pose])
        else:
            last.append(pose)
    return [run for run in runs if len(run) > 1]


def _protocol(poses: list[Pose], protocols: list[list[Pose]]) -> int:
    """Index of the protocol with these poses, which is added if there is none."""
    for number, other in enumerate(protocols):
        if len(other) == len(poses) and all(map(_alike, poses, other)):
            return number
    protocols.append(poses)
    return len(protocols) - 1


def _alike(pose: Pose, other: Pose) -> bool:
    turned = _turned(pose.wrist, other.wrist)
    return bool(
        turned <= SAME_ATTITUDE and np.abs(pose.pressures - other.pressures).max() <= SAME_PRESSURE
    )


def _columns(
    poses: Sequence[Pose], channels: Sequence[str], markers: Sequence[str]
) -> dict[str, Array]:
    time = np.array([pose.time for pose in poses])
    pressures = KPA * np.array([pose.pressures for pose in poses]).T
    places = MM * np.array([pose.places.ravel() for pose in poses]).T
    return (
        {"time": time - time[0]}
        | dict(zip(channels, pressures, strict=True))
        | dict(zip(marker_columns(markers), places, strict=True))
    )
