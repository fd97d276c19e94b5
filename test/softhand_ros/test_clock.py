"""Who follows /clock is not woken by each of its ticks."""

import time

import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from ros_peer import Peer
from rosgraph_msgs.msg import Clock

from softhand_ros.client_link import ClientLink
from softhand_ros.parameters import follow_simulated_time
from softhand_ros.topics import TakenByHand, has_subscribers, slow_clock, stamp_of_seconds

pytestmark = pytest.mark.system


@pytest.fixture
def peer(domain, tmp_path):
    peer = Peer(domain, tmp_path)
    yield peer
    peer.close()


@pytest.fixture
def executor(peer, domain):
    context = Context()
    rclpy.init(context=context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
    node, executor = Node("late", context=context), SingleThreadedExecutor(context=context)
    executor.add_node(node)
    yield executor
    executor.shutdown()
    node.destroy_node()
    rclpy.try_shutdown(context=context)


def tick(publisher, seconds):
    publisher.publish(Clock(clock=stamp_of_seconds(seconds)))


def test_a_slow_clock_is_set_once_a_period_whatever_ticks_come(peer, executor):
    (node,) = executor.get_nodes()
    follow_simulated_time(node)
    slow_clock(node, 0.1)
    publisher = peer.node.create_publisher(Clock, "/clock", 10)
    peer.wait(publisher.get_subscription_count, "discovery")
    wakes, seen, end = 0, set(), time.monotonic() + 1.0
    while time.monotonic() < end:
        tick(publisher, 1.0 + time.monotonic() - end)
        executor.spin_once(timeout_sec=0.002)
        seen.add(node.get_clock().now().nanoseconds)
    assert 5 <= len(seen) <= 13
    tick(publisher, 7.0)
    end = time.monotonic() + 0.5
    while (left := end - time.monotonic()) > 0.0:
        executor.spin_once(timeout_sec=left)
        wakes += 1
    assert node.get_clock().now().nanoseconds == 7 * 10**9
    assert wakes < 30, "it wakes for ticks that nobody takes"


def test_a_clock_that_is_followed_later_is_slow_too(peer, executor):
    (node,) = executor.get_nodes()
    slow_clock(node, 0.1)
    node.set_parameters([Parameter("use_sim_time", value=True)])
    publisher = peer.node.create_publisher(Clock, "/clock", 10)
    (clock,) = [s for s in node.subscriptions if s.topic_name == "/clock"]
    end, now = time.monotonic() + 10.0, 0.0
    while not (now and isinstance(clock.callback_group, TakenByHand)):
        assert time.monotonic() < end
        tick(publisher, 3.0)
        executor.spin_once(timeout_sec=0.05)
        now = node.get_clock().now().nanoseconds
    assert now == 3 * 10**9


def test_a_link_knows_the_newest_tick_without_being_spun(peer, domain):
    publisher = peer.node.create_publisher(Clock, "/clock", 10)
    with ClientLink("reader", domain) as link:
        assert link.simulated_time == 0.0
        link.subscribe_clock()

        def told():
            for seconds in (1.0, 2.0, 2.5):
                tick(publisher, seconds)
            time.sleep(0.02)
            return link.simulated_time

        peer.wait(told, "a tick")
        told()
        assert has_subscribers(publisher) and link.simulated_time == 2.5
    peer.wait(lambda: not has_subscribers(publisher), "its end")
