"""Targets at their stamps, and a simulation that stands where nobody has commanded it further."""

import time

import pytest
import rclpy
from geometry_msgs.msg import PoseStamped
from rclpy.context import Context
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from ros_domain import held_domain
from std_msgs.msg import Header

from pneuflex_sim.ros.command_topics import TARGET_TOPIC
from pneuflex_sim.ros.lockstep import (
    COMMANDED_UNTIL,
    COMMANDER_MEMORY,
    Commanders,
    StampedCommands,
)
from softhand_ros.topics import RELIABLE, stamp_of_seconds

pytestmark = pytest.mark.system


@pytest.fixture(scope="module")
def node():
    with held_domain() as domain:
        context = Context()
        rclpy.init(
            context=context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO
        )
        node = Node("hand_sim", context=context, enable_rosout=False)
        yield node
        node.destroy_node()
        rclpy.try_shutdown(context=context)


@pytest.fixture
def publish(node):
    """Publishes a message once its topic is heard, and lets it arrive."""
    made = []

    def publish(kind, topic, message):
        if not made:
            made.append(node.create_publisher(kind, topic, RELIABLE))
        end = time.monotonic() + 10.0
        while not made[0].get_subscription_count():
            assert time.monotonic() < end
            time.sleep(0.01)
        made[0].publish(message)
        time.sleep(0.05)

    yield publish
    for publisher in made:
        node.destroy_publisher(publisher)


@pytest.fixture
def targets(node, publish):
    """Targets, with `heights` and `refusals` that were obeyed, and `send` by stamp and height."""
    heights, refusals = [], []

    def command(message):
        if message.header.frame_id != "world":
            raise ValueError("header.frame_id: expected world, got map")
        heights.append(message.pose.position.z)

    targets = StampedCommands(node, PoseStamped, TARGET_TOPIC, command, refusals.append)
    targets.heights, targets.refusals = heights, refusals

    def send(stamp, height, frame="world"):
        message = PoseStamped()
        message.header.stamp, message.header.frame_id = stamp_of_seconds(stamp), frame
        message.pose.position.z = height
        publish(PoseStamped, TARGET_TOPIC, message)

    targets.send = send
    return targets


def test_a_target_takes_effect_at_its_stamp_whenever_it_comes(targets):
    targets.send(1.010, 0.3)
    targets.send(1.006, 0.2)
    targets.obey(1.004)
    assert targets.heights == []
    targets.obey(1.006)
    assert targets.heights == [0.2]
    targets.obey(1.012)
    assert targets.heights == [0.2, 0.3]


@pytest.mark.parametrize("stamp", [0.0, 0.9, 1.7e9])
def test_a_late_target_and_one_by_another_clock_take_effect_at_once(targets, stamp):
    targets.send(stamp, 0.2)
    targets.obey(1.0)
    assert targets.heights == [0.2]


def test_a_target_that_waits_is_forgotten_at_a_reset_and_refused_by_name(targets):
    targets.send(1.010, 0.3)
    targets.obey(1.0)
    targets.forget()
    targets.send(1.0, 0.2, frame="map")
    targets.obey(2.0)
    assert targets.heights == []
    assert targets.refusals == ["wrist/target_pose: header.frame_id: expected world, got map"]


def test_the_simulation_stands_where_a_commander_is_until_it_goes_on_or_leaves(node, publish):
    commanders = Commanders(node, awaited=False)

    def tell(until, name="sequencer"):
        stamp = stamp_of_seconds(until)
        publish(Header, COMMANDED_UNTIL, Header(stamp=stamp, frame_id=name))

    assert not commanders.hold(1.0)
    tell(1.015)
    assert not commanders.hold(1.014)
    assert commanders.hold(1.015, timeout=0.01)
    tell(1.025)
    assert not commanders.hold(1.015)
    tell(1.017, "another")
    assert not commanders.hold(1.024)  # who joins is heard where the first one stops
    assert commanders.hold(1.025)
    tell(1.035)
    assert commanders.hold(1.025)  # the other one has not gone on
    tell(0.0, "another")
    assert not commanders.hold(1.025)
    time.sleep(COMMANDER_MEMORY)
    assert not commanders.hold(9.0)  # who is silent is forgotten


def test_a_simulation_that_awaits_a_commander_stands_at_each_start(node, publish):
    commanders = Commanders(node, awaited=True)
    assert commanders.hold(0.0)
    publish(Header, COMMANDED_UNTIL, Header(stamp=stamp_of_seconds(0.015), frame_id="sequencer"))
    assert not commanders.hold(0.0)
    commanders.restart()
    assert commanders.hold(0.0)
