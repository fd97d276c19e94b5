"""Stamps of messages as numbers and back."""

import pytest
import rclpy
from builtin_interfaces.msg import Time
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from rosgraph_msgs.msg import Clock

from softhand_ros.topics import (
    nanoseconds,
    refuse_time_before_zero,
    seconds,
    stamp_of,
    stamp_of_seconds,
)


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
