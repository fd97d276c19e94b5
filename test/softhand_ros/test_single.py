"""One node of a kind: the second is told of the first, unless it shall start all the same."""

import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import String

from softhand_bringup.processes.launcher import wait_until
from softhand_ros import single
from softhand_ros.single import Single

pytestmark = pytest.mark.system


@pytest.fixture
def make(domain, monkeypatch):
    """Makes nodes, each in a context of its own, as if they were processes."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    made = []

    def make(namespace="/"):
        context = Context()
        quiet = SignalHandlerOptions.NO
        rclpy.init(context=context, domain_id=domain, signal_handler_options=quiet)
        made.append((context, Node("box", context=context, namespace=namespace)))
        return made[-1][1]

    yield make
    for context, node in made:
        node.destroy_node()
        rclpy.try_shutdown(context=context)


def claim(node, allow_second=False):
    claimed = Single(node, "box", "box/valves")
    claimed.claim(allow_second)
    return claimed, node.create_publisher(String, "box/valves", 1)


def test_the_first_may_start_and_has_nothing_to_say(make):
    alone, _ = claim(make())
    assert alone.warning() == ""


def test_the_later_one_is_told_which_topic_the_first_publishes(make, monkeypatch):
    claim(make("/left"))
    monkeypatch.setattr(single, "DISCOVERY_TIME", 10.0)  # on a machine that is busy it takes longer
    with pytest.raises(ValueError, match="another box publishes /left/box/valves: .*allow_second"):
        claim(make("/left"))


def test_in_another_namespace_it_may_start(make):
    claim(make("/left"))
    claim(make("/right"))


def test_who_starts_all_the_same_is_warned(make):
    first, _ = claim(make())
    second, _ = claim(make(), allow_second=True)
    for claimed in (first, second):
        assert wait_until(claimed.warning, 20.0)
        assert claimed.warning().startswith("another box publishes /box/valves")
