"""Client of the simulated rig: its clock, commands of air mass, services of the driver."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from softhand_bringup.lab_story.measuring import RESIDUAL
from softhand_bringup.processes.suite import RECORDER
from softhand_bringup.processes.waiting import RunFailed
from softhand_ros.client_link import ClientLink
from softhand_ros.topics import seconds

COMMAND_NAME = "/pneumaticbox/command"
VENT_SERVICE, RESET_SERVICE, TARE_SERVICE = (
    "/pneumaticbox/vent",
    "/pneumaticbox/reset",
    "/pneumaticbox/tare",
)
ANSWER_LIMIT = 5.0  # wall time after which a service is called again: answers can get lost [s]
CALL_ATTEMPTS = 3


class RigLink(ClientLink):
    """Commands the pneumatic box. A context manager, for use from a single thread.

    Args:
        name: name of its node.
        channel: channel that is commanded.
        recorded: topics to which the recorder must subscribe before the first command.
        domain, enclave: ROS domain and enclave of the nodes.
    """

    def __init__(
        self, name: str, channel: str, recorded: Collection[str], domain: int, enclave: str
    ) -> None:
        super().__init__(name, domain, enclave=enclave)
        self.channel, self._recorded = channel, recorded
        self._commands = self.node.create_publisher(JointTrajectory, COMMAND_NAME, 10)
        self.services: dict[str, Any] = {
            name: self.client(Trigger, name) for name in (VENT_SERVICE, RESET_SERVICE, TARE_SERVICE)
        }
        self.statuses: dict[str, str] = {}  # latest message of every diagnostic status
        self.subscribe_clock()
        self.monitored_time = 0.0  # stamp of the monitor's latest residual [s]
        self.listen(DiagnosticArray, "/diagnostics", self._diagnosed)
        self.listen(JointState, RESIDUAL, self._monitored)

    def missing(self) -> list[str]:
        """What is still missing before the first command, in words."""
        self.spin(0.1)
        missing = [] if self.simulated_time > 0.0 else ["a tick of /clock"]
        if not self._commands.get_subscription_count():
            missing.append(f"a subscriber of {COMMAND_NAME}")
        missing += [
            f"service {name}"
            for name, client in self.services.items()
            if not client.service_is_ready()
        ]
        unheard = [t for t in self._recorded if not self.is_subscribed(RECORDER, t)]
        return missing + [f"recording of {topic}" for topic in unheard]

    def simulators(self) -> int:
        """Number of simulators in this ROS domain."""
        return int(self.node.count_publishers("/clock"))

    def command(self, setpoints: Sequence[tuple[float, float]]) -> None:
        """Command pairs of (time from now [s], air mass [kg above rest]), interpolated linearly."""
        points = []
        for after, mass in setpoints:
            point = JointTrajectoryPoint(positions=[mass])
            point.time_from_start.sec = math.floor(after)
            point.time_from_start.nanosec = round(after % 1.0 * 1e9)
            points.append(point)
        self._commands.publish(JointTrajectory(joint_names=[self.channel], points=points))

    def vent(self) -> None:
        """Open the outlets until `reset`; raises RunFailed as `reset` does."""
        self._demand(VENT_SERVICE)

    def reset(self) -> None:
        """Close the outlets.

        Raises:
            RunFailed: the driver refuses or does not answer; the message says why.
        """
        self._demand(RESET_SERVICE)

    def tare(self) -> bool:
        """Set the current air mass to zero; False while the pressure is not constant yet."""
        return bool(self.call(TARE_SERVICE, Trigger.Request()).success)

    def call(self, service: str, request: Any) -> Any:
        """Answer of a service; raises RunFailed when it does not answer."""
        for _ in range(CALL_ATTEMPTS):
            answer = self.ask(self.services[service], request, ANSWER_LIMIT)
            if answer is not None:
                return answer
        raise RunFailed(f"{service}: no answer after {CALL_ATTEMPTS * ANSWER_LIMIT:.0f} s")

    def _demand(self, service: str) -> None:
        answer = self.call(service, Trigger.Request())
        if not answer.success:
            raise RunFailed(f"{service}: {answer.message}")

    def _monitored(self, message: JointState) -> None:
        self.monitored_time = seconds(message.header.stamp)

    def _diagnosed(self, message: DiagnosticArray) -> None:
        self.statuses.update({status.name: status.message for status in message.status})
