"""Commands to hold the simulator's object in front of the hand, and the name of that object."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from geometry_msgs.msg import Transform
from rclpy.duration import Duration
from rclpy.node import Node
from trajectory_msgs.msg import MultiDOFJointTrajectory, MultiDOFJointTrajectoryPoint

from grasp_strategies.ros.messages import OBJECT, read_value
from grasp_strategies.scene import Array, SceneError
from softhand_ros.topics import SECOND_NS, full_name, stamp_of_seconds

HOLD_OBJECT_TOPIC = "scene/hold_object"
OBJECT_KEY = "object"  # key in /diagnostics under which the simulator tells its object


class ObjectCommand:
    """Publisher of `scene/hold_object`; `simulator` is the simulator's name with its namespace."""

    def __init__(self, node: Node, simulator: str) -> None:
        self._publisher = node.create_publisher(MultiDOFJointTrajectory, HOLD_OBJECT_TOPIC, 10)
        self._frame, self._simulator = full_name(node, "wrist"), simulator
        self.name = ""  # of the object, as the simulator has told last

    def receive(self, report: Any) -> None:
        """Take the object's name from a DiagnosticArray of the simulator."""
        self.name = read_value(report, self._simulator, OBJECT_KEY) or self.name

    def check(self, names: Collection[str]) -> None:
        """Raise SceneError unless the object has one of these names."""
        if self.name not in names:
            raise SceneError(
                f"expected a simulator with the object {' or '.join(names)}, got one with "
                f"{self.name}: start it with that object"
            )

    def hold(self, position: Array, orientation: Array, effect: float) -> None:
        """Publish the pose at which the object is held, position (3,) [m] and quaternion (4,) in
        the wrist frame, from the time `effect` [s] on.

        Raises SceneError when nobody subscribes.
        """
        transform = Transform()
        place, turn = transform.translation, transform.rotation
        place.x, place.y, place.z = map(float, position)
        turn.x, turn.y, turn.z, turn.w = map(float, orientation)
        self._publish(MultiDOFJointTrajectoryPoint(transforms=[transform]), effect)

    def release(self, duration: float, effect: float) -> None:
        """Publish that the spring that holds the object fades within a duration [s] from the time
        `effect` [s] on; raises as `hold`.
        """
        fade = Duration(nanoseconds=round(duration * SECOND_NS)).to_msg()
        self._publish(MultiDOFJointTrajectoryPoint(time_from_start=fade), effect)

    def _publish(self, point: MultiDOFJointTrajectoryPoint, effect: float) -> None:
        if not self._publisher.get_subscription_count():
            raise SceneError(
                "expected a simulator that can hold an object in front of the hand, got no "
                f"subscriber of {self._publisher.topic_name}"
            )
        message = MultiDOFJointTrajectory(joint_names=[OBJECT], points=[point])
        message.header.stamp = stamp_of_seconds(effect)
        message.header.frame_id = self._frame
        self._publisher.publish(message)
