"""Client link: a node in a context of its own, which receives messages only while it waits."""

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
from softhand_ros.services import MANY_CALLS
from softhand_ros.strangers import strangers
from softhand_ros.topics import NEWEST, now_of, seconds, subscribe_by_hand, take

WAIT_STEP = 0.05  # wall time between two checks of a condition that is waited for [s]


class ClientLink:
    """A client of other nodes whose waits and calls have a time limit.

    A context manager, for use from a single thread.

    Args:
        name: name of its node.
        domain: ROS domain; None for ROS_DOMAIN_ID of the environment.
        namespace: namespace of its own node and of the nodes it talks to; empty: the root.
        enclave: ROS enclave of its node; `strangers` lists nodes outside of it. Empty: none.
    """

    def __init__(
        self, name: str, domain: int | None = None, namespace: str = "", enclave: str = ""
    ) -> None:
        self._received = 0  # messages so far
        self._context = Context()
        set_up_middleware()
        rclpy.init(
            args=["--ros-args", "--enclave", enclave] if enclave else None,
            context=self._context,
            domain_id=domain,
            signal_handler_options=SignalHandlerOptions.NO,
        )
        self.domain, self._enclave = self._context.get_domain_id(), enclave
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
        """Destroy the node."""
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self._context)

    @property
    def now(self) -> float:
        """Time of the node's clock [s]."""
        return now_of(self.node)

    def follow_simulated_time(self, follow: bool) -> None:
        """Have the node's clock follow /clock (True) or the system time (False)."""
        self.node.set_parameters([Parameter(SIM_TIME, value=follow)])

    def listen(
        self, kind: Any, topic: str, callback: Callable[[Any], None], depth: int = 10
    ) -> None:
        """Subscribe to a topic: `callback` gets each message; the queue holds `depth` of them."""

        def receive(message: Any) -> None:
            self._received += 1
            callback(message)

        self.node.create_subscription(kind, topic, receive, depth)

    def subscribe_clock(self) -> None:
        """Subscribe to /clock for `simulated_time`, without a wake-up for each of its ticks."""
        self._clock = subscribe_by_hand(self.node, Clock, "/clock", NEWEST)

    @property
    def simulated_time(self) -> float:
        """Latest tick of /clock since `subscribe_clock` [s]; 0 before the first."""
        tick = take(self._clock) if self._clock is not None else None
        if tick is not None:
            self._simulated_time = seconds(tick.clock)
        return self._simulated_time or 0.0

    @property
    def has_ticked(self) -> bool:
        """Whether a tick of /clock has come since `subscribe_clock`."""
        return self.simulated_time > 0.0 or self._simulated_time is not None

    def spin(self, duration: float) -> None:
        """Receive messages for this wall time [s]."""
        end = time.monotonic() + duration
        while (left := end - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def drain(self) -> None:
        """Receive the messages that are already in the queues."""
        before = -1
        while before != self._received:
            before = self._received
            self._executor.spin_once(timeout_sec=0.0)

    def wait(self, condition: Callable[[], Any], limit: float) -> bool:
        """Receive messages until a condition holds; False when it did not within `limit` [s]."""
        end = time.monotonic() + limit
        while not condition():
            if time.monotonic() > end:
                return False
            self._executor.spin_once(timeout_sec=WAIT_STEP)
        return True

    def client(self, kind: Any, service: str) -> Client:
        """A client of a service, with a queue for the answers to many callers."""
        return self.node.create_client(kind, service, qos_profile=MANY_CALLS)

    def ask(self, client: Client, request: Any, limit: float) -> Any:
        """Answer to a request; None when the service has not answered within `limit` [s]."""
        future = client.call_async(request)
        return future.result() if self.wait(future.done, limit) else None

    def strangers(self) -> list[str]:
        """Nodes of the suite in this ROS domain outside of the enclave, as `softhand_ros.strangers`
        lists them.
        """
        return strangers(self.node, self._enclave)

    def is_subscribed(self, node: str, topic: str) -> bool:
        """Whether a node of this name has subscribed to a topic."""
        subscribers = self.node.get_subscriptions_info_by_topic(topic)
        return any(info.node_name == node for info in subscribers)
