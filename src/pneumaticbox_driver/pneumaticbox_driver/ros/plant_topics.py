"""Topics between driver and plant: sensor samples and commanded valves.

Up to 500 samples a second need an answer without delay. The thread that answers takes them directly
from a wait set of their own, without an executor.
"""

from __future__ import annotations

import array
from collections.abc import Callable

import numpy as np
from builtin_interfaces.msg import Time
from numpy.typing import NDArray
from rclpy.duration import Duration
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from softhand_common.documents.quoted import quoted
from softhand_ros.topics import NEWEST, RELIABLE, has_subscribers, subscribe_by_hand, take

SENSORS, VALVES = "pneumaticbox/sensors", "pneumaticbox/valves"
Plant = Callable[[JointState], object]  # obeys valves in this process


def absolute_pressures(sample: JointState, channels: tuple[str, ...]) -> NDArray[np.float64]:
    """Absolute pressures (n + 1,) [Pa] in a sample: channels, then supply.

    Raises:
        ValueError: names or number of values are not those of this box's sensors.
    """
    expected = [*channels, "supply"]
    if sample.name != expected:
        raise ValueError(f"name: expected {expected}, got {quoted(list(sample.name))}")
    if len(sample.effort) != len(expected):
        raise ValueError(f"effort: expected {len(expected)} values, got {len(sample.effort)}")
    return np.array(sample.effort)


class ValvesOut:
    """Commanded valves on the topic `pneumaticbox/valves`.

    Args:
        node: the node that publishes.
        channels: names of the channels, in order.
        plant: the plant in this process, which gets every message; None: the plant subscribes.
    """

    def __init__(self, node: Node, channels: tuple[str, ...], plant: Plant | None = None) -> None:
        self._publisher = node.create_publisher(JointState, VALVES, RELIABLE)
        self._valves, self._plant = JointState(name=list(channels)), plant

    def answer(self, stamp: Time, valves: NDArray[np.int8]) -> None:
        """Publish the valves (n,) with the stamp of their sample."""
        self._valves.header.stamp = stamp
        self._valves.position = array.array("d", valves.tolist())
        if self._plant is not None:
            self._plant(self._valves)
        if self._plant is None or has_subscribers(self._publisher):
            self._publisher.publish(self._valves)

    def flush(self, timeout: float) -> None:
        """Wait up to `timeout` [s] until the plant has received all messages."""
        self._publisher.wait_for_all_acked(Duration(seconds=timeout))


class ClockPulse:
    """Distinguishes a paused simulation, which still publishes /clock, from a simulation that has
    ended.

    Args:
        node: the node that follows /clock.
    """

    def __init__(self, node: Node) -> None:
        self._subscription = subscribe_by_hand(node, Clock, "/clock", NEWEST)
        self._last: tuple[int, int] | None = None
        self._received = self._moved = 0.0

    def look(self, wall_time: float) -> None:
        """Take the newest tick, if there is one, at this monotonic wall time [s]."""
        if not self._moved:
            self._moved = wall_time
        tick = take(self._subscription)
        if tick is None:
            return
        self._received = wall_time
        now = (tick.clock.sec, tick.clock.nanosec)
        if now != self._last:
            self._last, self._moved = now, wall_time

    def paused(self, wall_time: float) -> bool:
        """Whether ticks arrive with a constant time, at this wall time [s]."""
        return wall_time - self._received < 1.0 and wall_time - self._moved > 0.5

    def stands(self, wall_time: float) -> float:
        """Time for which the clock has not advanced, with or without ticks [s]."""
        return wall_time - self._moved if self._moved else 0.0
