"""Takes `pneumaticbox/command` and `pneumaticbox/valve_schedule` for the box."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory

from pneumaticbox_driver.backends.topic.node import RELIABLE
from pneumaticbox_driver.command_traffic import CommandTraffic
from pneumaticbox_driver.commands import TrajectoryPoint

COMMAND, SCHEDULE = "pneumaticbox/command", "pneumaticbox/valve_schedule"


def _points(message: JointTrajectory) -> list[TrajectoryPoint]:
    return [
        TrajectoryPoint(
            point.time_from_start.sec + 1e-9 * point.time_from_start.nanosec,
            point.positions,
            point.velocities,
            point.effort,
        )
        for point in message.points
    ]


class Commands:
    """The two topics on which others say what the box shall do.

    Args:
        node: whose topics they are.
        obey: what takes a message's names, points, stamp [s] and the present time [s], by topic.
        now: present time of the box [s].
        of_stamp: time of the box that a message's stamp [s] means.
        refuse: is told why a message cannot be used.
        accepted: is called after a message that can.
    """

    def __init__(
        self,
        node: Node,
        obey: dict[str, Callable[..., None]],
        now: Callable[[], float],
        of_stamp: Callable[[float], float],
        refuse: Callable[[str], None],
        accepted: Callable[[], None],
    ) -> None:
        self.traffic = CommandTraffic()
        self._obey = obey
        self._now, self._of_stamp = now, of_stamp
        self._refuse, self._accepted = refuse, accepted
        self._subscriptions = {
            topic: node.create_subscription(JointTrajectory, topic, self._taker(topic), RELIABLE)
            for topic in obey
        }

    def count_commanders(self) -> None:
        """See how many nodes publish commands or schedules, whichever are more."""
        counts = [s.get_publisher_count() for s in self._subscriptions.values()]
        self.traffic.commanders = max(counts)

    def _taker(self, topic: str) -> Callable[[JointTrajectory, Any], None]:
        def take(message: JointTrajectory, info: Any) -> None:
            count = self._subscriptions[topic].get_publisher_count
            sequence = info["publication_sequence_number"]
            self.traffic.note(time.monotonic(), topic, sequence, count)
            self._take(topic, message)

        return take

    def _take(self, topic: str, message: JointTrajectory) -> None:
        stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
        points, names = _points(message), message.joint_names
        try:
            self._obey[topic](names, points, self._of_stamp(stamp), self._now())
        except ValueError as error:
            self._refuse(f"{topic}: {error}")
        else:
            self._accepted()
