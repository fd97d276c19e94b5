"""Executor that serves subscriptions and services round robin, for a short time at each call.

rclpy's own makes a wait set of all of them at each look, which takes 1 ms on a busy machine: half a
control step of the driver. Asking each for a message takes 2 us, and a storm of messages can be
left in the middle. rclpy's EventsExecutor takes three times as long for a look that finds nothing,
and a quarter of the time for a burst (`make bench ARGS=executors`).
"""

from __future__ import annotations

import time
from typing import Any

from rclpy.executors import SingleThreadedExecutor, TimeoutException
from rclpy.node import Node
from rclpy.subscription import Subscription

from softhand_ros.topics import TakenByHand


class RoundRobin:
    """Takes one message of each subscription and service after the other.

    Args:
        node: whose they are; those of a group `TakenByHand` are left to their owner.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._next = 0
        self._executor = SingleThreadedExecutor(context=node.context)
        self._executor.add_node(node)

    def serve(self, budget: float) -> bool:
        """Serve what waits, one message at least, and end after `budget` [s].

        Returns:
            Whether more may wait.
        """
        end = time.monotonic() + budget
        entities = self._entities()
        quiet = 0
        while quiet < len(entities):
            self._next = (self._next + 1) % len(entities)
            quiet = 0 if _serve(entities[self._next]) else quiet + 1
            if quiet == 0 and time.monotonic() > end:
                return True
        return False

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

    def _entities(self) -> list[Any]:
        """Subscriptions and services to serve; a change of parameters may add to them."""
        found: list[Any] = [*self._node.subscriptions, *self._node.services]
        return [e for e in found if not isinstance(e.callback_group, TakenByHand)]


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
