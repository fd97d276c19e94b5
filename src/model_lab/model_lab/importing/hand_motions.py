"""Motions of a hand in free air, each from rest, as a set `hand_motion`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from model_lab.aliases import Array
from model_lab.importing.hand_courses import (
    KPA,
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
    without_jumps,
)
from model_lab.importing.importing import ImportedSet
from model_lab.importing.runs import ImportedRun
from model_lab.measurements.hands import (
    HAND_MOTION,
    WRIST_POSE,
    HandSpecimen,
    marker_columns,
    pressure_columns,
)
from model_lab.rules import RULES
from softhand_common.documents.quoted import listed
from softhand_common.documents.yaml_document import DocumentError
from softhand_common.numerics.rotations import to_rpy

# by hand
LONGEST = 3.0  # [s] of a run; what follows until the hand rests again is left out
LEAST_REST = 0.1  # [s] for which means must stay the same
AFTER = 0.3  # [s] that a run goes on at rest
RATE = 100.0  # [Hz] that a recording must have; a faster one is thinned to it
WRIST_AT_REST = 2e-3  # [m] by which a wrist that is held may move, and one path differ from another
COMPARED = 50  # instants at which two runs are compared
IN_TIME = 0.4  # share by which the lengths of repeats may differ: they end where all rests


def set_of_motions(courses: Sequence[HandCourse], specimen: HandSpecimen) -> ImportedSet:
    """The set of all motions: each run begins with the hand and the wrist at rest and ends when
    both rest again, after `LONGEST` [s] at the latest.

    Runs with the same course of pressures and the same path of the wrist are repeats of a protocol.
    A wrist that is held gives `wrist_rpy`, one that moves the columns `wrist.*`. That the hand
    touches nothing is not tested.

    Motions in which samples are missing are left out, and the set says so.

    Raises DocumentError for courses without such a motion, with samples farther apart than
    `Rules.motion_gap`, with different markers, or with a wrist that moves while no file tells its
    position.
    """
    markers = markers_of(courses)
    seen = [(course, span) for course in courses for span in _motions(course)]
    parts = [part for part in seen if _is_whole(part)]
    if not parts:
        files = list(dict.fromkeys(path for course in courses for path in course.files))
        raise DocumentError(
            f"{listed(map(str, files))}: expected motions that begin with hand and wrist at rest, "
            "got none; before each motion, keep both still for half a second"
            + (f" ({len(seen)} motions lack samples)" if seen else "")
        )
    moved = not all(map(_is_held, parts))
    channels = pressure_columns(specimen.description)
    runs: list[ImportedRun] = []
    entries: dict[str, dict[str, object]] = {}
    protocols: list[tuple[HandCourse, slice]] = []
    names = names_of_runs([course.files for course, _ in parts])
    for name, (course, span) in zip(names, parts, strict=True):
        number = _protocol((course, span), protocols)
        columns = {"time": course.time[span] - course.time[span][0]}
        columns |= dict(zip(channels, KPA * course.pressures[span].T, strict=True))
        columns |= dict(zip(marker_columns(markers), MM * course.flat_places[span].T, strict=True))
        entry: dict[str, object] = {"specimen": "hand", "protocol": f"motion_{number + 1}"}
        if moved:
            columns |= dict(zip(WRIST_POSE, _path(course)[span].T, strict=True))
        else:
            first = course.wrist[span][0]
            entry["wrist_rpy"] = [round(float(angle), 6) for angle in to_rpy(first)]
        runs.append(ImportedRun(name, columns, {}, course.files))
        entries[name] = {**entry, "file": f"{name}.csv"}
    units = {name: "m" if index < 3 else "" for index, name in enumerate(WRIST_POSE)}
    found = set_of_runs(HAND_MOTION, courses, specimen, runs, entries, units if moved else None)
    if len(parts) == len(seen):
        return found
    left = f"{len(seen) - len(parts)} of {len(seen)} motions are left out: samples are missing"
    return replace(found, remarks=(*found.remarks, left))


def _motions(course: HandCourse) -> list[slice]:
    """Samples of each motion, from the last one at rest on, thinned to about RATE."""
    time = course.time
    if len(time) < RULES.motion_samples:
        return []
    period = float(np.median(np.diff(time)))
    if period > RULES.motion_gap:
        raise DocumentError(
            f"{course.files[0]}: expected {RATE:.0f} samples a second or more for a motion, got "
            f"{1.0 / period:.0f}; hand_sim publishes fingertips with the parameter `joint_rate`"
        )
    every = max(1, int(1.0 / RATE / period + 0.01))
    rests, found = at_rest(course), []
    for first, last in spans_of(rests):
        if time[last - 1] - time[first] < LEAST_REST:  # it only turns back
            rests[first:last] = False
    moves = spans_of(np.logical_not(rests))
    for (first, last), (following, _) in zip(moves, [*moves[1:], (len(time), 0)], strict=True):
        begin = max(first - 1, 0)
        until = min(time[last - 1] + AFTER, time[begin] + LONGEST)
        end = min(int(np.searchsorted(time, until)), following)
        if first > 0 and end - begin >= every * RULES.motion_samples:
            found.append(slice(begin, end, every))
    return found


def _is_whole(part: tuple[HandCourse, slice]) -> bool:
    """Whether no samples are missing."""
    course, span = part
    return float(np.diff(course.time[span]).max()) <= RULES.motion_gap


def _is_held(part: tuple[HandCourse, slice]) -> bool:
    """Whether the wrist stays where it is."""
    course, span = part
    attitude = course.wrist[span]
    if turned(attitude, attitude[0]).max() > SAME_ATTITUDE:
        return False
    places = course.wrist_places
    return places is None or bool(np.ptp(places[span], axis=0).max() <= WRIST_AT_REST)


def _path(course: HandCourse) -> Array:
    """Place [m] and quaternion (k, 7) of the wrist in the world.

    Raises DocumentError where no file tells the position.
    """
    if course.wrist_places is None:
        raise DocumentError(
            f"{course.files[0]}: expected {listed(WRIST_POSE[:3])} of a wrist that moves, got only "
            "its orientation"
        )
    return np.hstack([course.wrist_places, without_jumps(course.wrist)])


def _protocol(part: tuple[HandCourse, slice], protocols: list[tuple[HandCourse, slice]]) -> int:
    """Index of the protocol that a part repeats, which is added if there is none."""
    for number, other in enumerate(protocols):
        if _alike(part, other):
            return number
    protocols.append(part)
    return len(protocols) - 1


def _alike(part: tuple[HandCourse, slice], other: tuple[HandCourse, slice]) -> bool:
    lengths = [float(np.ptp(course.time[span])) for course, span in (part, other)]
    if abs(lengths[0] - lengths[1]) > IN_TIME * max(lengths):
        return False
    at = np.linspace(0.0, min(lengths), COMPARED)
    (one, turn), (two, turn_of_two) = (_course(*each, at) for each in (part, other))
    pressures, places = np.split(np.abs(one - two).mean(axis=0), [part[0].pressures.shape[1]])
    return bool(
        pressures.max() <= SAME_PRESSURE
        and places.max() <= WRIST_AT_REST
        and turned(turn, turn_of_two).mean() <= SAME_ATTITUDE
    )


def _course(course: HandCourse, span: slice, at: Array) -> tuple[Array, Array]:
    """Pressures [Pa] and shift of the wrist [m] (k, channels + 3), and the quaternion (k, 4) of the
    nearest sample, at times [s] from the beginning of a run.
    """
    time = course.time[span] - course.time[span][0]
    places = np.zeros((len(time), 3))
    if course.wrist_places is not None:
        places = course.wrist_places[span] - course.wrist_places[span][0]
    known = np.hstack([course.pressures[span], places])
    there = np.stack([np.interp(at, time, column) for column in known.T], axis=1)
    nearest = np.minimum(np.searchsorted(time, at), len(time) - 1)
    return there, course.wrist[span][nearest]
