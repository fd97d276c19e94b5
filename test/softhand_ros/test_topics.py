"""Stamps of messages as numbers and back."""

import ctypes
import subprocess
import sys

import pytest
import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from rosgraph_msgs.msg import Clock

from softhand_ros.client_link import ClientLink
from softhand_ros.topics import (
    RELIABLE_DEEP,
    nanoseconds,
    refuse_time_before_zero,
    seconds,
    stamp_of,
    stamp_of_seconds,
    subscribe_by_hand,
    take,
)

LARGE = 10_000_000  # characters of a name
SENDER = """
import sys
from geometry_msgs.msg import PoseStamped
from softhand_ros.client_link import ClientLink
with ClientLink("sender", int(sys.argv[1])) as link:
    publisher = link.node.create_publisher(PoseStamped, "large", 10)
    assert link.wait(publisher.get_subscription_count, 20.0)
    message = PoseStamped()
    message.header.frame_id = int(sys.argv[2]) * "x"
    publisher.publish(message)
    link.spin(0.5)
"""


@pytest.mark.parametrize("time", [0, 1, 999_999_999, 10**9, 1_234_567_890_123_456_789])
def test_a_stamp_keeps_every_nanosecond(time):
    assert nanoseconds(stamp_of(time)) == time


def test_a_stamp_of_seconds_is_rounded_to_the_nanosecond():
    assert nanoseconds(stamp_of_seconds(1.9999999999)) == 2 * 10**9
    assert seconds(stamp_of_seconds(3.25)) == 3.25


@pytest.fixture
def simulated(domain):
    """A node by simulated time."""
    context = Context()
    quiet = SignalHandlerOptions.NO
    rclpy.init(context=context, domain_id=domain, signal_handler_options=quiet)
    by_clock = [Parameter("use_sim_time", value=True)]
    node = Node("timed", context=context, parameter_overrides=by_clock)
    yield node
    node.destroy_node()
    rclpy.try_shutdown(context=context)


@pytest.mark.system
def test_a_tick_before_zero_is_refused_and_later_ones_are_followed(simulated):
    refuse_time_before_zero(simulated)
    tick = simulated._time_source._clock_sub.callback
    for sec in (3, -1, -(2**31)):
        tick(Clock(clock=Time(sec=sec)))
        assert simulated.get_clock().now().nanoseconds == 3 * 10**9
    tick(Clock(clock=Time(sec=4)))
    assert simulated.get_clock().now().nanoseconds == 4 * 10**9


class Heap(ctypes.Structure):
    """What mallinfo2(3) tells [bytes]; `mapped` is that of large blocks."""

    _fields_ = [
        (name, ctypes.c_size_t)
        for name in ("arena", "o", "s", "h", "mapped", "u", "f", "used", "free", "top")
    ]


@pytest.mark.system
def test_a_large_message_leaves_nothing_behind_when_its_sender_has_gone(domain):
    heap = ctypes.CDLL(None).mallinfo2
    heap.restype = Heap
    with ClientLink("hearer", domain) as link:
        subscription = subscribe_by_hand(link.node, PoseStamped, "large", RELIABLE_DEEP)
        before = heap().mapped
        subprocess.run([sys.executable, "-c", SENDER, str(domain), str(LARGE)], check=True)
        assert link.wait(lambda: not subscription.get_publisher_count(), 20.0)
        while take(subscription) is not None:
            pass
        assert heap().mapped - before < LARGE / 2
