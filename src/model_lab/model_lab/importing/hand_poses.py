"""Bags of this suite in which a hand held poses in free air, as a set `hand_pose`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from model_lab.aliases import Array, IntArray
from model_lab.importing.bag_tables import TopicTable, read_topics
from model_lab.importing.importing import ImportedSet
from model_lab.importing.runs import ImportedRun
from model_lab.measurements.bags.messages import messages_of, opened
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
from softhand_model.hand.hand import HandDescription, hand_names, load_hand

HAND_TOPICS = ("hand/fingertips", "pneumaticbox/state", "wrist/pose")
JOINTS = "hand/joint_states"  # of a simulated hand, one for each segment
# by hand: above the noise of pressures, below what tells two poses apart
HOLD = 0.8  # [s] for which a pose must be held
MARGIN = 0.25  # [s] of it at either end that are left out
TIP_SHIFT, PRESSURE_SHIFT = 1e-3, 1e3  # [m], [Pa] by which it may change within the margin
SAME_ATTITUDE = np.deg2rad(2.0)  # of the wrist, within a run and between repeats
NO_AIR, SAME_PRESSURE = 2e3, 4e3  # [Pa] below which a hand is empty; between repeats
KPA, MM = 1e-3, 1e3  # units of the set over those of ROS


@dataclass(frozen=True)
class Pose:
    """Means over a pose that was held: time [s], pressures (channels,) [Pa], places of the tips
    (tips, 3) [m] and quaternion (4,) of the wrist in the world.
    """

    time: float
    pressures: Array
    tips: Array
    wrist: Array


def is_of_hand(files: Sequence[Path], hand: str | None) -> bool:
    """Whether all files are bags with the topics of a hand of this suite, and `hand` is one with
    several fingers, none of which is named.
    """
    if not hand or ":" in hand or not all((path / "metadata.yaml").is_file() for path in files):
        return False
    return len(load_hand(hand).tips) > 1 and all(
        _topics(path) >= set(HAND_TOPICS) for path in files
    )


def set_of_poses(bags: Sequence[Path], hand: str) -> ImportedSet:
    """The set of all poses that were held, at least HOLD long, with the wrist and the hand at rest.

    A run ends where the wrist turns or the hand is empty again; runs with the same poses are
    repeats of a protocol. What moves is left out. That the hand touches nothing is not tested.

    bags: recordings of `hand/fingertips`, `pneumaticbox/state` and `wrist/pose`. hand: name or file
    of the hand. Raises DocumentError for a bag of another hand, or without poses.
    """
    described = load_hand(hand)
    stated = hand if hand in hand_names() else str(Path(hand).resolve())
    runs: list[ImportedRun] = []
    entries: dict[str, object] = {}
    cut = {segments_of(bag, described) for bag in bags}
    if len(cut) > 1:
        raise DocumentError(
            f"{listed(map(str, bags))}: expected one hand, got segments an actuator: "
            f"{listed(map(str, cut))} (None: of a real one)"
        )
    segments = cut.pop()
    protocols: list[list[Pose]] = []
    for bag in bags:
        for poses in _runs(_poses(bag, described)):
            number = _protocol(poses, protocols)
            name = f"r{len(runs) + 1}"
            runs.append(ImportedRun(name, _columns(poses, described), {}, (bag,)))
            entries[name] = {
                "specimen": "hand",
                "protocol": f"poses_{number + 1}",
                "wrist_rpy": [round(float(angle), 6) for angle in to_rpy(poses[0].wrist)],
                "file": f"{name}.csv",
            }
    if not runs:
        raise DocumentError(
            f"{listed(map(str, bags))}: expected runs of at least two poses, each held for {HOLD} "
            "s, got none; wait longer in each pose"
        )
    columns = {"time": {"unit": "s"}}
    columns |= {name: {"unit": "kPa"} for name in pressure_columns(described)}
    columns |= {name: {"unit": "mm"} for name in marker_columns(default_markers(described))}
    document = {
        "format": SET_FORMAT,
        "experiment": HAND_POSE,
        "title": f"imported from {bags[0].name}"[:80],
        "specimens": {"hand": HandSpecimen(stated, described, segments).entry()},
        "columns": columns,
        "runs": entries,
    }
    return ImportedSet(document, tuple(runs), _remarks(len(runs), len(protocols), segments))


def _remarks(runs: int, protocols: int, segments: int | None) -> tuple[str, ...]:
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
    return tuple(remarks)


# ---------------------------------------------------------------------- reading
def _topics(bag: Path) -> set[str]:
    with opened(bag) as reader:
        return {_suffix(topic) for topic in reader.topics}


def _suffix(topic: str) -> str:
    return "/".join(topic.split("/")[-2:])


def segments_of(bag: Path, hand: HandDescription) -> int | None:
    """Segments of an actuator of the hand that a bag's joints are of; None without joints, which
    only simulated hands have.
    """
    with opened(bag) as reader:
        topic = next((name for name in reader.topics if _suffix(name) == JOINTS), None)
        first = next(messages_of(bag, reader, topic), None) if topic else None
    if first is None:
        return None
    chain = hand.chain(hand.tips[0])
    joints = sum(bool(re.fullmatch(rf"{chain.name}_\d+_x", name)) for name in first[1].name)
    return (joints - (chain.strut is not None)) or None


def _poses(bag: Path, hand: HandDescription) -> list[Pose]:
    found: dict[str, TopicTable] = {}
    for topic in read_topics(bag):
        if found.setdefault(_suffix(topic.topic), topic) is not topic:
            raise DocumentError(
                f"{bag}: expected one hand, got {topic.topic} and "
                f"{found[_suffix(topic.topic)].topic}; record them in bags of their own"
            )
    tips, state, wrist = (found[name] for name in HAND_TOPICS)
    counted = sum(name.endswith("position.x") for name in tips.columns)
    if counted != len(hand.tips):
        raise DocumentError(
            f"{bag}: {tips.topic}: expected {len(hand.tips)} fingertips of {hand.name}, got "
            f"{counted}: is --hand the hand that was recorded?"
        )
    places = np.stack(
        [
            [tips.columns[f"poses[{number}].position.{axis}"] for axis in "xyz"]
            for number in range(counted)
        ]
    ).transpose(2, 0, 1)
    pressures = _at(tips.time, state, [f"effort[{name}]" for name in hand.channels], bag)
    turns = _at(tips.time, wrist, [f"pose.orientation.{axis}" for axis in "xyzw"], bag)
    at_rest = _at_rest(tips.time, places.reshape(len(places), -1), pressures, turns)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], at_rest.astype(int), [0]])))
    return [
        Pose(
            float(tips.time[first:last].mean()),
            pressures[first:last].mean(axis=0),
            places[first:last].mean(axis=0),
            turns[(first + last) // 2],
        )
        for first, last in zip(edges[::2], edges[1::2], strict=True)
        if tips.time[last - 1] - tips.time[first] >= HOLD - 2.0 * MARGIN
    ]


def _at(time: Array, topic: TopicTable, names: Sequence[str], bag: Path) -> Array:
    """The last values (k, names) of a topic at each time; the first ones before them."""
    missing = [name for name in names if name not in topic.columns]
    if missing:
        raise DocumentError(f"{bag}: {topic.topic}: expected {listed(names)}, got no {missing[0]}")
    last = np.maximum(np.searchsorted(topic.time, time, side="right") - 1, 0)
    return np.stack([topic.columns[name][last] for name in names], axis=1)


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


def _columns(poses: Sequence[Pose], hand: HandDescription) -> dict[str, Array]:
    time = np.array([pose.time for pose in poses])
    pressures = KPA * np.array([pose.pressures for pose in poses]).T
    tips = MM * np.array([pose.tips.ravel() for pose in poses]).T
    return (
        {"time": time - time[0]}
        | dict(zip(pressure_columns(hand), pressures, strict=True))
        | dict(zip(marker_columns(default_markers(hand)), tips, strict=True))
    )
