"""Files of a whole hand as a set: this suite's bags, or tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from model_lab.aliases import Array
from model_lab.importing.hand_bags import are_bags_of_hand, course_of_bag, segments_of
from model_lab.importing.hand_columns import (
    ALL_PLACES,
    OF_PRESSURE,
    OF_TIME,
    WRIST,
    Maps,
    hand_meanings,
    has_markers,
    partial_markers,
    places_in,
)
from model_lab.importing.hand_contacts import Touched, kind_of, set_of_contacts
from model_lab.importing.hand_courses import HandCourse
from model_lab.importing.hand_motions import set_of_motions
from model_lab.importing.hand_poses import held_poses, set_of_poses
from model_lab.importing.hand_tables import HandFile, courses_of
from model_lab.importing.importing import ImportedSet, Proposal, of_files
from model_lab.importing.runs import Source
from model_lab.importing.tables import Table, read_tables
from model_lab.measurements.hand_frame import WristFrame, frame_against_wrist, misfit
from model_lab.measurements.hands import (
    FREE_FRAME,
    GRASP,
    HAND_MOTION,
    HAND_POSE,
    OF_HANDS,
    WITH_WRENCH,
    HandSpecimen,
    default_markers,
    pressure_columns,
)
from model_lab.measurements.measurement_set import INVERSE_QUATERNION
from softhand_common.documents.quoted import listed, shortened
from softhand_common.documents.yaml_document import DocumentError
from softhand_common.numerics.rotations import compose, rotate
from softhand_model.hand.hand import HandDescription, hand_names, load_hand

Y_UP = np.array([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])  # turns y to where z is
AS_ONE_FINGER = "tip_angle=tip(ALONG,ACROSS)"  # what to map of a finger in a plane
UP_GAIN = 0.9  # by hand: of the misfit with z up, below which y is said to be up


def set_of_hand(
    files: Sequence[Path],
    hand: str | None,
    experiment: str | None = None,
    maps: Maps | None = None,
    shifts: Mapping[str, float] | None = None,
    messages: Path | None = None,
    decimal: str = "",
    sheets: Mapping[str, str] | None = None,
    wrist: Mapping[str, Sequence[float]] | None = None,
    touched: Touched | None = None,
) -> tuple[ImportedSet, Proposal] | None:
    """(set of a hand, proposal with the meaning of the columns): of the poses, or of the experiment
    `hand_motion`, or, from bags, `press` or `grasp`. None if the files are not of a whole hand:
    `hand` names no hand with several fingers, or no file has a marker of it.

    wrist: roll, pitch and yaw [rad] in which the wrist was held, by the name of the file; "" for
    all others. touched: what a press or grasp touches. The other arguments are those of
    `importing.propose` and `make_set`.

    Raises DocumentError as `set_of_poses`, `set_of_motions`, `set_of_contacts`, `course_of_bag` and
    `courses_of` do, and for an argument about a quantity that sets of a hand do not have.
    """
    if touched and experiment != kind_of(touched):
        got = f"--experiment {experiment}" if experiment else "none"
        option = "--object" if kind_of(touched) == GRASP else "--plate"
        raise DocumentError(f"{option}: expected --experiment {kind_of(touched)}, got {got}")
    if experiment not in (None, *OF_HANDS):
        return None
    if not hand or ":" in hand or len((described := load_hand(hand)).tips) < 2:
        if experiment:
            raise DocumentError(
                f"--hand: expected the name of a whole hand, such as rbo_hand_2, got {hand}"
            )
        return None
    kind = experiment or HAND_POSE
    cut = set_of_motions if kind == HAND_MOTION else set_of_poses
    stated, given = hand if hand in hand_names() else str(Path(hand).resolve()), maps or {}
    if experiment in WITH_WRENCH:
        _check_contacts(files, experiment, given, touched)
    if not given and are_bags_of_hand(files):
        if shifts:
            raise DocumentError(
                "--shift: expected files with separate clocks, got bags; the topics of a bag have "
                "one clock, so leave --shift out"
            )
        specimen = HandSpecimen(stated, described, _segments_of(files, described))
        if touched:
            return set_of_contacts(files, specimen, touched), Proposal((), kind, {})
        courses = [course_of_bag(bag, described) for bag in files]
        return cut(courses, specimen), Proposal((), kind, {})
    of = sheets or {}
    tables = [
        table
        for path in files
        for table in read_tables(path, messages, decimal, of.get(path.name, of.get("", "")))
    ]
    if not any(has_markers(table, described, given) for table in tables):
        if not any(name.startswith("tip_") for name in given):  # as of a single finger
            _check_axes(tables, hand, described, given)
        others = list(dict.fromkeys(name for table in tables for name in places_in(table)))
        if experiment or len(others) > 1:
            raise DocumentError(
                f"{listed(map(str, files))}: expected x, y and z of "
                f"{listed(default_markers(described))}, got "
                f"{f'positions: {listed(others)}' if others else 'none'}; give --map "
                f"{next(iter(default_markers(described)))}=WORDS, the words that its three "
                "columns share"
            )
        return None
    _check_maps(given, described)
    read = [HandFile(table, hand_meanings(table, described, given)) for table in tables]
    read = [one for one in read if one.parts.meanings] or read
    names = [one.table.path.name for one in read]
    shifts = of_files("--shift", shifts or {}, names)
    wrist = of_files("--wrist", wrist or {}, names)
    proposal = Proposal(tuple(Source(one.table, one.meanings) for one in read), kind, {})
    courses = courses_of(read, described, shifts, wrist)
    up = _about_up(courses, described)
    courses, said = _in_frame_of_wrist(courses, described)
    if said and kind == HAND_MOTION:
        raise DocumentError(
            f"{listed(map(str, files))}: expected positions in the frame of the wrist for a "
            f"motion, got another frame: {said[0]}; convert the positions, or import "
            "poses at rest (--experiment hand_pose)"
        )
    found = cut(courses, HandSpecimen(stated, described, free_frame=bool(said)))
    return replace(found, remarks=(*up, *found.remarks, *said)), proposal


def _check_axes(tables: Sequence[Table], stated: str, hand: HandDescription, given: Maps) -> None:
    """Raise DocumentError if a file has two axes of a marker of the hand. stated: name or file of
    the hand.
    """
    for table in tables:
        for marker, axes in partial_markers(table, hand, given).items():
            chain = dict(zip(default_markers(hand), hand.tips, strict=True))[marker]
            raise DocumentError(
                f"{table.path}: {marker}: expected x, y and z, got {listed(axes)}; in a plane only "
                f"a single finger can be measured: --hand {stated}:{chain} "
                f"--map '{AS_ONE_FINGER}'"
            )


def _check_contacts(
    files: Sequence[Path], experiment: str, given: Maps, touched: Touched | None
) -> None:
    """Raise DocumentError unless files and options are those of a press or grasp."""
    if given or not are_bags_of_hand(files):
        raise DocumentError(
            f"--experiment {experiment}: expected bags that this suite recorded, got "
            f"{listed(map(str, files))}; for other files, write experiment.yaml by hand"
        )
    if touched is None:
        what = "--object NAME" if experiment == GRASP else "--plate FRICTION"
        raise DocumentError(f"--experiment {experiment}: expected {what}, got none")


def _in_frame_of_wrist(
    courses: list[HandCourse], hand: HandDescription
) -> tuple[list[HandCourse], list[str]]:
    """The courses with places, and the attitude if it was measured, in the frame of the model's
    wrist, and what was turned, if anything. Raises DocumentError if the attitude is stated for some
    courses and measured in others whose frame is turned.
    """
    held = _held(courses)
    if held is None:
        return courses, []
    pressures, down, places = held
    stated = {course.stated for course in courses}
    measured = None if len(stated) > 1 else not stated.pop()
    frame = frame_against_wrist(hand, default_markers(hand), pressures, down, places, measured)
    if frame is None:
        return courses, []
    if measured is None:
        raise DocumentError(
            "--wrist: expected the orientation of the wrist of all files or of none, as the places "
            f"are in a frame that is {frame.said} against the wrist, got it of some"
        )
    beside = "and so is the measured orientation" if measured else "the stated orientation stays"
    said = (
        f"the places were in a frame that is {frame.said} against the wrist of the model, as that "
        f"of a tracked body usually is; by the shape of the hand they are turned back, {beside}, "
        f"and `frame: {FREE_FRAME}` in experiment.yaml lets each fit find the rest"
    )
    return [_turned_back(course, frame) for course in courses], [said]


def _held(courses: list[HandCourse]) -> tuple[Array, Array, dict[str, Array]] | None:
    """Pressures (channels, k) [Pa], direction down (k, 3) in the frame of the wrist, and places
    (k, 3) [m] by marker, of all poses that were held; None without any.
    """
    poses = [pose for course in courses for pose in held_poses(course)]
    if not poses:
        return None
    back = np.stack([pose.wrist for pose in poses]) * INVERSE_QUATERNION
    places = {
        name: np.stack([pose.places[index] for pose in poses])
        for index, name in enumerate(courses[0].places)
    }
    down = np.stack([rotate(turn, [0.0, 0.0, -1.0]) for turn in back])
    return np.stack([pose.pressures for pose in poses], axis=1), down, places


def _about_up(courses: list[HandCourse], hand: HandDescription) -> list[str]:
    """Says so if the tracked hand hangs as if y, not z, of the world pointed up."""
    if any(course.wrist_places is None for course in courses):
        return []
    level = [replace(one, wrist=compose(Y_UP, one.wrist)) for one in courses]
    z, y = (
        np.nan if held is None else 1e3 * misfit(hand, default_markers(hand), *held)
        for held in map(_held, (courses, level))
    )
    if not y < UP_GAIN * z:
        return []
    return [
        f"y of the world seems to point up: so the hand differs from its model by {y:.2g} mm, but "
        f"with z up by {z:.2g} mm; the lab takes z as up, so export the tracking with z up"
    ]


def _turned_back(course: HandCourse, frame: WristFrame) -> HandCourse:
    from scipy.spatial.transform import Rotation  # here, as it takes long to load

    places = {name: (place - frame.shift) @ frame.turn for name, place in course.places.items()}
    attitude = course.wrist
    if frame.of_weight:
        attitude = compose(attitude, Rotation.from_matrix(frame.turn).as_quat())
    return replace(course, places=places, wrist=attitude)


def _check_maps(given: Maps, hand: HandDescription) -> None:
    known = (
        OF_TIME,
        OF_PRESSURE,
        ALL_PLACES,
        WRIST,
        *pressure_columns(hand),
        *default_markers(hand),
    )
    unknown = [name for name in given if name not in known]
    if unknown:
        raise DocumentError(
            f"--map: expected one of {listed(known)} of a hand, got {shortened(unknown[0])}"
        )


def _segments_of(bags: Sequence[Path], hand: HandDescription) -> int | None:
    cut = {segments_of(bag, hand) for bag in bags}
    if len(cut) > 1:
        raise DocumentError(
            f"{listed(map(str, bags))}: expected bags of one hand, got bags of hands that are "
            "simulated with different numbers of segments per actuator: "
            f"{listed(map(str, cut))} (None: a real hand); import them separately"
        )
    return cut.pop()
