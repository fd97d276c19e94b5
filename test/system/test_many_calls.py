"""Fifty calls at once of every service that is safe to call: each of them is answered."""

import time

import pytest
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from std_srvs.srv import SetBool, Trigger

from softhand_ros.services import MANY_CALLS
from softhand_ros.topics import TakenByHand

COUNT = 50
LIMIT = 15.0  # [s] of wall time for all answers of a service
STRATEGY = "grasp/slide_to_wall"  # the first call runs until the abort; the others are refused
TRIGGERS = (
    "pneumaticbox/vent",
    "pneumaticbox/tare",
    "pneumaticbox/calibrate",
    "pneumaticbox/calibrate_next",
    "pneumaticbox/reset",
    "sim/step",
    "sim/reset",
    "grasp/push",
    "grasp/edge",
    STRATEGY,
    "grasp/abort",
)
SWITCHES = {"sim/pause": False, "pneumaticbox/enable": True}
OF_ALL_NODES = {"get": GetParameters, "list": ListParameters, "set": SetParameters}
CALLS = [
    *((name, Trigger, {}) for name in TRIGGERS),
    *((name, SetBool, {"data": data}) for name, data in SWITCHES.items()),
    *(
        (f"{node}/{verb}_parameters", kind, {})
        for node in ("pneumaticbox", "hand_sim", "grasp_sequencer")
        for verb, kind in OF_ALL_NODES.items()
    ),
]
# each kind of service and of node: the others differ in their queues alone, which one client shows
OF_MANY = (
    "pneumaticbox/vent",
    "sim/reset",
    "sim/pause",
    STRATEGY,
    "hand_sim/set_parameters",
    "grasp_sequencer/get_parameters",
)


class Crowd:
    """Clients of a service, each of which takes what comes; they keep as many answers as those of
    the suite, so that a test process that is held up loses none.
    """

    def __init__(self, peer, kind, service, count):
        self._node, self._kind = peer.node, kind
        self._clients = [
            peer.node.create_client(
                kind, service, qos_profile=MANY_CALLS, callback_group=TakenByHand()
            )
            for _ in range(count)
        ]
        for client in self._clients:
            assert client.wait_for_service(LIMIT), service
        peer.spin(0.3)  # the service discovers its callers

    def call(self, fields):
        for number in range(COUNT):
            self._clients[number % len(self._clients)].handle.send_request(
                self._kind.Request(**fields)
            )

    def answers(self, limit, other=lambda: True):
        """How many calls are answered in time."""
        count, end = 0, time.monotonic() + limit
        while (count < COUNT or not other()) and time.monotonic() < end:
            for client in self._clients:
                header, response = client.handle.take_response(self._kind.Response)
                while header is not None or response is not None:
                    count += response is not None
                    header, response = client.handle.take_response(self._kind.Response)
            time.sleep(0.001)
        return count

    def close(self):
        for client in self._clients:
            self._node.destroy_client(client)


@pytest.mark.parametrize(
    ("clients", "calls"),
    [(COUNT, [call for call in CALLS if call[0] in OF_MANY]), (1, CALLS)],
    ids=["fifty clients", "one client"],
)
def test_each_of_fifty_calls_at_once_is_answered(nodes, peer, clients, calls):
    peer.wait_for_driver()
    abort = peer.node.create_client(Trigger, "grasp/abort")
    missing = {}
    for service, kind, fields in calls:
        crowd = Crowd(peer, kind, service, clients)
        crowd.call(fields)
        if service == STRATEGY:
            aborted = abort.call_async(Trigger.Request())
        got = crowd.answers(LIMIT)
        if got != COUNT:
            missing[service] = COUNT - got
        if service == STRATEGY:
            peer.wait(aborted.done, "the abort", LIMIT)
        crowd.close()
    assert not missing
