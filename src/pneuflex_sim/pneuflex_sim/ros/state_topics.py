"""State of hand, wrist and object as topics. Messages that are sent often are allocated once.

Topics without subscribers are not computed.
"""

from __future__ import annotations

import array

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Pose, PoseArray, PoseStamped, WrenchStamped
from rclpy.node import Node
from sensor_msgs.msg import JointState

from pneuflex_sim.simulation import Simulation
from pneuflex_sim.urdf import joint_names, joint_positions
from softhand_ros.topics import EACH_STEP, full_name, has_subscribers

WORLD = "world"


class StateTopics:
    """Publishes the state of one simulation.

    Args:
        node: the node that publishes.
        simulation: the simulation whose state is published.
    """

    def __init__(self, node: Node, simulation: Simulation) -> None:
        self._simulation = simulation
        make, self._wrist_frame = node.create_publisher, full_name(node, "wrist")
        self._joints = make(JointState, "hand/joint_states", EACH_STEP)
        self._fingertips = make(PoseArray, "hand/fingertips", EACH_STEP)
        self._tip_angles = make(JointState, "hand/tip_angles", EACH_STEP)
        self._wrench = make(WrenchStamped, "wrist/wrench", EACH_STEP)
        self._wrist_pose = make(PoseStamped, "wrist/pose", EACH_STEP)
        self._object_pose = make(PoseStamped, "scene/object_pose", EACH_STEP)
        self._joint_message = JointState(name=joint_names(simulation.bodies.layout))
        self._joint_message.header.frame_id = self._wrist_frame
        self._wrist_message, self._object_message = PoseStamped(), PoseStamped()
        self._wrist_message.header.frame_id = self._object_message.header.frame_id = WORLD
        self._wrench_message = WrenchStamped()
        self._wrench_message.header.frame_id = WORLD

    def publish_fast(self, stamp: Time) -> None:
        """Publish the poses of wrist and object, which a strategy follows."""
        simulation = self._simulation
        if has_subscribers(self._wrist_pose):
            self._wrist_message.header.stamp = stamp
            _fill_pose(self._wrist_message.pose, *simulation.wrist_pose())
            self._wrist_pose.publish(self._wrist_message)
        if simulation.object is not None and has_subscribers(self._object_pose):
            self._object_message.header.stamp = stamp
            _fill_pose(self._object_message.pose, *simulation.object_pose())
            self._object_pose.publish(self._object_message)

    def publish_wrench(self, stamp: Time) -> None:
        """Publish force and torque of the hand on the wrist."""
        if not has_subscribers(self._wrench):
            return
        self._wrench_message.header.stamp = stamp
        force, torque = self._simulation.wrist_wrench()
        wrench = self._wrench_message.wrench
        wrench.force.x, wrench.force.y, wrench.force.z = force.tolist()
        wrench.torque.x, wrench.torque.y, wrench.torque.z = torque.tolist()
        self._wrench.publish(self._wrench_message)

    def publish_joints(self, stamp: Time) -> None:
        """Publish joints and tips of the hand."""
        if has_subscribers(self._joints):
            message, q = self._joint_message, self._simulation.bodies.q
            message.header.stamp = stamp
            message.position = array.array("d", joint_positions(q).tolist())
            self._joints.publish(message)
        if has_subscribers(self._tip_angles):
            angles = self._simulation.read_tip_angles()
            tips = JointState(name=list(angles), position=array.array("d", angles.values()))
            tips.header.stamp = stamp
            self._tip_angles.publish(tips)
        if has_subscribers(self._fingertips):
            tip_poses = self._simulation.fingertips().values()
            poses = PoseArray(poses=[_fill_pose(Pose(), *tip) for tip in tip_poses])
            poses.header.stamp, poses.header.frame_id = stamp, self._wrist_frame
            self._fingertips.publish(poses)


def _fill_pose(pose: Pose, position: np.ndarray, orientation: np.ndarray) -> Pose:
    place, turn = pose.position, pose.orientation
    place.x, place.y, place.z = position.tolist()
    turn.x, turn.y, turn.z, turn.w = orientation.tolist()
    return pose
