"""A bag of a course that was calculated without nodes, with the topics that the nodes have."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.typesys import Stores, get_typestore

from softhand_bringup.bags.writing import BagWriter

Array = NDArray[np.float64]

TOPICS = {
    "/clock": "rosgraph_msgs/msg/Clock",
    "/hand/joint_states": "sensor_msgs/msg/JointState",
    "/pneumaticbox/state": "sensor_msgs/msg/JointState",
    "/wrist/pose": "geometry_msgs/msg/PoseStamped",
    "/scene/object_pose": "geometry_msgs/msg/PoseStamped",
    "/grasp/phase": "std_msgs/msg/String",
}
NANO = 10**9
TYPES = get_typestore(Stores.ROS2_JAZZY)


@dataclass(frozen=True)
class Course:
    """States at times (k,) [s]: angles (k, 3 n) [rad] of the joints by their names, air masses and
    gauge pressures (k, channels) [kg above rest, Pa], poses (k, 7) [m, -] of the wrist and of the
    object (None: there is none), and the phase of each, "" for none.
    """

    time: Array
    joint_names: Sequence[str]
    joints: Array
    channels: Sequence[str]
    masses: Array
    pressures: Array
    wrist: Array
    object: Array | None
    phases: Sequence[str]


def write_course(course: Course, folder: Path) -> None:
    """Write a course as a rosbag2 folder.

    Raises:
        rosbags.rosbag2.WriterError: the folder exists.
        OSError, UnwritableBag: it cannot be written.
    """
    writer = BagWriter(folder)
    try:
        topics = {name: writer.add_topic(name, kind, []) for name, kind in TOPICS.items()}
        for row, time in enumerate(course.time):
            nanoseconds = round(float(time) * NANO)
            for name, message in _messages(course, row):
                data = bytes(TYPES.serialize_cdr(message, TOPICS[name]))
                writer.write(topics[name], nanoseconds, nanoseconds, data)
    finally:
        writer.close()


def _messages(course: Course, row: int) -> Iterator[tuple[str, Any]]:
    """Topic and message of all that a row holds; the phase where it changes."""
    seconds, nanoseconds = divmod(round(float(course.time[row]) * NANO), NANO)
    stamp = _made("builtin_interfaces/msg/Time", sec=seconds, nanosec=nanoseconds)
    header = _made("std_msgs/msg/Header", stamp=stamp, frame_id="world")
    yield "/clock", _made("rosgraph_msgs/msg/Clock", clock=stamp)
    yield "/hand/joint_states", _joints(header, course.joint_names, course.joints[row], np.zeros(0))
    air = course.masses[row], course.pressures[row]
    yield "/pneumaticbox/state", _joints(header, course.channels, *air)
    yield "/wrist/pose", _pose(header, course.wrist[row])
    if course.object is not None:
        yield "/scene/object_pose", _pose(header, course.object[row])
    phase = course.phases[row]
    if phase != (course.phases[row - 1] if row else ""):
        yield "/grasp/phase", _made("std_msgs/msg/String", data=phase)


def _made(kind: str, /, **fields: Any) -> Any:
    return TYPES.types[kind](**fields)


def _joints(header: Any, names: Sequence[str], position: Array, effort: Array) -> Any:
    return _made(
        "sensor_msgs/msg/JointState",
        header=header,
        name=list(names),
        position=position,
        velocity=np.zeros(0),
        effort=effort,
    )


def _pose(header: Any, pose: Array) -> Any:
    place = dict(zip("xyz", pose[:3].tolist(), strict=True))
    turn = dict(zip("xyzw", pose[3:].tolist(), strict=True))
    made = _made(
        "geometry_msgs/msg/Pose",
        position=_made("geometry_msgs/msg/Point", **place),
        orientation=_made("geometry_msgs/msg/Quaternion", **turn),
    )
    return _made("geometry_msgs/msg/PoseStamped", header=header, pose=made)
