"""Executor that serves subscriptions and services round robin, for a short time at each call.

rclpy's own makes a wait set of all of them at each look, which takes 1 ms on a busy machine: half a
control step of the driver. Asking each for a message takes 2 us, and a storm of messages can be
left in the middle. rclpy's EventsExecutor takes three times as long for a look that finds nothing,
and a quarter of the time for a burst (`make bench ARGS=executors`).
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import Any

from rclpy.executors import SingleThreadedExecutor, TimeoutException
from rclpy.node import Node
from rclpy.subscription import Subscription

from softhand_ros.topics import TakenByHand

SERVICE_PERIOD = 0.005  # wall time between two looks at services that find nothing [s]


class RoundRobin:
    """Takes one message of each subscription, and of each service, after the other.

    A look at the dozen services that a node has costs more than one at its subscriptions, and calls
    are rare: without one, services wait `SERVICE_PERIOD`.

    Args:
        node: whose they are; those of a group `TakenByHand` are left to their owner.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._subscriptions, self._services = _Turns(), _Turns()
        self._services_due = 0.0
        self._executor = SingleThreadedExecutor(context=node.context)
        self._executor.add_node(node)

    def serve(self, budget: float) -> bool:
        """Serve what waits, one message at least, and end after `budget` [s].

        Returns:
            Whether more may wait.
        """
        now = time.monotonic()
        more = False
        if now >= self._services_due:
            more = self._services.serve(self._node.services, now + budget)
            self._services_due = now if more else now + SERVICE_PERIOD
        return self.serve_messages(budget) or more

    def serve_messages(self, budget: float) -> bool:
        """As `serve`, but for the services."""
        return self._subscriptions.serve(self._node.subscriptions, time.monotonic() + budget)

    def serve_rest(self) -> None:
        """Serve once what is neither of the two, as events of the quality of service."""
        try:
            task, _, _ = self._executor.wait_for_ready_callbacks(timeout_sec=0)
        except TimeoutException:
            return
        task()
        error = task.exception()
        if error is not None:
            raise error

    def close(self) -> None:
        """Let the node go."""
        self._executor.shutdown()


class _Turns:
    """Whose turn it is among entities of a kind; a change of parameters may add to them."""

    def __init__(self) -> None:
        self._next = 0

    def serve(self, entities: Iterable[Any], end: float) -> bool:
        """Serve one message of each after the other until none waits or the time `end` [s] is
        past; whether more may wait.
        """
        served = [e for e in entities if not isinstance(e.callback_group, TakenByHand)]
        quiet = 0
        while quiet < len(served):
            self._next = (self._next + 1) % len(served)
            quiet = 0 if _serve(served[self._next]) else quiet + 1
            if quiet == 0 and time.monotonic() > end:
                return True
        return False


def _serve(entity: Any) -> bool:
    """Answer one message of a subscription or service; False when there is none."""
    if isinstance(entity, Subscription):
        taken = entity.handle.take_message(entity.msg_type, entity.raw)
        if taken is None:
            return False
        wanted = entity._callback_type is Subscription.CallbackType.WithMessageInfo
        entity.callback(*(taken if wanted else taken[:1]))
        return True
    request, header = entity.handle.service_take_request(entity.srv_type.Request)
    if request is None:
        return False
    entity.send_response(entity.callback(request, entity.srv_type.Response()), header)
    return True
