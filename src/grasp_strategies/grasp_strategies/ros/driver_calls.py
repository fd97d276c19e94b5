"""Services of the driver that a strategy calls: the vent, and the control modes of the channels."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import Any

from rcl_interfaces.srv import SetParameters
from rclpy.client import Client
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

TIME_OUT = 2.0  # [s] of wall time


class DriverCalls:
    """Calls from the strategy's thread; the executor's must spin meanwhile."""

    def __init__(self, node: Node) -> None:
        self._vent: Client = node.create_client(Trigger, "pneumaticbox/vent")
        self._set: Client = node.create_client(SetParameters, "pneumaticbox/set_parameters")

    def missing(self) -> str:
        """The service without which nothing must move, as nobody could abort; empty when there."""
        return "" if self._vent.service_is_ready() else f"the service {self._vent.srv_name}"

    def vent(self) -> str:
        """Why the vent is not confirmed; empty when it is."""
        answer, refusal = _call(self._vent, Trigger.Request())
        if answer is None or answer.success:
            return refusal
        return f"the driver refused to vent: {answer.message}"

    def set_modes(self, modes: Sequence[str]) -> str:
        """Switch the control modes of all channels; why they are not switched, empty when they are.

        What a channel contains becomes its target in the new mode: nothing jumps.
        """
        wanted = Parameter("control_mode", value=list(modes)).to_parameter_msg()
        answer, refusal = _call(self._set, SetParameters.Request(parameters=[wanted]))
        if answer is None or answer.results[0].successful:
            return refusal
        return f"the driver refused the control modes: {answer.results[0].reason}"


def _call(client: Client, request: Any) -> tuple[Any, str]:
    """Answer of a service, None when there is none, and then why."""
    if not client.wait_for_service(TIME_OUT):  # it may not be discovered yet
        return None, f"the service {client.srv_name} is not there (is driver running?)"
    answered = threading.Event()
    future = client.call_async(request)
    future.add_done_callback(lambda done: answered.set())
    if not answered.wait(TIME_OUT):
        return None, f"the service {client.srv_name} did not answer within {TIME_OUT:g} s"
    return future.result(), ""
