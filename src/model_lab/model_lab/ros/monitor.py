"""The node `monitor`: compares a hand's tip angles with the model's, live."""

from __future__ import annotations

import array
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

from builtin_interfaces.msg import Time
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState

from model_lab.live.prediction import Comparison, LivePrediction, Settling, angles_of, pressures_of
from model_lab.live.shadow import HandShadow, ShadowLimits
from model_lab.live.watch import ANGLE, PRESSURE, Limits, Watch
from model_lab.ros.interface import HELP, PARAMETERS
from model_lab.ros.shadow_topics import ShadowTopics
from softhand_model.effects.own.guard import EffectError
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model
from softhand_ros.diagnostics import REPORT_PERIOD, Diagnostics, cut
from softhand_ros.executor import RoundRobin
from softhand_ros.parameters import declare
from softhand_ros.run_node import run_node
from softhand_ros.topics import nanoseconds, stamp_of, subscribe_by_hand, take

POLL_PERIOD = 0.01  # wall time between looks at what has come [s]
QUEUED = QoSProfile(depth=10_000, reliability=ReliabilityPolicy.RELIABLE)  # between two looks


class Monitor(Node):
    """Publishes predictions and residuals with the stamps of the measured angles."""

    def __init__(self) -> None:
        super().__init__("monitor")
        value = declare(self, PARAMETERS)
        hand, model_file = load_hand(value["hand"]), value["model_file"]
        self.prediction = LivePrediction(
            hand,
            load_model(model_file or None, allow_effect_files=value["allow_effect_files"]),
            Settling(value["settle_time"], value["settle_band"]),
            value["temperature"],
        )
        limits = Limits(value["warn_above"], value["stale_after"])
        name = model_file or "gravity, the one that the hands ship with"
        self.watch = Watch(self.prediction, name, value["window"], limits)
        self._hand = hand
        self._latest: Time | None = None
        self._pressures = subscribe_by_hand(self, JointState, PRESSURE, QUEUED)
        self._angles = subscribe_by_hand(self, JointState, ANGLE, QUEUED)
        # what was queued between two looks comes out in one go
        self._predicted = self.create_publisher(JointState, "model/prediction", QUEUED)
        self._residual = self.create_publisher(JointState, "model/residual", QUEUED)
        self._shadow: ShadowTopics | None = None
        if value["shadow"]:
            bounds = ShadowLimits(value["warn_distance"], value["contact_force"])
            shadow = HandShadow(
                hand, value["hand"], self.prediction.model, bounds, value["temperature"]
            )
            self._shadow = ShadowTopics(self, QUEUED, shadow, self.prediction)
        self._diagnostics = Diagnostics(self, "monitor", "model_lab")
        self._executor = RoundRobin(self)
        self.get_logger().info(f"ready: {hand.name}, model {name}")

    def look(self) -> None:
        """Process new messages, pressures first, as angles are compared with the pressures of their
        time.
        """
        self._executor.serve(POLL_PERIOD)
        self._take_all(self._pressures, PRESSURE, self._on_pressures)
        self._take_all(self._angles, ANGLE, self._on_angles)
        if self._shadow is not None:
            self._shadow.look()

    def _take_all(
        self, queue: Any, topic: str, compare: Callable[[JointState], list[Comparison]]
    ) -> None:
        while (message := take(queue)) is not None:
            now = time.monotonic()
            try:
                compared = compare(message)
            except EffectError:
                raise  # the model's, not the message's
            except ValueError as reason:
                refused = cut(f"{topic}: {reason}")
                self.watch.refuse(refused, now)
                self.get_logger().warning(f"refused {refused}", throttle_duration_sec=1.0)
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
        return self.prediction.add_pressures(nanoseconds(message.header.stamp), pressures)

    def _on_angles(self, message: JointState) -> list[Comparison]:
        angles = angles_of(message.name, message.position, self._hand.actuator_names)
        return self.prediction.add_angles(nanoseconds(message.header.stamp), angles)

    def _publish(self, comparison: Comparison) -> None:
        self._latest = stamp_of(comparison.stamp)
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
        self._executor.serve_rest()
        reports = self.watch.reports(time.monotonic())
        if self._shadow is not None:
            reports.append(self._shadow.report())
        self._diagnostics.publish(reports, self._latest)

    def close(self) -> None:
        """End the node."""
        self._executor.close()
        self.destroy_node()


def run(node: Monitor, stop: threading.Event) -> None:
    """Compare and report until `stop` is set."""
    told = 0.0
    while not stop.wait(POLL_PERIOD):
        node.look()
        if time.monotonic() - told >= REPORT_PERIOD:
            told = time.monotonic()
            node.report()


def main(args: list[str] | None = None) -> int:
    """Run the node; the exit status is that of `run_node`."""
    return run_node("monitor", Monitor, run, usage=HELP, args=args)


if __name__ == "__main__":
    sys.exit(main())
