"""Simulator and driver in one process: the simulator calls the driver with each sample.

Over topics each sample wakes two processes, which takes longer than the work on it. Here no load of
the machine can come between a sample and its answer.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable

from rclpy.node import Node
from sensor_msgs.msg import JointState

from pneuflex_sim.bullet import failures
from pneuflex_sim.ros import node as simulator
from pneuflex_sim.ros.driver_link import SENSORS, Obey
from pneuflex_sim.ros.parameters import PARAMETERS as OF_THE_SIMULATOR
from pneumaticbox_driver.ros import node as driver
from pneumaticbox_driver.ros.parameters import PARAMETERS as OF_THE_DRIVER
from softhand_bringup.ros.hand_with_box.interface import HELP
from softhand_ros.run_node import run_node
from softhand_ros.topics import RELIABLE, has_subscribers, refuse_time_before_zero


class CallLink:
    """The simulator's `DriverLink` to a driver in its process.

    Args:
        node: the simulator's node.
        obey: applies a message of valves.
        stopped: unused; a call needs no waiting.
    """

    missed = 0

    def __init__(self, node: Node, obey: Obey, stopped: Callable[[], bool]) -> None:
        self._sensors = node.create_publisher(JointState, SENSORS, RELIABLE)
        self._box = driver.PneumaticBoxNode(obey, OF_THE_SIMULATOR)
        refuse_time_before_zero(self._box)
        self._sample = JointState()

    def send(self, sample: JointState) -> None:
        """Keep a sample until `await_answer`, and publish it to subscribers."""
        self._sample = sample
        if has_subscribers(self._sensors):
            self._sensors.publish(sample)

    def await_answer(self, wait: bool, commanded: bool) -> None:
        """Have the driver answer the sample; the driver commands the valves."""
        sample = self._sample
        self._box.keep_serving("sample", lambda _: self._box.answer_sample(sample, commanded), 0.0)

    def look(self) -> None:
        """Nothing: valves are commanded by calls."""

    def serve(self) -> None:
        """Serve the driver's commands and services, when due."""
        self._box.keep_serving("service", self._box.serve_others, driver.SERVE_SLICE)

    def warning(self) -> str:
        """Always empty: no answer comes late."""
        return ""

    def close(self) -> None:
        """Open the outlets and end the driver."""
        self._box.close()


def make() -> simulator.HandSim:
    """The simulator with its driver; raises the errors of both nodes."""
    return simulator.HandSim(CallLink, OF_THE_DRIVER)


def run(node: simulator.HandSim, stop: threading.Event) -> None:
    """Step the simulation, control the box and serve ROS until `stop` is set."""
    driver.prepare_process()
    simulator.run(node, stop)


def main(args: list[str] | None = None) -> int:
    """Run the nodes; returns the exit status of `run_node`."""
    return run_node("hand_with_box", make, run, usage=HELP, args=args, failures=failures())


if __name__ == "__main__":
    sys.exit(main())
