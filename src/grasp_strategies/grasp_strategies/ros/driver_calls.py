"""Services of the driver that a strategy calls: the vent, and the control modes of the channels."""

from __future__ import annotations

import functools
import threading
from collections.abc import Sequence
from typing import Any

from rcl_interfaces.srv import SetParameters
from rclpy.client import Client
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from softhand_ros.services import MANY_CALLS

VENT_TIMEOUT = 2.0  # for an answer: then the air is commanded out [s] of wall time
MODES_TIMEOUT = 10.0  # likewise; nothing moves meanwhile, however busy the machine is [s]
DISCOVERY_TIMEOUT = 0.5  # for a service that may not be discovered yet [s] of wall time


class DriverCalls:
    """Calls from the strategy's thread; the executor must be spinning in another one."""

    def __init__(self, node: Node) -> None:
        make = functools.partial(node.create_client, qos_profile=MANY_CALLS)
        self._vent: Client = make(Trigger, "pneumaticbox/vent")
        self._set: Client = make(SetParameters, "pneumaticbox/set_parameters")

    def missing(self) -> str:
        """Name of the vent service while it is not available, since without it no motion could be
        aborted; empty when it is available.
        """
        return "" if self._vent.service_is_ready() else f"the service {self._vent.srv_name}"

    def vent(self) -> str:
        """Call the vent service; returns why the vent is not confirmed, empty when it is."""
        answer, refusal = _call(self._vent, Trigger.Request(), VENT_TIMEOUT)
        if answer is None or answer.success:
            return refusal
        return f"the driver refused to vent: {answer.message}"

    def set_modes(self, modes: Sequence[str]) -> str:
        """Switch the control modes of all channels; returns the reason if that fails, else "".

        The present content of a channel becomes its target in the new mode, so that no target
        jumps.
        """
        wanted = Parameter("control_mode", value=list(modes)).to_parameter_msg()
        answer, refusal = _call(
            self._set, SetParameters.Request(parameters=[wanted]), MODES_TIMEOUT
        )
        if answer is None or answer.results[0].successful:
            return refusal
        return f"the driver refused the control modes: {answer.results[0].reason}"


def _call(client: Client, request: Any, limit: float) -> tuple[Any, str]:
    """Answer of a service, None when there is none within `limit` [s], and then why."""
    if not client.wait_for_service(DISCOVERY_TIMEOUT):
        return None, f"the service {client.srv_name} is not there (is driver running?)"
    answered = threading.Event()
    future = client.call_async(request)
    future.add_done_callback(lambda done: answered.set())
    if not answered.wait(limit):
        return None, f"the service {client.srv_name} did not answer within {limit:g} s"
    return future.result(), ""
