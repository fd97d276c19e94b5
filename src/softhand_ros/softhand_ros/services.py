"""Services of std_srvs whose answer is a sentence: what was done, or why not.

A call returns the sentence, or raises ValueError: the service then has not succeeded.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger


def offer_trigger(node: Node, name: str, call: Callable[[], str]) -> None:
    """Offer a Trigger service."""

    def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return _answer(call, response)

    node.create_service(Trigger, name, answer)


def offer_switch(node: Node, name: str, call: Callable[[bool], str]) -> None:
    """Offer a SetBool service."""

    def answer(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        return _answer(lambda: call(request.data), response)

    node.create_service(SetBool, name, answer)


def _answer(call: Callable[[], str], response: Any) -> Any:
    try:
        response.message, response.success = call(), True
    except ValueError as error:
        response.message, response.success = str(error), False
    return response
