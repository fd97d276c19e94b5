"""Messages are served round robin in short slices: a storm can be left in the middle."""

import time

import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from ros_peer import Peer
from std_msgs.msg import Empty, String
from std_srvs.srv import Trigger

from softhand_ros.executor import SERVICE_PERIOD, RoundRobin

pytestmark = pytest.mark.system
MANY = QoSProfile(depth=500)


@pytest.fixture
def peer(domain, tmp_path):
    peer = Peer(domain, tmp_path)
    yield peer
    peer.close()


@pytest.fixture
def node(peer, domain):
    context = Context()
    rclpy.init(context=context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
    node = Node("served", context=context)
    yield node
    node.destroy_node()
    rclpy.try_shutdown(context=context)


def storm(peer, node, count):
    """Have `count` messages wait at the node."""
    publisher = peer.node.create_publisher(String, "storm", MANY)
    peer.wait(lambda: node.count_publishers("storm"), 10.0, "discovery")
    peer.wait(publisher.get_subscription_count, 10.0, "discovery")
    for number in range(count):
        publisher.publish(String(data=str(number)))
    peer.spin(0.3)


def test_a_slice_ends_after_its_time_and_the_next_goes_on_in_order(peer, node):
    heard = []

    def slow(message):
        heard.append(int(message.data))
        end = time.monotonic() + 0.001
        while time.monotonic() < end:
            pass

    node.create_subscription(String, "storm", slow, MANY)
    executor = RoundRobin(node)
    storm(peer, node, 300)
    executor.serve(0.005)
    assert 1 <= len(heard) <= 6
    executor.serve(10.0)
    assert heard == list(range(300))
    executor.close()


def test_at_least_one_message_is_served_however_short_the_slice(peer, node):
    heard = []
    node.create_subscription(String, "storm", heard.append, MANY)
    executor = RoundRobin(node)
    storm(peer, node, 5)
    for count in range(1, 6):
        executor.serve(-1.0)
        assert len(heard) == count
    executor.close()


def test_a_storm_does_not_keep_others_waiting(peer, node):
    heard = []
    node.create_subscription(String, "storm", heard.append, MANY)

    def answer(_, response):
        response.message = str(len(heard))
        return response

    node.create_service(Trigger, "ask", answer)
    executor = RoundRobin(node)
    question = peer.request(Trigger, "ask")
    storm(peer, node, 300)
    executor.serve(10.0)
    assert len(heard) == 300
    peer.wait(question.done, 5.0, "an answer")
    assert int(question.result().message) < 5
    executor.close()


def test_subscriptions_that_come_later_are_served_too(peer, node):
    executor = RoundRobin(node)
    executor.serve(0.001)
    heard = []
    node.create_subscription(Empty, "late", heard.append, 10)
    peer.publish(Empty, "late", Empty())

    def served():
        executor.serve(0.001)
        return heard

    peer.wait(served, 5.0, "the message")
    executor.close()


def test_services_are_looked_at_once_a_period_and_again_at_once_while_calls_wait(peer, node):
    asked = []

    def answer(_, response):
        asked.append(time.monotonic())
        return response

    node.create_service(Trigger, "ask", answer)
    executor = RoundRobin(node)
    questions = [peer.request(Trigger, "ask") for _ in range(3)]
    peer.spin(0.3)
    executor.serve(0.0)
    assert len(asked) == 1
    executor.serve(1.0)
    assert len(asked) == 3
    later = peer.request(Trigger, "ask")
    peer.spin(0.3)
    executor._services_due = time.monotonic() + SERVICE_PERIOD
    while len(asked) < 4:
        executor.serve(0.001)
    assert asked[-1] >= executor._services_due - 2 * SERVICE_PERIOD
    peer.wait(lambda: all(question.done() for question in [*questions, later]), 5.0, "answers")
    executor.close()
