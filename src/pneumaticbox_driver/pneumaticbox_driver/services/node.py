"""Services of std_srvs whose answer is a sentence: what was done, or why not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger


def offer_triggers(node: Node, calls: dict[str, Callable[[], str]]) -> None:
    """Offer a Trigger service `pneumaticbox/<name>` for each call.

    A call returns the sentence, or raises ValueError: the service then has not succeeded.
    """
    for name, call in calls.items():
        node.create_service(Trigger, f"pneumaticbox/{name}", _answering(call))


def offer_switch(node: Node, name: str, call: Callable[[bool], str]) -> None:
    """Offer a SetBool service `pneumaticbox/<name>`; `call` as for `offer_triggers`."""

    def answer(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        return _answer(lambda: call(request.data), response)

    node.create_service(SetBool, f"pneumaticbox/{name}", answer)


def _answering(call: Callable[[], str]) -> Callable[..., Trigger.Response]:
    def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return _answer(call, response)

    return answer


def _answer(call: Callable[[], str], response: Any) -> Any:
    try:
        response.message = call()
        response.success = True
    except ValueError as error:
        response.message, response.success = str(error), False
    return response
