"""Bags of one measured run, as a recorder would leave them, written without ROS."""

from pathlib import Path

import numpy as np
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)
ROS1_STORE = get_typestore(Stores.ROS1_NOETIC)
T = STORE.types
WALL_START = 1_700_000_000_000_000_000  # [ns]
NONE = np.array([])


def stamp(seconds):
    return T["builtin_interfaces/msg/Time"](int(seconds), round(seconds % 1 * 1e9))


def header(seconds):
    return T["std_msgs/msg/Header"](stamp(seconds), "base")


def joint_state(seconds, names, position=NONE, effort=NONE):
    kind = T["sensor_msgs/msg/JointState"]
    return kind(header(seconds), list(names), np.array(position), NONE, np.array(effort))


def wrench(seconds, torque):
    vector = T["geometry_msgs/msg/Vector3"]
    content = T["geometry_msgs/msg/Wrench"](vector(0.0, 0.0, 0.0), vector(*map(float, torque)))
    return T["geometry_msgs/msg/WrenchStamped"](header(seconds), content)


def pose(seconds, position):
    place = T["geometry_msgs/msg/Point"](*map(float, position))
    turn = T["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
    content = T["geometry_msgs/msg/Pose"](place, turn)
    return T["geometry_msgs/msg/PoseStamped"](header(seconds), content)


def fluid_pressure(seconds, pressure):
    return T["sensor_msgs/msg/FluidPressure"](header(seconds), float(pressure), 0.0)


def number(value):
    return T["std_msgs/msg/Float64"](float(value))


def numbers(values):
    layout = T["std_msgs/msg/MultiArrayLayout"]([], 0)
    return T["std_msgs/msg/Float64MultiArray"](layout, np.array(values, float))


def clock(seconds):
    return T["rosgraph_msgs/msg/Clock"](stamp(seconds))


def ros1_joint_state(number, seconds, names, position=NONE, effort=NONE):
    types = ROS1_STORE.types
    time = types["builtin_interfaces/msg/Time"](int(seconds), round(seconds % 1 * 1e9))
    head = types["std_msgs/msg/Header"](number, time, "base")
    kind = types["sensor_msgs/msg/JointState"]
    return kind(head, list(names), np.array(position), NONE, np.array(effort))


def write_ros1_bag(path: Path, messages):
    """Write (topic, seconds of reception, message of ROS 1) to a ROS 1 bag, packed; its path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    writer = Ros1Writer(path)
    writer.set_compression(Ros1Writer.CompressionFormat.BZ2)
    with writer:
        connections = {}
        for topic, seconds, message in messages:
            kind = message.__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=ROS1_STORE)
            data = ROS1_STORE.serialize_ros1(message, kind)
            writer.write(connections[topic], WALL_START + round(seconds * 1e9), data)
    return path


def write_bag(folder: Path, messages, storage=StoragePlugin.MCAP):
    """Write (topic, seconds of reception, message); topics without messages come as (topic, type).

    Returns the folder.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    with Writer(folder, version=9, storage_plugin=storage) as writer:
        connections = {}
        for entry in messages:
            topic = entry[0]
            kind = entry[1] if len(entry) == 2 else entry[2].__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=STORE)
            if len(entry) == 3:
                data = STORE.serialize_cdr(entry[2], kind)
                writer.write(connections[topic], WALL_START + round(entry[1] * 1e9), data)
    return folder
