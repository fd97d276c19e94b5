"""The driver as seen by the simulator: it receives a sensor sample and answers with valve
commands."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

from rclpy.node import Node
from sensor_msgs.msg import JointState

from softhand_ros.topics import RELIABLE, Inbox, has_subscribers, nanoseconds

SENSORS, VALVES = "pneumaticbox/sensors", "pneumaticbox/valves"
# wall time to wait for the valves that answer a sample [s]: after an answer in time (a busy machine
# is not a fault), and after a missed one
ANSWER_TIMEOUT, LATE_ANSWER_TIMEOUT = 5.0, 0.05
STOP_CHECK_PERIOD = 0.1  # wall time between checks whether the node shall end [s]
WAITING_WARNING_TIME = 0.5  # missed wall time between two reports that is worth a warning [s]

Obey = Callable[[JointState], bool]  # applies valves; whether they could be used


class DriverLink(Protocol):
    """Gives sensor samples to a driver, and the driver's valve commands to the simulator."""

    missed: int  # answers that did not come

    def send(self, sample: JointState) -> None:
        """Pass a sensor sample to the driver."""

    def await_answer(self, wait: bool, commanded: bool) -> None:
        """Wait for the valve commands that answer the sample, and apply them; without `wait`, apply
        only those that have already arrived.

        `commanded`: whether commands for the driver may have come since the last sample.
        """

    def look(self) -> None:
        """Apply the valve commands that have arrived."""

    def serve(self) -> None:
        """Do the other work of a driver that has no process of its own."""

    def warning(self) -> str:
        """A warning about the driver since the last call; empty when there is none."""

    def close(self) -> None:
        """End a driver that has no process of its own."""


class TopicLink:
    """The `DriverLink` to a node in another process, by topics.

    Args:
        node: the simulator's node.
        obey: applies a message of valves.
        stopped: returns whether the simulator is to end.
    """

    def __init__(self, node: Node, obey: Obey, stopped: Callable[[], bool]) -> None:
        self._obey, self._stopped = obey, stopped
        self._sensors = node.create_publisher(JointState, SENSORS, RELIABLE)
        self._valves = Inbox(node, JointState, VALVES, RELIABLE)
        self._sample = self._answered = -1  # stamps [ns]
        self._late, self._waited = False, 0.0
        self.missed = self._reported = 0

    def send(self, sample: JointState) -> None:
        """Publish a sensor sample."""
        self._sample = nanoseconds(sample.header.stamp)
        if self._answered >= self._sample:  # the time was set back
            self._answered = -1
        self._sensors.publish(sample)

    def await_answer(self, wait: bool, commanded: bool) -> None:
        """Apply the valve commands that answer the sample; with `wait`, wait for them a limited
        time.
        """
        self.look()
        if not wait:
            return
        patience = LATE_ANSWER_TIMEOUT if self._late else ANSWER_TIMEOUT
        deadline = time.monotonic() + patience
        while self._answered < self._sample and self._driver_there and not self._stopped():
            left = deadline - time.monotonic()
            if left <= 0:
                self.missed += 1
                self._waited += patience
                break
            self._take(min(left, STOP_CHECK_PERIOD))
        self._late = self._answered < self._sample

    @property
    def _driver_there(self) -> bool:
        """Whether somebody answers samples, and hears them."""
        return bool(self._valves.publishers()) and has_subscribers(self._sensors)

    def look(self) -> None:
        """Apply the valve commands that have arrived."""
        self._take(0.0)

    def _take(self, timeout: float) -> None:
        """As `look`, after waiting up to `timeout` [s] for the first message."""
        message = self._valves.take(timeout)
        while message is not None:
            if self._obey(message):
                self._answered = nanoseconds(message.header.stamp)
            message = self._valves.take()

    def serve(self) -> None:
        """Nothing: the driver serves itself."""

    def warning(self) -> str:
        """A warning when the simulator has waited long for answers that did not come; else
        empty.
        """
        missed, self._reported = self.missed - self._reported, self.missed
        waited, self._waited = self._waited, 0.0
        if waited <= WAITING_WARNING_TIME:
            return ""
        return f"the driver answers late: {missed} samples waited for it in vain"

    def close(self) -> None:
        """Do nothing: the driver is a process of its own and ends by itself."""
