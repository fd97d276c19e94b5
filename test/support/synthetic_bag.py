"""A bag as a grasp would leave it, written without any node."""

import numpy as np
from rosbags.typesys import Stores, get_typestore

from softhand_bringup.bags.writing import BagWriter

STORE = get_typestore(Stores.ROS2_JAZZY)
T = STORE.types
WALL_START = 1_700_000_000_000_000_000  # [ns]
SPEED = 2.0  # simulated over wall time
EMPTY = np.array([])


def stamp(seconds):
    return T["builtin_interfaces/msg/Time"](int(seconds), round(seconds % 1 * 1e9))


def header(seconds, frame="world"):
    return T["std_msgs/msg/Header"](stamp(seconds), frame)


def joint_state(seconds, names, position=EMPTY, effort=EMPTY):
    kind = T["sensor_msgs/msg/JointState"]
    return kind(header(seconds), list(names), np.array(position), EMPTY, np.array(effort))


def pose(seconds, position):
    place = T["geometry_msgs/msg/Point"](*map(float, position))
    turn = T["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
    kind = T["geometry_msgs/msg/PoseStamped"]
    return kind(header(seconds), T["geometry_msgs/msg/Pose"](place, turn))


def command(seconds, names, masses, after):
    point = T["trajectory_msgs/msg/JointTrajectoryPoint"](
        np.array(masses), EMPTY, EMPTY, EMPTY,
        T["builtin_interfaces/msg/Duration"](int(after), round(after % 1 * 1e9)),
    )  # fmt: skip
    kind = T["trajectory_msgs/msg/JointTrajectory"]
    return kind(header(seconds), list(names), [point])


class SyntheticBag:
    """Writes messages at simulated times; /clock ties these to the stamps of reception."""

    def __init__(self, folder):
        self._bag = BagWriter(folder)
        self._topics = {}

    def write(self, topic, seconds, message):
        kind = message.__msgtype__
        if topic not in self._topics:
            self._topics[topic] = self._bag.add_topic(topic, kind, [])
        received = WALL_START + round(seconds / SPEED * 1e9)
        data = bytes(STORE.serialize_cdr(message, kind))
        self._bag.write(self._topics[topic], received, received, data)

    def tick(self, seconds):
        self.write("/clock", seconds, T["rosgraph_msgs/msg/Clock"](stamp(seconds)))

    def say(self, topic, seconds, text):
        self.write(topic, seconds, T["std_msgs/msg/String"](text))

    def close(self):
        self._bag.close()
