"""A node in a ROS context of its own, which hears others only while it waits."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.client import Client
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions

from pneumaticbox_driver.client.box_state import PneumaticboxError


class Link:
    """Waits, listens and calls, with a limit to its patience.

    Args:
        patience: for whatever is waited for [s].
        domain: ROS domain; None for ROS_DOMAIN_ID of the environment.
        name: of the node.
    """

    def __init__(self, patience: float, domain: int | None, name: str) -> None:
        self._patience = patience
        self._heard = 0  # messages so far
        self._context = Context()
        rclpy.init(
            context=self._context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO
        )
        self.node = Node(name, context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)

    @property
    def now(self) -> float:
        """Time of the node's clock [s]."""
        return float(self.node.get_clock().now().nanoseconds * 1e-9)

    def listen(self, kind: Any, topic: str, callback: Callable[[Any], None], depth: int) -> None:
        """Have `callback` called with each message of a topic; `depth` of them may wait."""

        def hear(message: Any) -> None:
            self._heard += 1
            callback(message)

        self.node.create_subscription(kind, topic, hear, QoSProfile(depth=depth))

    def wait(self, condition: Callable[[], Any], silence: str) -> None:
        """Listen until the condition holds.

        Raises:
            PneumaticboxError: it never does; `silence` says what is wrong then.
        """
        end = time.monotonic() + self._patience
        while not condition():
            if time.monotonic() > end:
                raise PneumaticboxError(f"{silence} (waited {self._patience:g} s)")
            self._executor.spin_once(timeout_sec=0.05)

    def drain(self) -> None:
        """Hear what waits already."""
        before = -1
        while before != self._heard:
            before = self._heard
            self._executor.spin_once(timeout_sec=0.0)

    def call(self, client: Client, request: Any) -> Any:
        """Call a service and wait for its response; raises as `wait` does."""
        self.wait(client.service_is_ready, f"no driver offers {client.srv_name}")
        future = client.call_async(request)
        self.wait(future.done, f"{client.srv_name} does not answer")
        return future.result()

    def close(self) -> None:
        """End the node."""
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self._context)
