"""Services of std_srvs that answer with a sentence: what was done, or why it was not.

The function behind a service returns the sentence; when it raises ValueError, the answer has the
error's message and `success` is false.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_srvs.srv import SetBool, Trigger

# By default ROS queues ten calls and ten answers, and each client receives the answers to all
# clients of its service: of fifty calls at once most are lost, and their callers wait for ever.
# So the suite's services and clients queue a thousand, as ROS does for parameters ...
MANY_CALLS = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
# ... and a service answers so slowly that clients of other programs, with their queues of ten,
# can keep up [s] of wall time between answers
ANSWER_PERIOD = 0.02


class OneAtATime(CallbackGroup):
    """Callback group: an rclpy executor begins one call of each service in ANSWER_PERIOD.

    Further calls wait. A call of a coroutine that has not answered yet does not delay the next one.

    Args:
        node: its existing services join the group; it gets a timer that runs while calls may wait.
    """

    def __init__(self, node: Node) -> None:
        super().__init__()
        self._begun: dict[Any, float] = {}  # monotonic wall time of the last call by service [s]
        for service in node.services:
            service.callback_group = self
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = node.create_timer(ANSWER_PERIOD, self._rest, clock=steady, autostart=False)

    def can_execute(self, entity: Any) -> bool:
        """Whether a service may begin a call now."""
        return time.monotonic() - self._begun.get(entity, -math.inf) >= ANSWER_PERIOD

    def beginning_execution(self, entity: Any) -> bool:
        """True always; starts the timer that wakes the executor when the next call is due."""
        self._begun[entity] = time.monotonic()
        self._timer.reset()
        return True

    def ending_execution(self, entity: Any) -> None:
        """Nothing: only time decides when the next call begins."""

    def _rest(self) -> None:
        if all(map(self.can_execute, self._begun)):
            self._timer.cancel()


def offer_trigger(node: Node, name: str, call: Callable[[], str]) -> None:
    """Offer a Trigger service; `call` returns the sentence of the answer."""

    def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return _answer(call, response)

    node.create_service(Trigger, name, answer, qos_profile=MANY_CALLS)


def offer_switch(node: Node, name: str, call: Callable[[bool], str]) -> None:
    """Offer a SetBool service; `call` takes the flag and returns the sentence of the answer."""

    def answer(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        return _answer(lambda: call(request.data), response)

    node.create_service(SetBool, name, answer, qos_profile=MANY_CALLS)


def _answer(call: Callable[[], str], response: Any) -> Any:
    try:
        response.message, response.success = call(), True
    except ValueError as error:
        response.message, response.success = str(error), False
    return response
