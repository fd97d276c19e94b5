"""The node `monitor`: compares a hand's tip angles with the model's, live.

The node `monitor`: compares a hand's tip angles with the model's, live.
"""

from __future__ import annotations

import array
import signal
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from types import FrameType
from typing import Any

import rclpy
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.callback_groups import CallbackGroup
from rclpy.exceptions import ParameterException
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState

from model_lab.live.prediction import Comparison, LivePrediction, Settling, angles_of, pressures_of
from model_lab.live.watch import ANGLE, PRESSURE, Limits, Report, Watch
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model


@dataclass(frozen=True)
class Parameter:
    """One node parameter; `bounds` are the least and the greatest value, None for no range."""

    name: str
    default: float | str
    text: str
    bounds: tuple[float, float] | None = None


PARAMETERS = (
    Parameter("hand", "rbo_hand_2", "hand by name or path of its YAML"),
    Parameter("model_file", "", "softhand-model/1 file; empty: actuators with their weight"),
    Parameter("temperature", 293.15, "of the rubber [K]", (200.0, 500.0)),
    Parameter("window", 5.0, "measured time over which the residual is averaged [s]", (0.1, 600.0)),
    Parameter("warn_above", 0.05, "rms residual that is worth a warning [rad]", (0.0, 10.0)),
    Parameter("stale_after", 2.0, "wall time without a comparison that is stale [s]", (0.1, 600.0)),
    Parameter(
        "settle_time",
        0.1,
        "for which the pressure must have stood for a sample to count [s]; 0: all count",
        (0.0, 4.0),
    ),
    Parameter("settle_band", 1000.0, "within which a pressure counts as standing [Pa]", (0.0, 1e5)),
)


POLL_PERIOD = 0.01  # wall time between looks at what has come [s]
REPORT_PERIOD = 1.0  # wall time between diagnostics (REP-107) [s]
RELIABLE = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
QUEUED = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)  # between two looks
NANOSECONDS = 10**9


class TakenByHand(CallbackGroup):
    """Subscriptions whose queues are emptied by their owner; executors leave them alone.

    Pressures come some hundred times a second: taken one by one through an executor they would cost
    more than the prediction itself.
    """

    def can_execute(self, entity: Any) -> bool:
        """Never for an executor."""
        return False

    def beginning_execution(self, entity: Any) -> bool:
        """Never for an executor."""
        return False


def _ignore(_: Any) -> None:
    """Callback of subscriptions whose messages are taken by hand."""


def _descriptor(parameter: Parameter) -> ParameterDescriptor:
    descriptor = ParameterDescriptor(description=parameter.text, read_only=True)
    if parameter.bounds:
        low, high = parameter.bounds
        descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
    return descriptor


def _nanoseconds(stamp: Time) -> int:
    return stamp.sec * NANOSECONDS + stamp.nanosec


def _stamp(nanoseconds: int) -> Time:
    return Time(sec=nanoseconds // NANOSECONDS, nanosec=nanoseconds % NANOSECONDS)


class Monitor(Node):
    """Publishes predictions and residuals with the stamps of the measured angles."""

    def __init__(self) -> None:
        super().__init__("monitor")
        for parameter in PARAMETERS:
            self.declare_parameter(parameter.name, parameter.default, _descriptor(parameter))
        value = self._value
        hand, model_file = load_hand(value("hand")), value("model_file")
        self.prediction = LivePrediction(
            hand,
            load_model(model_file or None),
            Settling(value("settle_time"), value("settle_band")),
            value("temperature"),
        )
        limits = Limits(value("warn_above"), value("stale_after"))
        name = model_file or "gravity, the one that the hands ship with"
        self.watch = Watch(self.prediction, name, value("window"), limits)
        self._hand = hand
        self._latest: Time | None = None
        self._pressures, self._angles = self._listen(PRESSURE), self._listen(ANGLE)
        self._predicted = self.create_publisher(JointState, "model/prediction", RELIABLE)
        self._residual = self.create_publisher(JointState, "model/residual", RELIABLE)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", RELIABLE)

    def _value(self, name: str) -> Any:
        return self.get_parameter(name).value

    def _listen(self, topic: str) -> Any:
        return self.create_subscription(
            JointState, topic, _ignore, QUEUED, callback_group=TakenByHand()
        )

    def take_messages(self) -> None:
        """Take what has come, pressures first: the angles wait for theirs."""
        self._take_all(self._pressures, PRESSURE, self._on_pressures)
        self._take_all(self._angles, ANGLE, self._on_angles)

    def _take_all(
        self, queue: Any, topic: str, take: Callable[[JointState], list[Comparison]]
    ) -> None:
        while (taken := queue.handle.take_message(JointState, False)) is not None:
            now = time.monotonic()
            try:
                compared = take(taken[0])
            except ValueError as reason:
                self.watch.refuse(f"{topic}: {reason}", now)
                self.get_logger().warning(f"refused {topic}: {reason}", throttle_duration_sec=1.0)
                continue
            except RuntimeError as reason:
                self.prediction.reset()
                self.watch.fail(str(reason), now)
                continue
            self.watch.heard(topic, now)
            for comparison in compared:
                self.watch.take(comparison, now)
                self._publish(comparison)

    def _on_pressures(self, message: JointState) -> list[Comparison]:
        pressures = pressures_of(message.name, message.effort, self._hand.channels)
        return self.prediction.add_pressures(_nanoseconds(message.header.stamp), pressures)

    def _on_angles(self, message: JointState) -> list[Comparison]:
        angles = angles_of(message.name, message.position, self._hand.actuator_names)
        return self.prediction.add_angles(_nanoseconds(message.header.stamp), angles)

    def _publish(self, comparison: Comparison) -> None:
        self._latest = _stamp(comparison.stamp)
        names = list(comparison.names)
        for publisher, values in (
            (self._predicted, comparison.predicted),
            (self._residual, comparison.residual),
        ):
            message = JointState(name=names, position=array.array("d", values.tolist()))
            message.header.stamp = self._latest
            publisher.publish(message)

    def report(self) -> None:
        """Publish the diagnostics, with the stamp of the latest comparison if there is one."""
        message = DiagnosticArray()
        message.header.stamp = self._latest or self.get_clock().now().to_msg()
        message.status = [_status(report) for report in self.watch.reports(time.monotonic())]
        self._diagnostics.publish(message)


def _status(report: Report) -> DiagnosticStatus:
    return DiagnosticStatus(
        level=bytes([report.level]),
        name=f"monitor: {report.name}",
        message=report.message,
        hardware_id="model_lab",
        values=[KeyValue(key=key, value=value) for key, value in report.values.items()],
    )


def run(node: Monitor, stop: threading.Event) -> None:
    """Compare and report until `stop`."""
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    told = 0.0
    try:
        while not stop.wait(POLL_PERIOD):
            executor.spin_once(timeout_sec=0)
            node.take_messages()
            if time.monotonic() - told >= REPORT_PERIOD:
                told = time.monotonic()
                node.report()
    finally:
        executor.shutdown()


def main(args: list[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM: 0 then, 2 for parameters that cannot be used."""
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    stop = threading.Event()

    def end(_: int, __: FrameType | None) -> None:
        stop.set()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)
    node, status = None, 0
    try:
        node = Monitor()
        run(node, stop)
    except (ValueError, ParameterException) as error:
        print(f"monitor: {error}", file=sys.stderr)
        status = 2
    finally:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return status


if __name__ == "__main__":
    sys.exit(main())
