"""Frames of a recorded hand as `/tf` and `/tf_static`, as tf2 would publish them.

The tree: `world` has `wrist` and `object`, and `wrist` has the links of the hand's URDF. The frames
of a hand in a namespace begin with it, as in `left/wrist`.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from typing import Any
from xml.etree import ElementTree

import numpy as np
from rosbags.interfaces import Qos
from rosbags.typesys import Stores, get_typestore

from softhand_bringup.bags.writing import BagWriter
from softhand_common.numerics.arrays import Array

TF, TF_STATIC, TF_TYPE = "/tf", "/tf_static", "tf2_msgs/msg/TFMessage"
WORLD = "world"
KINDS = {  # of the topics from which frames are made
    "wrist/pose": "geometry_msgs/msg/PoseStamped",
    "scene/object_pose": "geometry_msgs/msg/PoseStamped",
    "robot_description": "std_msgs/msg/String",
    "hand/joint_states": "sensor_msgs/msg/JointState",
}
LINK_PERIOD = 40_000_000  # between two messages with the hand's links [ns]
ENCAPSULATION = b"\x00\x01\x00\x00"  # CDR, little endian
STAMP = struct.Struct("<iI")
NO_STAMP = (0, 0)
POSE_SIZE = 7 * 8  # position and quaternion, at the end of a PoseStamped [bytes]


class FrameMessage:
    """A TFMessage with fixed names, serialised once; only stamp and numbers are filled in.

    Args:
        names: names of parent and child of each frame.
    """

    def __init__(self, names: Sequence[tuple[str, str]]) -> None:
        data = bytearray(struct.pack("<I", len(names)))
        self._stamps, places = [], []
        for parent_and_child in names:
            _pad(data, 4)
            self._stamps.append(len(data))
            data += bytes(STAMP.size)
            for name in parent_and_child:
                text = name.encode() + b"\0"
                _pad(data, 4)
                data += struct.pack("<I", len(text)) + text
            _pad(data, 8)
            places.append(len(data) // 8)
            data += bytes(POSE_SIZE)
        self._data = data
        self._places = np.array(places, dtype=int)[:, None] + np.arange(7)

    def encoded(self, stamp: tuple[int, int], poses: Array) -> bytes:
        """The message with a stamp [s, ns] and the poses (frames, 7): position [m], quaternion."""
        np.frombuffer(self._data, dtype="<f8")[self._places] = poses
        for place in self._stamps:
            STAMP.pack_into(self._data, place, *stamp)
        return ENCAPSULATION + bytes(self._data)


def _pad(data: bytearray, size: int) -> None:
    data += bytes(-len(data) % size)


class Links:
    """The links of a URDF: those that are fixed to their parent, and those that turn about an axis.

    Args:
        urdf: text of the URDF.
        prefix: beginning of the frames' names, such as `left/`.

    Raises:
        ValueError: the text is not a URDF.
    """

    def __init__(self, urdf: str, prefix: str) -> None:
        try:
            joints = ElementTree.fromstring(urdf).findall("joint")
        except ElementTree.ParseError as error:
            raise ValueError(f"expected a URDF, got text that is not XML: {error}") from error
        fixed = [joint for joint in joints if joint.get("type") == "fixed"]
        turning = [joint for joint in joints if joint.get("type") == "revolute"]
        self.fixed = FrameMessage([_names(joint, prefix) for joint in fixed])
        self.turning = FrameMessage([_names(joint, prefix) for joint in turning])
        self.fixed_poses = np.array([_origin(joint) for joint in fixed]).reshape(-1, 7)
        self._origins = np.array([_origin(joint) for joint in turning]).reshape(-1, 7)
        axes = [_vector(joint.find("axis"), "xyz", "1 0 0") for joint in turning]
        self._axes = np.array(axes).reshape(-1, 3)
        self.count = len(turning)
        self._order = {str(joint.get("name")): k for k, joint in enumerate(turning)}

    def poses(self, names: Sequence[str], angles: Array) -> Array:
        """Poses (k, 7), position [m] and quaternion, of the turning links at angles [rad] of the
        named joints; joints without a name here are at 0.
        """
        half = np.zeros(len(self._order))
        for name, angle in zip(names, angles, strict=True):
            if name in self._order:
                half[self._order[name]] = 0.5 * angle
        turns = np.column_stack([np.sin(half)[:, None] * self._axes, np.cos(half)])
        return np.column_stack([self._origins[:, :3], _product(self._origins[:, 3:], turns)])


def _names(joint: Any, prefix: str) -> tuple[str, str]:
    ends = [joint.find(end) for end in ("parent", "child")]
    if any(end is None or end.get("link") is None for end in ends):
        raise ValueError(f"expected a parent and a child link, got joint {joint.get('name')}")
    parent, child = (prefix + end.get("link") for end in ends)
    return parent, child


def _vector(element: Any, name: str, default: str = "0 0 0") -> list[float]:
    """Three numbers of an attribute, or the default of URDF where it is absent."""
    text = default if element is None else element.get(name, default)
    vector = [float(word) for word in text.split()]
    if len(vector) != 3:
        raise ValueError(f"expected three numbers, got {name} {text[:40]!r}")
    return vector


def _origin(joint: Any) -> list[float]:
    """Pose (7,) of a joint's origin; of its roll, pitch and yaw, roll turns first."""
    origin = joint.find("origin")
    turn = np.array([[0.0, 0.0, 0.0, 1.0]])
    for axis, angle in zip(np.eye(3), _vector(origin, "rpy"), strict=True):
        step = np.array([[*(np.sin(0.5 * angle) * axis), np.cos(0.5 * angle)]])
        turn = _product(step, turn)
    return [*_vector(origin, "xyz"), *turn[0]]


