"""Frames of wrist and object in the world, on /tf, on machines that have tf2_msgs.

tf2_msgs comes with ROS and is not on PyPI. robot_state_publisher adds the hand's links to the
wrist, with the namespace as its frame_prefix.
"""

from __future__ import annotations

from typing import NamedTuple

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Transform, TransformStamped
from rclpy.node import Node
from rclpy.qos import QoSProfile

from pneuflex_sim.simulation import Simulation
from softhand_common.numerics.arrays import Array
from softhand_ros.topics import full_name

try:
    from tf2_msgs.msg import TFMessage
except ImportError:
    TFMessage = None

WORLD = "world"  # of all hands
TF_QUEUE_DEPTH = 100  # as tf2_ros has it
NO_TF_MESSAGE = "no tf2_msgs on this machine: /tf is not published"


class Frame(NamedTuple):
    """A frame `name` and its pose in the frame `parent`: position (3,) [m] and quaternion x, y, z,
    w.
    """

    parent: str
    name: str
    position: Array
    orientation: Array


def frames(simulation: Simulation, prefix: str) -> list[Frame]:
    """The frames of wrist and object, their names behind a prefix such as `left/`.

    Raises Diverged when the object's pose is not finite.
    """
    found = [Frame(WORLD, f"{prefix}wrist", *simulation.wrist_pose())]
    if simulation.object is not None:
        found.append(Frame(WORLD, f"{prefix}object", *simulation.object_pose()))
    return found


def stamped(frame: Frame, stamp: Time) -> TransformStamped:
    """A frame as a message."""
    transform = Transform()
    place, turn = transform.translation, transform.rotation
    place.x, place.y, place.z = map(float, frame.position)
    turn.x, turn.y, turn.z, turn.w = map(float, frame.orientation)
    message = TransformStamped(child_frame_id=frame.name, transform=transform)
    message.header.stamp, message.header.frame_id = stamp, frame.parent
    return message


class Transforms:
    """Publishes the frames of wrist and object, or logs once that tf2_msgs is missing."""

    def __init__(self, node: Node, simulation: Simulation) -> None:
        self._simulation, self._publisher = simulation, None
        self._prefix = full_name(node, "frame").removesuffix("frame")
        if TFMessage is None:
            node.get_logger().info(NO_TF_MESSAGE)
        else:
            self._publisher = node.create_publisher(
                TFMessage, "/tf", QoSProfile(depth=TF_QUEUE_DEPTH)
            )

    def publish(self, stamp: Time) -> None:
        """Publish the present poses of the hand's frames on /tf, marked with a time stamp."""
        if self._publisher is not None:
            now = [stamped(frame, stamp) for frame in frames(self._simulation, self._prefix)]
            self._publisher.publish(TFMessage(transforms=now))
