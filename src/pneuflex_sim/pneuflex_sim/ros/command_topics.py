"""Commands to a simulation other than valve commands: the target pose of the wrist, and holding the
object in front of the hand.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from trajectory_msgs.msg import MultiDOFJointTrajectory

from pneuflex_sim.ros.lockstep import StampedCommands
from pneuflex_sim.scene.contacts import OBJECT
from pneuflex_sim.simulation import Simulation
from softhand_common.numerics.arrays import Array
from softhand_ros.topics import full_name, seconds

WORLD, WRIST_FRAME = "world", "wrist"
TARGET_TOPIC, HOLD_TOPIC = "wrist/target_pose", "scene/hold_object"


class CommandTopics:
    """Applies `wrist/target_pose` and `scene/hold_object`, each message at its stamp.

    A message of `scene/hold_object` has one point. With a transform, the object is put at that pose
    in the wrist frame, and a spring holds it; without one, the spring fades within
    `time_from_start`.

    Args:
        node: the node that subscribes.
        simulation: the simulation that is commanded.
        refuse: called with the reason when a message cannot be used.
    """

    def __init__(self, node: Node, simulation: Simulation, refuse: Callable[[str], None]) -> None:
        self._simulation = simulation
        self._wrist_frames = ("", WRIST_FRAME, full_name(node, WRIST_FRAME))
        self._topics = (
            StampedCommands(node, PoseStamped, TARGET_TOPIC, self._move_wrist, refuse),
            StampedCommands(node, MultiDOFJointTrajectory, HOLD_TOPIC, self._hold, refuse),
        )

    def forget(self) -> None:
        """Drop the commands that have not taken effect yet."""
        for topic in self._topics:
            topic.forget()

    def obey(self, now: float, look: bool = True) -> None:
        """Receive messages, if `look`, and apply all commands with stamps up to `now` [s]."""
        for topic in self._topics:
            topic.obey(now, look)

    def _move_wrist(self, message: PoseStamped) -> None:
        _check_frame(message.header.frame_id, ("", WORLD))
        p, o = message.pose.position, message.pose.orientation
        self._simulation.command_wrist(_vector(p), _quaternion(o))

    def _hold(self, message: MultiDOFJointTrajectory) -> None:
        _check_frame(message.header.frame_id, self._wrist_frames)
        if list(message.joint_names) != [OBJECT] or len(message.points) != 1:
            got = f"{list(message.joint_names)} with {len(message.points)} points"
            raise ValueError(f"joint_names: expected [{OBJECT}] with one point, got {got}")
        point = message.points[0]
        if len(point.transforms) > 1:
            count = len(point.transforms)
            raise ValueError(
                f"points.transforms: expected one, or none to release the object, got {count}"
            )
        for pose in point.transforms:
            self._simulation.hold_object(_vector(pose.translation), _quaternion(pose.rotation))
        if not point.transforms:
            fade = seconds(point.time_from_start)
            if fade < 0:
                raise ValueError(f"points.time_from_start: expected 0 s or more, got {fade} s")
            self._simulation.release_object(fade)


def _check_frame(frame: str, known: tuple[str, ...]) -> None:
    if frame not in known:
        raise ValueError(f"header.frame_id: expected {known[-1]}, got {frame}")


def _vector(place: object) -> Array:
    return np.array([getattr(place, axis) for axis in "xyz"])


def _quaternion(turn: object) -> Array:
    return np.array([getattr(turn, axis) for axis in "xyzw"])
