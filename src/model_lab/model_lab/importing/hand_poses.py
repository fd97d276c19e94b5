"""Makes a measurement set `hand_pose` from recordings of a hand that held poses without contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from model_lab.aliases import Array
from model_lab.importing.hand_courses import (
    KPA,
    MARGIN,
    MM,
    SAME_ATTITUDE,
    SAME_PRESSURE,
    HandCourse,
    at_rest,
    markers_of,
    names_of_runs,
    set_of_runs,
    spans_of,
    turned,
)
from model_lab.importing.importing import ImportedSet
from model_lab.importing.runs import ImportedRun
from model_lab.measurements.hands import (
    HAND_POSE,
    HandSpecimen,
    marker_columns,
    pressure_columns,
)
from softhand_common.documents.quoted import listed
from softhand_common.documents.yaml_document import DocumentError
from softhand_common.numerics.rotations import to_rpy

# by hand
HOLD = 0.8  # [s] for which a pose must be held; MARGIN of it at either end is left out
LACKING_POSES = 0.35  # largest share of a protocol's poses that a repeat may lack
NO_AIR = 2e3  # [Pa] below which a hand is empty
FREE_LOAD = 0.2  # [N] at the wrist that no free hand bears, as for the monitor


@dataclass(frozen=True)
class Pose:
    """A pose that was held, as means over its time.

    time [s], pressures (channels,) [Pa], places (markers, 3) [m] of the markers in the frame of the
    wrist, wrist (4,): orientation of the wrist in the world, as a quaternion. load [N]: force on
    the wrist besides the weight of the hand, 0 if unknown.
    """

    time: float
    pressures: Array
    places: Array
    wrist: Array
    load: float


def set_of_poses(courses: Sequence[HandCourse], specimen: HandSpecimen) -> ImportedSet:
    """The set of all poses that were held for at least HOLD seconds, with wrist and hand at rest.
    In a file whose samples are farther apart than that, each sample is a pose.

    A run ends where the wrist turns or the hand is empty of air again; runs with the same poses are
    repeats of a protocol, and poses that one of them lacks are left out of all. Samples in motion
    are left out. Poses in which the wrist bears more than FREE_LOAD are told, but not left out, as
    an arm's own sense of force may have an offset.

    Raises DocumentError for courses without poses, or with different markers.
    """
    hand, markers = specimen.description, markers_of(courses)
    runs: list[ImportedRun] = []
    entries: dict[str, dict[str, object]] = {}
    touching: list[str] = []
    whole = [(course, poses) for course in courses for poses in _runs(held_poses(course))]
    protocols, numbers = _protocols([poses for _, poses in whole])
    left_out = 0
    names = names_of_runs([course.files for course, _ in whole])
    for name, (course, held), number in zip(names, whole, numbers, strict=True):
        poses = _common(held, protocols[number])
        left_out += len(held) - len(poses)
        touching += [
            f"{name} at {pose.time - poses[0].time:.3g} s ({pose.load:.2g} N)"
            for pose in poses
            if pose.load > FREE_LOAD
        ]
        columns = _columns(poses, pressure_columns(hand), markers)
        runs.append(ImportedRun(name, columns, {}, course.files))
        entries[name] = {
            "specimen": "hand",
            "protocol": f"poses_{number + 1}",
            "wrist_rpy": [round(float(angle), 6) for angle in to_rpy(poses[0].wrist)],
            "file": f"{name}.csv",
        }
    if not runs:
        files = list(dict.fromkeys(path for course in courses for path in course.files))
        raise DocumentError(
            f"{listed(map(str, files))}: expected runs of at least two poses, each held for {HOLD} "
            "s, got none; wait longer in each pose"
        )
    found = set_of_runs(HAND_POSE, courses, specimen, runs, entries)
    alone = _named_as_repeats(names, numbers)
    if alone:
        said = f"{listed(alone)}: named like repeats of others, but with other poses"
        found = replace(found, remarks=(said, *found.remarks))
    if left_out:
        lost = f"{left_out} poses are left out, as a repeat of the same protocol lacks them"
        found = replace(found, remarks=(lost, *found.remarks))
    if not touching:
        return found
    said = (
        f"the wrist bore more than the weight of the hand in {listed(touching)}: if the hand "
        "touched something there, take out these rows, as the lab predicts a hand in free air"
    )
    return replace(found, remarks=(said, *found.remarks))


# ---------------------------------------------------------------------- poses
def held_poses(course: HandCourse) -> list[Pose]:
    """The poses that were held in a course; if its samples are far apart, each one is a pose."""
    time, places = course.time, np.stack([*course.places.values()], axis=1)
    if len(time) < 2 or float(np.median(np.diff(time))) >= HOLD:
        spans = [(index, index + 1) for index in range(len(time))]
    else:
        spans = [
            (first, last)
            for first, last in spans_of(at_rest(course))
            if time[last - 1] - time[first] >= HOLD - 2.0 * MARGIN
        ]
    return [
        Pose(
            float(time[first:last].mean()),
            course.pressures[first:last].mean(axis=0),
            places[first:last].mean(axis=0),
            course.wrist[(first + last) // 2],
            0.0 if course.load is None else float(course.load[first:last].mean()),
        )
        for first, last in spans
    ]


# ---------------------------------------------------------------------- runs
def _runs(poses: Sequence[Pose]) -> list[list[Pose]]:
    """Poses with the wrist held in one way, from one empty hand to before the next."""
    runs: list[list[Pose]] = []
    for pose in poses:
        last = runs[-1] if runs else []
        turns = bool(last) and bool(turned(last[0].wrist, pose.wrist) > SAME_ATTITUDE)
        again = pose.pressures.max() < NO_AIR and any(p.pressures.max() >= NO_AIR for p in last)
        if not last or turns or again:
            runs.append([pose])
        else:
            last.append(pose)
    return [run for run in runs if len(run) > 1]


def _protocols(runs: Sequence[list[Pose]]) -> tuple[list[list[Pose]], list[int]]:
    """The poses that all repeats of each protocol have, and the protocol of each run. Runs are
    repeats if they have the same poses, of which each may lack a few (LACKING_POSES).
    """
    protocols: list[list[Pose]] = []
    numbers = []
    for poses in runs:
        for number, other in enumerate(protocols):
            common = _common(other, poses)
            if len(common) >= max((1.0 - LACKING_POSES) * max(len(poses), len(other)), 2):
                protocols[number] = common
                break
        else:
            number = len(protocols)
            protocols.append(poses)
        numbers.append(number)
    return protocols, numbers


def _named_as_repeats(names: Sequence[str], protocols: Sequence[int]) -> list[str]:
    """Names of runs that differ only by a last number from an earlier one, which they do not
    repeat; empty unless more such runs do repeat it.

    >>> _named_as_repeats(["a_1", "a_2", "b_1", "b_2", "c_1", "c_2"], [0, 0, 1, 1, 2, 3])
    ['c_2']
    """
    stems = [name.rstrip("0123456789") for name in names]
    first = {stem: protocols[stems.index(stem)] for stem in stems if stem}
    numbered = [index for index, stem in enumerate(stems) if stem in stems[:index] and stem]
    other = [names[index] for index in numbered if protocols[index] != first[stems[index]]]
    return other if len(other) < len(numbered) - len(other) else []


def _common(poses: Sequence[Pose], other: Sequence[Pose]) -> list[Pose]:
    """Those of some poses that come in the same order among others, each as early as it can."""
    found, first = [], 0
    for pose in poses:
        for index in range(first, len(other)):
            if _alike(pose, other[index]):
                found.append(pose)
                first = index + 1
                break
    return found


def _alike(pose: Pose, other: Pose) -> bool:
    angle = turned(pose.wrist, other.wrist)
    return bool(
        angle <= SAME_ATTITUDE and np.abs(pose.pressures - other.pressures).max() <= SAME_PRESSURE
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
