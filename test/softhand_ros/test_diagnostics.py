"""Reports of a node: their level and their sentence."""

import time

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.context import Context
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from ros_peer import Peer

from softhand_ros.diagnostics import (
    ERROR,
    OK,
    PREPARING,
    WARN,
    Diagnostics,
    Preparation,
    Report,
)


def test_a_report_without_warnings_says_that_all_is_well():
    report = Report("simulation", "running", ("", ""))
    assert (report.level, report.message) == (OK, "running")


def test_warnings_take_the_place_of_what_is_well():
    report = Report("simulation", "running", ("no valves", "", "a second simulator"))
    assert (report.level, report.message) == (WARN, "no valves; a second simulator")


def test_an_error_stands_before_the_warnings():
    report = Report("simulation", "running", ("no valves",), errors=("it has diverged",))
    assert (report.level, report.message) == (ERROR, "it has diverged; no valves")


@pytest.mark.system
def test_a_node_that_prepares_says_so_once_a_second_while_it_is_busy(domain, tmp_path):
    peer = Peer(domain, tmp_path)
    received = peer.listen(DiagnosticArray, "/diagnostics")
    context = Context()
    quiet = SignalHandlerOptions.NO
    rclpy.init(context=context, domain_id=domain, signal_handler_options=quiet)
    node = Node("busy", context=context)
    diagnostics = Diagnostics(node, "busy", "hand")
    peer.wait(lambda: peer.node.count_publishers("/diagnostics"), "the node")
    with Preparation(node, diagnostics, "kernels") as tell:
        peer.spin(0.5)
        assert not received  # nothing to say yet
        tell("compiling")
        time.sleep(1.3)  # busy: nobody else publishes
    peer.wait(lambda: len(received) == 2, "two reports")
    for (status,) in (array.status for array in received):
        assert (status.name, status.message, status.level) == (
            "busy: kernels",
            "compiling",
            b"\x01",
        )
        assert status.values[0].key == PREPARING
    node.destroy_node()
    rclpy.try_shutdown(context=context)
    peer.close()
