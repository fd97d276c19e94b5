"""Writes computed states of a hand as a bag, with the topics of the nodes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_typestore

from softhand_bringup.bags.writing import BagWriter
from softhand_common.numerics.arrays import Array

STATE_TOPICS = {
    "/clock": "rosgraph_msgs/msg/Clock",
    "/hand/joint_states": "sensor_msgs/msg/JointState",
    "/pneumaticbox/state": "sensor_msgs/msg/JointState",
    "/wrist/pose": "geometry_msgs/msg/PoseStamped",
    "/scene/object_pose": "geometry_msgs/msg/PoseStamped",
    "/grasp/phase": "std_msgs/msg/String",
}
SECOND_NS = 10**9
ROS_TYPES = get_typestore(Stores.ROS2_JAZZY)


@dataclass(frozen=True)
class HandStates:
    """States of a hand at times (k,) [s].

    Joint angles (k, 3 n) [rad] with the names of the joints, air masses [kg above rest] and gauge
    pressures [Pa] (k, channels) with the names of the channels, poses (k, 7) [m, -] of the wrist
    and of the object (None without one), and the phase of the strategy at each state, "" outside of
    phases.
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


def write_states(states: HandStates, folder: Path) -> None:
    """Write states as a rosbag2 folder.

    Raises:
        rosbags.rosbag2.WriterError: the folder exists.
        OSError, UnwritableBag: the folder cannot be written.
    """
    writer = BagWriter(folder)
    try:
        topics = {name: writer.add_topic(name, kind, []) for name, kind in STATE_TOPICS.items()}
        for row, time in enumerate(states.time):
            nanoseconds = round(float(time) * SECOND_NS)
            for name, message in _messages(states, row):
                data = bytes(ROS_TYPES.serialize_cdr(message, STATE_TOPICS[name]))
                writer.write(topics[name], nanoseconds, nanoseconds, data)
    finally:
        writer.close()


def _messages(states: HandStates, row: int) -> Iterator[tuple[str, Any]]:
    """Topic and message of each quantity of one state; the phase only when it changes."""
    seconds, nanoseconds = divmod(round(float(states.time[row]) * SECOND_NS), SECOND_NS)
    stamp = _made("builtin_interfaces/msg/Time", sec=seconds, nanosec=nanoseconds)
    header = _made("std_msgs/msg/Header", stamp=stamp, frame_id="world")
    yield "/clock", _made("rosgraph_msgs/msg/Clock", clock=stamp)
    yield "/hand/joint_states", _joints(header, states.joint_names, states.joints[row], np.zeros(0))
    air = states.masses[row], states.pressures[row]
    yield "/pneumaticbox/state", _joints(header, states.channels, *air)
    yield "/wrist/pose", _pose(header, states.wrist[row])
    if states.object is not None:
        yield "/scene/object_pose", _pose(header, states.object[row])
    phase = states.phases[row]
    if phase != (states.phases[row - 1] if row else ""):
        yield "/grasp/phase", _made("std_msgs/msg/String", data=phase)


def _made(kind: str, /, **fields: Any) -> Any:
    return ROS_TYPES.types[kind](**fields)


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
