"""Client link: a node in a context of its own, which hears others only while it waits."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Self

import rclpy
from rclpy.client import Client
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from rclpy.subscription import Subscription
from rosgraph_msgs.msg import Clock

from softhand_ros.middleware import set_up_middleware
from softhand_ros.parameters import SIM_TIME
from softhand_ros.topics import NEWEST, seconds, subscribe_by_hand, take

LOOK_PERIOD = 0.05  # wall time between two looks at what is waited for [s]


class ClientLink:
    """Waits, listens and calls, with a limit to each. A context manager; use it from one thread.

    Args:
        name: of the node.
        domain: ROS domain; None for ROS_DOMAIN_ID of the environment.
        namespace: of the nodes that it talks to; empty: the root.
    """

    def __init__(self, name: str, domain: int | None = None, namespace: str = "") -> None:
        self._heard = 0  # messages so far
        self._context = Context()
        set_up_middleware()
        rclpy.init(
            context=self._context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO
        )
        self.node = Node(
            name,
            context=self._context,
            namespace=namespace,
            enable_rosout=False,
            start_parameter_services=False,
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._clock: Subscription | None = None
        self._simulated_time: float | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the node."""
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self._context)

    @property
    def now(self) -> float:
        """Time of the node's clock [s]."""
        return float(self.node.get_clock().now().nanoseconds * 1e-9)

    def follow_simulated_time(self, follow: bool) -> None:
        """Let the node's clock follow /clock, or not."""
        self.node.set_parameters([Parameter(SIM_TIME, value=follow)])

    def listen(
        self, kind: Any, topic: str, callback: Callable[[Any], None], depth: int = 10
    ) -> None:
        """Have `callback` called with each message of a topic; `depth` of them may wait."""

        def hear(message: Any) -> None:
            self._heard += 1
            callback(message)

        self.node.create_subscription(kind, topic, hear, depth)

    def hear_clock(self) -> None:
        """Have `simulated_time` follow /clock, whose hundred ticks a second wake nobody."""
        self._clock = subscribe_by_hand(self.node, Clock, "/clock", NEWEST)

    @property
    def simulated_time(self) -> float:
        """Latest tick since `hear_clock` [s]; 0 before the first."""
        tick = take(self._clock) if self._clock is not None else None
        if tick is not None:
            self._simulated_time = seconds(tick.clock)
        return self._simulated_time or 0.0

    @property
    def has_ticked(self) -> bool:
        """Whether there has been a tick since `hear_clock`."""
        return self.simulated_time > 0.0 or self._simulated_time is not None

    def spin(self, duration: float) -> None:
        """Listen for so much wall time [s]."""
        end = time.monotonic() + duration
        while (left := end - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def drain(self) -> None:
        """Hear what waits already."""
        before = -1
        while before != self._heard:
            before = self._heard
            self._executor.spin_once(timeout_sec=0.0)

    def wait(self, condition: Callable[[], Any], limit: float) -> bool:
        """Listen until the condition holds; False when it did not within `limit` [s]."""
        end = time.monotonic() + limit
        while not condition():
            if time.monotonic() > end:
                return False
            self._executor.spin_once(timeout_sec=LOOK_PERIOD)
        return True

    def ask(self, client: Client, request: Any, limit: float) -> Any:
        """Answer of a service, None when it has not answered within `limit` [s]."""
        future = client.call_async(request)
        return future.result() if self.wait(future.done, limit) else None

    def is_heard_by(self, topic: str, node: str) -> bool:
        """Whether a node of that name has subscribed to a topic."""
        subscribers = self.node.get_subscriptions_info_by_topic(topic)
        return any(info.node_name == node for info in subscribers)
