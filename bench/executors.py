"""Executors of a node with as many subscriptions and services as the driver has: the time of a look
that finds nothing, and of a burst of messages; the suite's own beside two of rclpy.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from statistics import median
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger

from bench.row import stated
from softhand_ros.executor import RoundRobin

SUBSCRIPTIONS, SERVICES = 3, 12
LOOKS, BURST, BURSTS = 500, 300, 5
LIMIT = 5.0  # of a burst [s]


class Listener:
    """A node that counts messages on its topics, and one in front of it that sends them."""

    def __init__(self) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context)
        self.node = Node("listener", context=self.context)
        self.sender = Node("sender", context=self.context)
        self.heard = 0
        names = [f"topic_{k}" for k in range(SUBSCRIPTIONS)]
        for name in names:
            self.node.create_subscription(String, name, self._hear, BURST)
        self.out = [self.sender.create_publisher(String, name, BURST) for name in names]
        for k in range(SERVICES):
            self.node.create_service(Trigger, f"service_{k}", lambda _, answer: answer)

    def _hear(self, message: String) -> None:
        self.heard += 1

    def send(self) -> None:
        """Publish a burst on all topics in turn, and give it time to arrive."""
        for k in range(BURST):
            self.out[k % SUBSCRIPTIONS].publish(String(data="x"))
        time.sleep(0.3)

    def close(self) -> None:
        """Destroy the nodes."""
        for node in (self.node, self.sender):
            node.destroy_node()
        rclpy.shutdown(context=self.context)


def measure(name: str, make: Callable[[Listener], Callable[[], Any]]) -> list[dict[str, Any]]:
    """Rows of one executor; `make` gives what serves a listener once, without waiting."""
    listener = Listener()
    look = make(listener)
    time.sleep(1.0)  # discovery
    for _ in range(LOOKS):
        look()
    looks, bursts = [], []
    for _ in range(LOOKS):
        start = time.perf_counter()
        look()
        looks.append(1e6 * (time.perf_counter() - start))
    for _ in range(BURSTS):
        listener.send()
        listener.heard, start = 0, time.perf_counter()
        while listener.heard < BURST and time.perf_counter() - start < LIMIT:
            look()
        bursts.append(1e3 * (time.perf_counter() - start))
    listener.close()
    return [
        stated(f"{name}: a look that finds nothing, median", median(looks), "us"),
        stated(f"{name}: {BURST} messages that wait, median", median(bursts), "ms"),
    ]


def own(listener: Listener) -> Callable[[], Any]:
    """The suite's executor."""
    executor = RoundRobin(listener.node)
    return lambda: executor.serve(0.0)


def of_rclpy(kind: Callable[..., Any]) -> Callable[[Listener], Callable[[], Any]]:
    """An executor of rclpy."""

    def make(listener: Listener) -> Callable[[], Any]:
        executor = kind(context=listener.context)
        executor.add_node(listener.node)
        return lambda: executor.spin_once(timeout_sec=0)

    return make


def run() -> list[dict[str, Any]]:
    """Round robin, events and wait set."""
    return [
        *measure("round robin", own),
        *measure("rclpy's EventsExecutor", of_rclpy(EventsExecutor)),
        *measure("rclpy's SingleThreadedExecutor", of_rclpy(SingleThreadedExecutor)),
    ]
