"""Topics of the monitor's shadow: what it hears of a hand, and the fingertips it predicts."""

from __future__ import annotations

from typing import Any

import numpy as np
from geometry_msgs.msg import Pose, PoseArray, PoseStamped, WrenchStamped
from rclpy.node import Node
from rclpy.qos import QoSProfile

from model_lab.aliases import Array
from model_lab.live.prediction import LivePrediction
from model_lab.live.shadow import HandShadow, Seen
from softhand_common.status import Level, Report
from softhand_ros.topics import nanoseconds, subscribe_by_hand, take

TIPS_TOPIC, HELD_TOPIC, WRENCH_TOPIC = "hand/fingertips", "wrist/pose", "wrist/wrench"
WAITING = "waiting for"


class ShadowTopics:
    """Keeps the latest message of each topic, and compares measured with predicted fingertips when
    asked.
    """

    def __init__(
        self, node: Node, qos: QoSProfile, shadow: HandShadow, prediction: LivePrediction
    ) -> None:
        self._shadow, self._prediction = shadow, prediction
        kinds = {TIPS_TOPIC: PoseArray, HELD_TOPIC: PoseStamped, WRENCH_TOPIC: WrenchStamped}
        self._queues = {t: subscribe_by_hand(node, kind, t, qos) for t, kind in kinds.items()}
        self._latest: dict[str, Any] = {}
        self._predicted = node.create_publisher(PoseArray, "model/fingertips", qos)

    def look(self) -> None:
        """Fetch the messages that have come."""
        for topic, queue in self._queues.items():
            while (message := take(queue)) is not None:
                self._latest[topic] = message

    def report(self) -> Report:
        """Compare, publish the predicted fingertips, and return a report on what the difference
        means.
        """
        missing = [topic for topic in (TIPS_TOPIC, HELD_TOPIC) if topic not in self._latest]
        if missing:
            return Report("shadow", Level.STALE, f"{WAITING} {' and '.join(missing)}")
        message = self._latest.pop(TIPS_TOPIC)  # each is compared once
        known = self._prediction.pressures_at(nanoseconds(message.header.stamp))
        if known is None:
            return Report("shadow", Level.STALE, f"{WAITING} pressures of the fingertips' time")
        try:
            seen = self._seen(message, *known)
            predicted = self._shadow.fingertips(seen.pressures, seen.orientation)
        except ValueError as reason:
            return Report("shadow", Level.WARN, f"refused {reason}")
        except RuntimeError as reason:
            return Report("shadow", Level.ERROR, str(reason))
        poses = PoseArray(header=message.header)
        for place in predicted.tolist():
            pose = Pose()
            pose.position.x, pose.position.y, pose.position.z = place
            poses.poses.append(pose)
        self._predicted.publish(poses)
        return self._shadow.report(seen, predicted)

    def _seen(self, message: PoseArray, pressures: Array, stood: bool) -> Seen:
        names = self._shadow.names
        if len(message.poses) != len(names):
            raise ValueError(
                f"{TIPS_TOPIC}: poses: expected {len(names)} ({', '.join(names)}), "
                f"got {len(message.poses)}"
            )
        at = [(p.position.x, p.position.y, p.position.z) for p in message.poses]
        turn = self._latest[HELD_TOPIC].pose.orientation
        orientation = np.array([turn.x, turn.y, turn.z, turn.w])
        if not (np.isfinite(at).all() and np.isfinite(orientation).all() and orientation.any()):
            raise ValueError(
                f"{TIPS_TOPIC}, {HELD_TOPIC}: expected finite numbers and a quaternion, got "
                "NaN, infinity or a quaternion of zero length"
            )
        wrench = self._latest.get(WRENCH_TOPIC)
        force = None
        if wrench is not None:
            force = np.array([wrench.wrench.force.x, wrench.wrench.force.y, wrench.wrench.force.z])
        return Seen(pressures, stood, np.array(at), orientation, force)
