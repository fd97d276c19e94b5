"""The recorded course of a whole hand over time, and what sets of poses and of motions have in
common.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from model_lab.aliases import Array, IntArray
from model_lab.importing.importing import ImportedSet
from model_lab.importing.runs import ImportedRun, run_name
from model_lab.measurements.at_rest import white_noise
from model_lab.measurements.hands import (
    HandSpecimen,
    default_markers,
    marker_columns,
    pressure_columns,
)
from model_lab.measurements.measurement_set import SET_FORMAT
from softhand_common.documents.quoted import listed
from softhand_common.documents.yaml_document import DocumentError

FILES_OF_RUN = 2  # positions and pressures
# by hand: above the noise of pressures, below what tells two poses apart
MARGIN = 0.25  # [s] over which means must stay the same at rest
TIP_SHIFT, PRESSURE_SHIFT = 1e-3, 1e3  # [m], [Pa] by which they may change
NOISE_SHIFT = 4.0  # standard errors of that change by which it may be larger
LEAST_NOISE_SAMPLES = 5  # in MARGIN, without which changes from sample to sample are no noise
SAME_ATTITUDE = np.deg2rad(2.0)  # of the wrist, within a run and between repeats
SAME_PRESSURE = 4e3  # [Pa] between repeats
KPA, MM = 1e-3, 1e3  # units of the set over those of ROS


@dataclass(frozen=True)
class HandCourse:
    """The course of a hand over time, as files of one run have it.

    time (k,) [s]. pressures (k, channels) [Pa]: gauge pressures. places (k, 3) [m]: positions of
    each marker, by name, in the frame of the wrist. wrist (k, 4): orientation of the wrist in the
    world, as quaternions x, y, z, w. wrist_places (k, 3) [m]: its position there, None if unknown.
    load (k,) [N]: force on the wrist besides the weight of the hand, None if unknown. stated:
    whether the orientation is the user's word and not measured.
    """

    files: tuple[Path, ...]
    time: Array
    pressures: Array
    places: Mapping[str, Array]
    wrist: Array
    remarks: tuple[str, ...] = ()
    wrist_places: Array | None = None
    load: Array | None = None
    stated: bool = False

    @property
    def flat_places(self) -> Array:
        """Coordinates (k, 3 markers) [m] of all markers."""
        return np.concatenate([*self.places.values()], axis=1)


def names_of_runs(files: Sequence[tuple[Path, ...]]) -> list[str]:
    """Names of runs, from the files of each: those of the files where every run has its own, else
    r1, r2 and so on.

    >>> names_of_runs([(Path("fist_1.csv"),), (Path("fist_2.csv"),)])
    ['fist_1', 'fist_2']
    """
    names = [run_name(paths) if len(paths) <= FILES_OF_RUN else "" for paths in files]
    if len(names) > 1 and all(names) and len(set(names)) == len(names):
        return names
    return [f"r{number}" for number in range(1, len(files) + 1)]


def set_of_runs(
    experiment: str,
    courses: Sequence[HandCourse],
    specimen: HandSpecimen,
    runs: Sequence[ImportedRun],
    entries: Mapping[str, Mapping[str, object]],
    units: Mapping[str, str] | None = None,
) -> ImportedSet:
    """The set of the runs cut out of courses of one hand.

    entries: of experiment.yaml for each run, by its name. units: of columns beside time, pressures
    [kPa] and places of markers [mm].
    """
    hand, markers = specimen.description, markers_of(courses)
    files = list(dict.fromkeys(path for course in courses for path in course.files))
    columns = {"time": "s"} | dict.fromkeys(pressure_columns(hand), "kPa") | dict(units or {})
    columns |= dict.fromkeys(marker_columns(markers), "mm")
    document: dict[str, object] = {
        "format": SET_FORMAT,
        "experiment": experiment,
        "title": f"imported from {files[0].name}"[:80],
        "specimens": {"hand": specimen.entry()},
        "columns": {name: {"unit": unit} for name, unit in columns.items()},
        "runs": dict(entries),
    }
    usual = default_markers(hand)
    if list(markers) != list(usual):
        document["markers"] = {name: usual[name].entry() for name in markers}
    remarks = [remark for course in courses for remark in course.remarks]
    protocols = len({str(entry["protocol"]) for entry in entries.values()})
    remarks.append("the hand must have touched nothing: remove rows in which it touched something")
    remarks += remarks_on(len(runs), protocols, specimen.segments)
    return ImportedSet(document, tuple(runs), tuple(dict.fromkeys(remarks)))


def markers_of(courses: Sequence[HandCourse]) -> list[str]:
    """Names of the markers of all courses; raises DocumentError if they differ."""
    first = list(courses[0].places)
    for course in courses:
        if list(course.places) != first:
            raise DocumentError(
                f"{course.files[0]}: expected the markers {listed(first)} as in "
                f"{courses[0].files[0]}, got {listed(course.places)}"
            )
    return first


def remarks_on(runs: int, protocols: int, segments: int | None) -> list[str]:
    """What a user should know of these numbers of runs and protocols, and of rigid segments of an
    actuator (None: a real hand).
    """
    remarks = []
    if segments:
        remarks.append(
            f"a simulated hand of {segments} rigid segments an actuator; it is predicted with as "
            "many (`segments` in experiment.yaml; a real hand has none)"
        )
    if protocols < 2:
        remarks.append(
            "all runs have the same protocol: record other protocols too, so that some can be "
            "held out"
        )
    if runs == protocols:
        remarks.append(
            "no protocol was repeated: repeats show how much the hand itself scatters; without "
            "them, `diagnose` needs `noise` of the markers in experiment.yaml for few poses"
        )
    return remarks


def at_rest(course: HandCourse) -> Array:
    """Whether (k,) means over MARGIN before and behind each sample are the same but for noise, of
    places, pressures and the attitude of the wrist.
    """
    time, turns = course.time, course.wrist
    first = np.searchsorted(time, time - MARGIN)
    last = np.searchsorted(time, time + MARGIN, side="right")
    now = np.arange(len(time))
    share = NOISE_SHIFT * np.sqrt(1.0 / (last - now) + 1.0 / (now + 1 - first))[:, None]
    often = len(time) > LEAST_NOISE_SAMPLES * (time[-1] - time[0]) / MARGIN
    shifts = []
    for values, largest in ((course.flat_places, TIP_SHIFT), (course.pressures, PRESSURE_SHIFT)):
        change = np.abs(_mean(values, now, last) - _mean(values, first, now + 1))
        noise = [white_noise(column) if often else 0.0 for column in values.T]
        shifts.append((change / np.hypot(largest, share * np.array(noise))).max(axis=1))
    shifts.append(turned(turns[first], turns[last - 1]) / SAME_ATTITUDE)
    return np.asarray(np.max(shifts, axis=0) < 1.0)


def _mean(values: Array, first: IntArray, last: IntArray) -> Array:
    """Means (k, n) of the rows of values (k, n) from each first to before each last."""
    sums = np.vstack([np.zeros(values.shape[1]), np.cumsum(values, axis=0)])
    return np.asarray((sums[last] - sums[first]) / (last - first)[:, None])


def turned(one: Array, other: Array) -> Array:
    """Angle [rad] between the attitudes of quaternions (..., 4)."""
    return np.asarray(2.0 * np.arccos(np.clip(np.abs(np.sum(one * other, axis=-1)), 0.0, 1.0)))


def without_jumps(quaternions: Array) -> Array:
    """Quaternions (k, 4) of the same turns, whose sign does not jump from one to the next."""
    flips = np.sum(quaternions[1:] * quaternions[:-1], axis=1) < 0.0
    signs = np.where(np.cumsum(np.concatenate([[False], flips])) % 2, -1.0, 1.0)
    return np.asarray(signs[:, None] * quaternions)


def spans_of(marked: Array) -> list[tuple[int, int]]:
    """First index, and the one behind the last, of each stretch that is marked (k,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], marked.astype(int), [0]])))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
