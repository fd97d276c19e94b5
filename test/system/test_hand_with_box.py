"""Simulator and driver in one process: to others they are the two nodes that they are in two."""

import os
import signal
from dataclasses import replace

import pytest
from rcl_interfaces.srv import GetParameters
from refused_start import refusal
from std_srvs.srv import SetBool
from suite_peer import AMBIENT

from pneuflex_sim.ros.interface import OFFERS as OF_THE_SIMULATOR
from pneumaticbox_driver.ros.interface import OFFERS as OF_THE_DRIVER
from softhand_bringup.processes import suite
from softhand_bringup.ros.hand_with_box.interface import INSIDE

NODES = {"hand_sim": OF_THE_SIMULATOR, "pneumaticbox": OF_THE_DRIVER}
OPTIONAL = {"/tf", "/clock_followers"}  # where tf2_msgs is there; of a simulator that follows
STALL = 3.0  # wall time for which the process stands still, more than any limit of it [s]


@pytest.fixture
def both(launcher, options):
    """The process of both nodes."""
    (command,) = suite.hand_with_box(options, command_timeout=0.0)
    return launcher.start(command)


def offered(peer, node, namespace="/"):
    """What a node publishes and serves, as an observer sees it."""
    published = peer.node.get_publisher_names_and_types_by_node(node, namespace)
    served = peer.node.get_service_names_and_types_by_node(node, namespace)
    return {name for name, _ in (*published, *served)}


def test_both_nodes_are_there_with_their_topics_services_and_parameters(both, peer):
    peer.wait_for_driver()
    assert sorted(set(peer.node.get_node_names()) & set(NODES)) == sorted(NODES)
    for node, offers in NODES.items():
        names = {
            offer.name.replace("<channel>", "a")
            for offer in offers
            if offer.way not in ("sub", "action") and (offer.way, offer.name) not in INSIDE
        }
        names = {name if name.startswith("/") else f"/{name}" for name in names} - OPTIONAL
        peer.wait(lambda: names <= offered(peer, node), f"{names} of {node}")  # noqa: B023
    asked = {"hand_sim": "segments", "pneumaticbox": "embedded_seed"}
    for node, parameter in asked.items():
        answer = peer.call(GetParameters, f"{node}/get_parameters", names=[parameter, "hand"])
        assert answer.values[0].integer_value == {"segments": 5, "embedded_seed": 0}[parameter]
        assert answer.values[1].string_value == "rbo_hand_2"
    both.send(signal.SIGINT)
    assert both.wait(10.0) == 0, both.output()


def test_a_command_fills_and_neither_a_pause_nor_a_standstill_vents(both, peer):
    peer.wait_for_driver()
    peer.wait(lambda: peer.sensors() and peer.valves(), "samples and valves")
    peer.pass_time(1.0)  # the driver averages its sensors
    peer.command([2e-5, 0.0, 0.0, 0.0])
    peer.wait(lambda: peer.sensors()[0] > AMBIENT + 5e3, "air in channel a")
    peer.call(SetBool, "sim/pause", data=True)
    peer.spin(STALL)
    peer.call(SetBool, "sim/pause", data=False)
    peer.pass_time(0.3)
    both.send(signal.SIGSTOP)
    peer.spin(STALL)
    both.send(signal.SIGCONT)
    peer.pass_time(0.3)
    assert "in operation" in peer.diagnosis("pneumaticbox: safety")
    assert peer.sensors()[0] > AMBIENT + 5e3
    assert peer.trigger("pneumaticbox/vent").success
    peer.wait(lambda: peer.valves() == [-1.0] * 4, "open outlets")
    peer.wait(lambda: peer.sensors()[0] < AMBIENT + 8e3, "an empty hand")


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (
            {"backend": "embedded"},
            "backend: expected topic in the process of a simulator, got embedded",
        ),
        ({"bakend": "topic"}, "no parameter bakend, did you mean backend?"),
        ({"objekt": "ball"}, "no parameter objekt, did you mean object?"),
    ],
    ids=["another plant", "misspelled, of the driver", "misspelled, of the simulator"],
)
def test_what_does_not_fit_is_refused(domain, monkeypatch, capfd, options, given, told):
    monkeypatch.setitem(os.environ, "ROS_DOMAIN_ID", str(domain))
    (command,) = suite.hand_with_box(options)
    assert told in refusal(replace(command, parameters=given), capfd)


def test_a_place_for_the_driver_that_does_not_exist_is_refused(options):
    with pytest.raises(ValueError, match="driver: expected one of composed, topic, got inside"):
        suite.suite_nodes(replace(options, driver="inside"))