def _product(first: Array, second: Array) -> Array:
    """Products (k, 4) of quaternions x, y, z, w (k, 4): `second` turns first."""
    a, b = first[:, :3], second[:, :3]
    p, q = first[:, 3:], second[:, 3:]
    scalar = p * q - np.sum(a * b, axis=1, keepdims=True)
    return np.column_stack([p * b + q * a + np.cross(a, b), scalar])


class FrameWriter:
    """Writes the frames of the hands whose topics are recorded to the same bag.

    Args:
        bag: the bag that is written.
        offered, offered_static: offered QoS of `/tf` and of `/tf_static`.
    """

    def __init__(
        self, bag: BagWriter, offered: Sequence[Qos], offered_static: Sequence[Qos]
    ) -> None:
        self._bag, self._types = bag, get_typestore(Stores.ROS2_JAZZY)
        self._moving = bag.add_topic(TF, TF_TYPE, offered)
        self._static = bag.add_topic(TF_STATIC, TF_TYPE, offered_static)
        self._links: dict[str, Links] = {}  # by namespace, as in `left/`
        self._single: dict[str, FrameMessage] = {}  # by topic
        self.refused = ""  # why the links of a description have no frames
        self._next: dict[str, int] = {}  # when the links of a namespace are due [ns]
        self._endings: dict[tuple[str, str], str] = {}  # by topic and kind; "" makes no frames
        self._handlers: dict[str, Callable[[str, str, int, int, bytes], None]] = {
            "wrist/pose": self._wrist,
            "scene/object_pose": self._object,
            "robot_description": self._description,
            "hand/joint_states": self._joints,
        }

    def take(self, topic: str, kind: str, logged: int, published: int, data: bytes) -> None:
        """Take a recorded message of type `kind`, with its stamps of reception (`logged`) and of
        sending (`published`) [ns].
        """
        if (topic, kind) not in self._endings:
            endings = (e for e in KINDS if topic.endswith(f"/{e}") and kind == KINDS[e])
            self._endings[topic, kind] = next(endings, "")
        if ending := self._endings[topic, kind]:
            prefix = topic[1:].removesuffix(ending)
            self._handlers[ending](topic, prefix, logged, published, data)

    def _wrist(self, topic: str, prefix: str, logged: int, published: int, data: bytes) -> None:
        self._pose(topic, f"{prefix}wrist", logged, published, data)

    def _object(self, topic: str, prefix: str, logged: int, published: int, data: bytes) -> None:
        self._pose(topic, f"{prefix}object", logged, published, data)

    def _pose(self, topic: str, child: str, logged: int, published: int, data: bytes) -> None:
        frame = self._single.get(topic)
        if frame is None:
            frame = self._single[topic] = FrameMessage([(WORLD, child)])
        pose = np.frombuffer(data[-POSE_SIZE:], dtype="<f8")[None, :]
        self._bag.write(self._moving, logged, published, frame.encoded(_stamp(data), pose))

    def _description(
        self, topic: str, prefix: str, logged: int, published: int, data: bytes
    ) -> None:
        description: Any = self._types.deserialize_cdr(data, "std_msgs/msg/String")
        self._links.pop(prefix, None)
        try:
            links = self._links[prefix] = Links(description.data, prefix)
        except ValueError as error:
            self.refused = f"{topic}: {error}"
            return
        if len(links.fixed_poses):
            encoded = links.fixed.encoded(NO_STAMP, links.fixed_poses)
            self._bag.write(self._static, logged, published, encoded)

    def _joints(self, topic: str, prefix: str, logged: int, published: int, data: bytes) -> None:
        seconds, nanoseconds = _stamp(data)
        now, due = seconds * 10**9 + nanoseconds, self._next.get(prefix, 0)
        if prefix not in self._links or due - LINK_PERIOD < now < due:
            return
        self._next[prefix] = now + LINK_PERIOD
        links = self._links[prefix]
        state: Any = self._types.deserialize_cdr(data, "sensor_msgs/msg/JointState")
        if not links.count or len(state.name) != len(state.position):
            return
        encoded = links.turning.encoded(
            (seconds, nanoseconds), links.poses(state.name, state.position)
        )
        self._bag.write(self._moving, logged, published, encoded)


def _stamp(data: bytes) -> tuple[int, int]:
    """Stamp [s, ns] of a serialised message that begins with a header."""
    seconds, nanoseconds = STAMP.unpack_from(data, len(ENCAPSULATION))
    return seconds, nanoseconds
