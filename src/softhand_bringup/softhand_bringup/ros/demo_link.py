"""The demo's own ROS side: wait for the suite, call the grasp, watch its phases and its result."""

from __future__ import annotations

import time
from collections.abc import Callable

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from std_srvs.srv import Trigger

RECORDER = "recorder"
# Before these are recorded, a grasp would leave a bag with holes.
AWAITED_TOPICS = (
    "/clock",
    "/pneumaticbox/sensors",
    "/pneumaticbox/valves",
    "/pneumaticbox/state",
    "/hand/joint_states",
    "/scene/object_pose",
    "/wrist/pose",
    "/grasp/phase",
    "/grasp/result",
)
AWAITED_COMMANDS = ("/pneumaticbox/command", "/wrist/target_pose")


class GraspClient:
    """Calls a grasp service and follows it. A context manager; use it from one thread.

    Args:
        service: name of the grasp service.
        on_phase: called with (simulated time [s], name) when a phase begins.
    """

    def __init__(self, service: str, on_phase: Callable[[float, str], None]) -> None:
        self._context = Context()
        rclpy.init(context=self._context, signal_handler_options=SignalHandlerOptions.NO)
        self._node = Node(
            "demo", context=self._context, enable_rosout=False, start_parameter_services=False
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._grasp = self._node.create_client(Trigger, service)
        self._future: Future = Future()
        self._on_phase = on_phase
        self.simulated_time = 0.0
        self.result: dict[str, str] = {}
        node = self._node
        node.create_subscription(Clock, "/clock", self._clock_ticked, 10)
        node.create_subscription(String, "grasp/phase", self._phase_began, 10)
        node.create_subscription(DiagnosticArray, "grasp/result", self._result_came, 10)

    def __enter__(self) -> GraspClient:
        return self

    def __exit__(self, *_: object) -> None:
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.try_shutdown(context=self._context)

    def missing(self, recorded: bool) -> list[str]:
        """What is not there yet before a grasp can be called, in words.

        Args:
            recorded: whether a recorder must have subscribed to all topics too.
        """
        self._spin(0.1)
        missing = [t for t in AWAITED_TOPICS if not self._node.count_publishers(t)]
        missing += [t for t in AWAITED_COMMANDS if not self._node.count_subscribers(t)]
        if self.simulated_time == 0.0:
            missing.append("a tick of /clock")
        if not self._grasp.service_is_ready():
            missing.append(f"service {self._grasp.srv_name}")
        if recorded:
            topics = AWAITED_TOPICS + AWAITED_COMMANDS
            missing += [f"recording of {t}" for t in topics if not self._is_recorded(t)]
        return missing

    def call(self) -> None:
        """Call the service."""
        self.result = {}
        self._future = self._grasp.call_async(Trigger.Request())

    def answer(self) -> Trigger.Response | None:
        """The service's answer, or None after a tenth of a second without one."""
        done = self._future.done()
        self._spin(0.1)  # also after the answer: the result may come behind it
        return self._future.result() if done else None

    def _is_recorded(self, topic: str) -> bool:
        subscribers = self._node.get_subscriptions_info_by_topic(topic)
        return any(info.node_name == RECORDER for info in subscribers)

    def _spin(self, duration: float) -> None:
        end = time.monotonic() + duration
        while (left := end - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def _clock_ticked(self, message: Clock) -> None:
        self.simulated_time = message.clock.sec + 1e-9 * message.clock.nanosec

    def _phase_began(self, message: String) -> None:
        self._on_phase(self.simulated_time, message.data)

    def _result_came(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self.result.update({pair.key: pair.value for pair in status.values})
