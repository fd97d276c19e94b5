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

from softhand_ros.executor import RoundRobin
from softhand_ros.services import ANSWER_PERIOD, offer_trigger

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
    peer.wait(lambda: node.count_publishers("storm"), "discovery")
    peer.wait(publisher.get_subscription_count, "discovery")
    for number in range(count):
        publisher.publish(String(data=str(number)))
    peer.spin(0.3)


def await_callers(peer, node, service, count):
    """Until the node knows so many callers: the answer to one that it does not know is lost."""

    def known():
        return node.get_subscriptions_info_by_topic(f"rr/{service}Reply", no_mangle=True)

    peer.wait(lambda: len(known()) == count, f"{count} callers of {service}")


def test_a_slice_ends_after_its_time_and_the_next_goes_on_in_order(peer, node):
    received = []

    def slow(message):
        received.append(int(message.data))
        end = time.monotonic() + 0.001
        while time.monotonic() < end:
            pass

    node.create_subscription(String, "storm", slow, MANY)
    executor = RoundRobin(node)
    storm(peer, node, 300)
    executor.serve(0.005)
    assert 1 <= len(received) <= 6
    executor.serve(10.0)
    assert received == list(range(300))
    executor.close()


def test_at_least_one_message_is_served_however_short_the_slice(peer, node):
    received = []
    node.create_subscription(String, "storm", received.append, MANY)
    executor = RoundRobin(node)
    storm(peer, node, 5)
    for count in range(1, 6):
        executor.serve(-1.0)
        assert len(received) == count
    executor.close()


def test_a_storm_does_not_keep_others_waiting(peer, node):
    received = []
    node.create_subscription(String, "storm", received.append, MANY)

    def answer(_, response):
        response.message = str(len(received))
        return response

    node.create_service(Trigger, "ask", answer)
    executor = RoundRobin(node)
    question = peer.request(Trigger, "ask")
    storm(peer, node, 300)
    executor.serve(10.0)
    assert len(received) == 300
    peer.wait(question.done, "an answer")
    assert int(question.result().message) < 5
    executor.close()


def test_subscriptions_that_come_later_are_served_too(peer, node):
    executor = RoundRobin(node)
    executor.serve(0.001)
    received = []
    node.create_subscription(Empty, "late", received.append, 10)
    peer.publish(Empty, "late", Empty())

    def served():
        executor.serve(0.001)
        return received

    peer.wait(served, "the message")
    executor.close()


def test_a_service_answers_one_call_in_a_period_and_no_call_is_lost(peer, node):
    asked = []

    def answer(_, response):
        asked.append(time.monotonic())
        return response

    offer_trigger(node, "ask", lambda: str(asked.append(time.monotonic())))
    node.create_service(Trigger, "other", answer)
    executor = RoundRobin(node)
    questions = [peer.request(Trigger, "ask") for _ in range(30)]
    await_callers(peer, node, "ask", 30)

    def answered():
        return sum(question.done() for question in questions) == len(asked)

    while len(asked) < 30:
        executor.serve(1.0)
        peer.wait(answered, "the answers")  # the middleware keeps no more than ten
    # over five calls: the clock of a single one is read late when the machine is busy
    times = zip(asked, asked[5:], strict=False)
    assert min(after - before for before, after in times) > 0.9 * 5 * ANSWER_PERIOD
    # another service does not wait for this one
    executor._services_due = 0.0
    questions.append(peer.request(Trigger, "ask"))
    questions.append(peer.request(Trigger, "other"))
    await_callers(peer, node, "ask", 31)
    await_callers(peer, node, "other", 1)
    peer.spin(0.3)
    executor.serve(1.0)
    assert len(asked) == 32
    peer.wait(lambda: all(question.done() for question in questions), "answers")
    executor.close()
