"""Link to the simulated bench: its clock, commands of air mass, services of the driver."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from softhand_bringup.processes.suite import RECORDER
from softhand_bringup.processes.waiting import RunFailed
from softhand_ros.client_link import ClientLink

COMMAND = "/pneumaticbox/command"
VENT, RESET, TARE = "/pneumaticbox/vent", "/pneumaticbox/reset", "/pneumaticbox/tare"
ANSWER_LIMIT = 5.0  # wall time after which a service is asked again: an answer can get lost [s]
ASKED = 3  # times


class BenchLink(ClientLink):
    """Commands the pneumatic box. A context manager; use it from one thread.

    Args:
        name: of the node.
        channel: that is commanded.
        recorded: topics that the recorder must have found before anything is commanded.
    """

    def __init__(self, name: str, channel: str, recorded: Collection[str]) -> None:
        super().__init__(name)
        self.channel, self._recorded = channel, recorded
        self._commands = self.node.create_publisher(JointTrajectory, COMMAND, 10)
        self.services: dict[str, Any] = {
            name: self.node.create_client(Trigger, name) for name in (VENT, RESET, TARE)
        }
        self.told: dict[str, str] = {}  # latest message of every diagnostic status
        self.hear_clock()
        self.listen(DiagnosticArray, "/diagnostics", self._diagnosed)

    def missing(self) -> list[str]:
        """What is not there yet before the first command, in words."""
        self.spin(0.1)
        missing = [] if self.simulated_time > 0.0 else ["a tick of /clock"]
        if not self._commands.get_subscription_count():
            missing.append(f"a subscriber of {COMMAND}")
        missing += [
            f"service {name}"
            for name, client in self.services.items()
            if not client.service_is_ready()
        ]
        unheard = [t for t in self._recorded if not self.is_heard_by(t, RECORDER)]
        return missing + [f"recording of {topic}" for topic in unheard]

    def simulators(self) -> int:
        """How many there are in this ROS domain."""
        return int(self.node.count_publishers("/clock"))

    def command(self, course: Sequence[tuple[float, float]]) -> None:
        """Command air masses [kg above rest] at times [s] from now, straight lines between."""
        points = []
        for after, mass in course:
            point = JointTrajectoryPoint(positions=[mass])
            point.time_from_start.sec = math.floor(after)
            point.time_from_start.nanosec = round(after % 1.0 * 1e9)
            points.append(point)
        self._commands.publish(JointTrajectory(joint_names=[self.channel], points=points))

    def vent(self) -> None:
        """Open the outlets until `reset`; RunFailed as there."""
        self._demand(VENT)

    def reset(self) -> None:
        """Close the outlets.

        Raises:
            RunFailed: the driver refuses, or does not answer; the message says why.
        """
        self._demand(RESET)

    def tare(self) -> bool:
        """Let air masses count from here; False when the pressure does not stand still yet."""
        return bool(self.call(TARE, Trigger.Request()).success)

    def call(self, service: str, request: Any) -> Any:
        """Answer of a service; RunFailed when it does not answer."""
        for _ in range(ASKED):
            answer = self.ask(self.services[service], request, ANSWER_LIMIT)
            if answer is not None:
                return answer
        raise RunFailed(f"{service}: no answer after {ASKED * ANSWER_LIMIT:.0f} s")

    def _demand(self, service: str) -> None:
        answer = self.call(service, Trigger.Request())
        if not answer.success:
            raise RunFailed(f"{service}: {answer.message}")

    def _diagnosed(self, message: DiagnosticArray) -> None:
        self.told.update({status.name: status.message for status in message.status})
