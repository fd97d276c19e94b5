"""ROS side of the pushes: the height of the wrist, and the controller of the channel."""

from __future__ import annotations

import math
from collections.abc import Collection

from geometry_msgs.msg import PoseStamped
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters

from softhand_bringup.processes.waiting import RunFailed
from softhand_bringup.ros.rig_link import RigLink

SET_PARAMETERS = "/pneumaticbox/set_parameters"
TARGET = "/wrist/target_pose"


class PressRig(RigLink):
    """A level finger, palm down, over a table. A context manager; use it from one thread.

    Args:
        channel: that is commanded.
        recorded: topics that the recorder must have found before anything is commanded.
        domain, enclave: of ROS, as the nodes have them.
    """

    def __init__(self, channel: str, recorded: Collection[str], domain: int, enclave: str) -> None:
        super().__init__("equilibrium", channel, recorded, domain, enclave)
        self._targets = self.node.create_publisher(PoseStamped, TARGET, 10)
        self.services[SET_PARAMETERS] = self.node.create_client(SetParameters, SET_PARAMETERS)

    def control(self, mode: str) -> None:
        """Switch the channel to another controller.

        Raises:
            RunFailed: the driver refuses, or does not answer; the message says why.
        """
        value = ParameterValue(type=ParameterType.PARAMETER_STRING_ARRAY, string_array_value=[mode])
        request = SetParameters.Request(parameters=[Parameter(name="control_mode", value=value)])
        (result,) = self.call(SET_PARAMETERS, request).results
        if not result.successful:
            raise RunFailed(f"control_mode {mode}: {result.reason}")

    def hold_at(self, height: float) -> None:
        """Command the height of the wrist over the table [m]."""
        target = PoseStamped()
        target.header.frame_id = "world"
        target.pose.position.z = height
        # level, palm down: a quarter turn about y
        target.pose.orientation.y = target.pose.orientation.w = math.sqrt(0.5)
        self._targets.publish(target)
