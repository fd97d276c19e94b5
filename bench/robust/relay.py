"""Sensor samples on their way from the plant to the driver, where the bench can spoil them."""

from __future__ import annotations

import time
from collections import deque
from dataclasses import replace

from sensor_msgs.msg import JointState

from bench.robust.rig import AMBIENT, Rig
from softhand_bringup.processes import suite
from softhand_bringup.processes.launcher import NodeCommand
from softhand_bringup.processes.suite import SuiteOptions

TOPIC = "bench/sensors"
LATE = 0.5  # by which late samples come later [s]


def relayed_driver(options: SuiteOptions) -> NodeCommand:
    """The driver that hears its sensors on the bench's topic."""
    command = suite.driver(options)
    return replace(command, remappings={"pneumaticbox/sensors": TOPIC})


class Relay:
    """Passes samples on while its owner spins; `fault` is one of late, frozen, lost, supply lost.

    Args:
        rig: whose node hears and publishes.
    """

    def __init__(self, rig: Rig) -> None:
        self.fault = ""
        self._out = rig.node.create_publisher(JointState, TOPIC, 10)
        self._waiting: deque[tuple[float, JointState]] = deque()
        self._last: JointState | None = None
        rig.listen(JointState, "pneumaticbox/sensors", self._pass_on)

    def _pass_on(self, message: JointState) -> None:
        if self.fault == "lost":
            return
        if self.fault == "late":
            self._delay(message)
            return
        if self.fault == "frozen" and self._last is not None:
            message.effort = self._last.effort
        elif self.fault == "supply lost":
            message.effort[-1] = AMBIENT
        self._last = message
        self._out.publish(message)

    def _delay(self, message: JointState) -> None:
        now = time.monotonic()
        self._waiting.append((now, message))
        while now - self._waiting[0][0] > LATE:
            self._out.publish(self._waiting.popleft()[1])
