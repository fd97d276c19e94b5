"""The ROS side of a program that plays something on the bench: clock, air, services."""

from __future__ import annotations

import math
import time
from collections.abc import Collection, Sequence
from typing import Any, Self

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from softhand_bringup.processes.waiting import RunFailed

RECORDER = "recorder"
COMMAND = "/pneumaticbox/command"
VENT, RESET, TARE = "/pneumaticbox/vent", "/pneumaticbox/reset", "/pneumaticbox/tare"
ANSWER_LIMIT = 5.0  # wall time after which a service is asked again: an answer can get lost [s]
ASKED = 3  # times


class BenchLink:
    """Commands the pneumatic box. A context manager; use it from one thread.

    Args:
        name: of the node.
        channel: that is commanded.
        recorded: topics that the recorder must have found before anything is commanded.
    """

    def __init__(self, name: str, channel: str, recorded: Collection[str]) -> None:
        self.channel, self._recorded = channel, recorded
        self._context = Context()
        rclpy.init(context=self._context, signal_handler_options=SignalHandlerOptions.NO)
        self.node = Node(
            name, context=self._context, enable_rosout=False, start_parameter_services=False
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._commands = self.node.create_publisher(JointTrajectory, COMMAND, 10)
        self.services: dict[str, Any] = {
            name: self.node.create_client(Trigger, name) for name in (VENT, RESET, TARE)
        }
        self.simulated_time = 0.0
        self.told: dict[str, str] = {}  # latest message of every diagnostic status
        self.node.create_subscription(Clock, "/clock", self._clock_ticked, 10)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._diagnosed, 10)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self._context)

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
        return missing + [f"recording of {t}" for t in self._recorded if not self._is_recorded(t)]

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

    def spin(self, duration: float) -> None:
        """Listen for so much wall time [s]."""
        end = time.monotonic() + duration
        while (left := end - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def call(self, service: str, request: Any) -> Any:
        """Answer of a service; RunFailed when it does not answer."""
        for _ in range(ASKED):
            future = self.services[service].call_async(request)
            end = time.monotonic() + ANSWER_LIMIT
            while not future.done() and time.monotonic() < end:
                self.spin(0.02)
            if future.done():
                return future.result()
        raise RunFailed(f"{service}: no answer after {ASKED * ANSWER_LIMIT:.0f} s")

    def _demand(self, service: str) -> None:
        answer = self.call(service, Trigger.Request())
        if not answer.success:
            raise RunFailed(f"{service}: {answer.message}")

    def _is_recorded(self, topic: str) -> bool:
        subscribers = self.node.get_subscriptions_info_by_topic(topic)
        return any(info.node_name == RECORDER for info in subscribers)

    def _clock_ticked(self, message: Clock) -> None:
        self.simulated_time = message.clock.sec + 1e-9 * message.clock.nanosec

    def _diagnosed(self, message: DiagnosticArray) -> None:
        self.told.update({status.name: status.message for status in message.status})
