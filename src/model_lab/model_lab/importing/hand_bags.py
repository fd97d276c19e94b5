"""Bags that this suite recorded of a hand that held poses, or moved, in free air."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from model_lab.aliases import Array
from model_lab.importing.bag_tables import TopicTable, read_topics
from model_lab.importing.hand_courses import HandCourse, without_jumps
from model_lab.measurements.bags.messages import messages_of, opened
from model_lab.measurements.hands import default_markers
from softhand_common.documents.quoted import listed
from softhand_common.documents.yaml_document import DocumentError
from softhand_model.hand.hand import HandDescription

PLACES_OF_TIPS, STATE_OF_AIR, POSE_OF_WRIST = "hand/fingertips", "pneumaticbox/state", "wrist/pose"
HAND_TOPICS = (PLACES_OF_TIPS, STATE_OF_AIR, POSE_OF_WRIST)
LOAD_TOPIC = "wrist/wrench"  # of an arm that feels it
JOINTS = "hand/joint_states"  # of a simulated hand, one for each segment


def are_bags_of_hand(files: Sequence[Path]) -> bool:
    """Whether all files are bags with the topics of a hand of this suite."""
    return all((path / "metadata.yaml").is_file() for path in files) and all(
        _topics(path) >= set(HAND_TOPICS) for path in files
    )


def _topics(bag: Path) -> set[str]:
    with opened(bag) as reader:
        return {_suffix(topic) for topic in reader.topics}


def _suffix(topic: str) -> str:
    return "/".join(topic.split("/")[-2:])


def segments_of(bag: Path, hand: HandDescription) -> int | None:
    """Number of segments into which the actuators of the recorded hand are cut, from the joints in
    a bag; None for a bag without joints, which only simulated hands publish.
    """
    with opened(bag) as reader:
        topic = next((name for name in reader.topics if _suffix(name) == JOINTS), None)
        first = next(messages_of(bag, reader, topic), None) if topic else None
    if first is None:
        return None
    chain = hand.chain(hand.tips[0])
    joints = sum(bool(re.fullmatch(rf"{chain.name}_\d+_x", name)) for name in first[1].name)
    return (joints - (chain.strut is not None)) or None


def course_of_bag(bag: Path, hand: HandDescription) -> HandCourse:
    """The course of a hand from a bag with `hand/fingertips`, `pneumaticbox/state` and
    `wrist/pose`, and `wrist/wrench` if it is there.

    Raises DocumentError for a bag of another hand or of two hands.
    """
    found = topics_of_hand(bag, hand)
    tips, state, wrist = (found[name] for name in HAND_TOPICS)
    places = np.stack(
        [
            [tips.columns[f"poses[{number}].position.{axis}"] for axis in "xyz"]
            for number in range(len(hand.tips))
        ]
    ).transpose(2, 0, 1)
    pose = [f"pose.position.{axis}" for axis in "xyz"]
    turn = [f"pose.orientation.{axis}" for axis in "xyzw"]
    turns = interpolated(tips.time, wrist.time, without_jumps(columns_of(wrist, turn, bag)))
    efforts = columns_of(state, [f"effort[{name}]" for name in hand.channels], bag)
    return HandCourse(
        (bag,),
        tips.time,
        interpolated(tips.time, state.time, efforts),
        dict(zip(default_markers(hand), places.transpose(1, 0, 2), strict=True)),
        turns / np.linalg.norm(turns, axis=1)[:, None],
        wrist_places=interpolated(tips.time, wrist.time, columns_of(wrist, pose, bag)),
        load=_load(found.get(LOAD_TOPIC), tips.time, bag),
    )


def topics_of_hand(bag: Path, hand: HandDescription) -> dict[str, TopicTable]:
    """The topics of a bag of a hand, by the last two words of their names; raises DocumentError for
    a bag of two hands, and for another number of fingertips.
    """
    found: dict[str, TopicTable] = {}
    for topic in read_topics(bag):
        if found.setdefault(_suffix(topic.topic), topic) is not topic:
            raise DocumentError(
                f"{bag}: expected topics of one hand, got those of two, such as {topic.topic} and "
                f"{found[_suffix(topic.topic)].topic}; record each hand in a bag of its own"
            )
    tips = found[PLACES_OF_TIPS]
    counted = sum(name.endswith("position.x") for name in tips.columns)
    if counted != len(hand.tips):
        raise DocumentError(
            f"{bag}: {tips.topic}: expected {len(hand.tips)} fingertips of {hand.name}, got "
            f"{counted}: is --hand the hand that was recorded?"
        )
    return found


def _load(wrench: TopicTable | None, time: Array, bag: Path) -> Array | None:
    """Size (k,) [N] of the force on the wrist at times (k,) [s], if it was recorded."""
    if wrench is None:
        return None
    force = columns_of(wrench, [f"wrench.force.{axis}" for axis in "xyz"], bag)
    return np.linalg.norm(interpolated(time, wrench.time, force), axis=1)


def columns_of(topic: TopicTable, names: Sequence[str], bag: Path) -> Array:
    """Values (k, names) of a topic."""
    missing = [name for name in names if name not in topic.columns]
    if missing:
        raise DocumentError(
            f"{bag}, topic {topic.topic}: expected the fields {listed(names)}, "
            f"lacks {listed(missing)}"
        )
    return np.stack([topic.columns[name] for name in names], axis=1)


def interpolated(time: Array, known: Array, values: Array) -> Array:
    """Values (k, n) at each time (k,) [s], straight between those (m, n) at known times (m,)."""
    return np.stack([np.interp(time, known, column) for column in values.T], axis=1)
