"""One clock for several simulators, on real nodes: who waits for whom, and for how long."""

import time

import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from ros_domain import held_domain
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header

from pneuflex_sim.ros.clock import (
    FOLLOWER_MEMORY,
    FOLLOWER_TIMEOUT,
    FOLLOWERS,
    JOIN_TIMEOUT,
    MAX_FOLLOWER_LAG,
    NO_CLOCK_WARNING,
    shared_clock,
)
from pneuflex_sim.ros.driver_link import ANSWER_TIMEOUT
from softhand_ros.topics import RELIABLE, clock_conflict, stamp_of_seconds

pytestmark = pytest.mark.system
LIMIT = 10.0  # [s]


@pytest.fixture
def node():
    """Makes nodes in namespaces of a ROS domain of their own."""
    with held_domain() as domain:
        context, made = Context(), []
        rclpy.init(
            context=context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO
        )

        def make(namespace):
            settings = {"enable_rosout": False, "start_parameter_services": False}
            made.append(Node("hand_sim", namespace=namespace, context=context, **settings))
            return made[-1]

        yield make
        for one in made:
            one.destroy_node()
        rclpy.try_shutdown(context=context)


@pytest.fixture
def pair(node):
    """The clock that leads and one that follows, once they have found each other."""
    leading, following = node("left"), node("right")
    pair = shared_clock(leading, publish=True), shared_clock(following, publish=False)
    until(lambda: leading.count_publishers(FOLLOWERS) and following.count_publishers("/clock"))
    until(lambda: leading.count_subscribers("/clock"))
    time.sleep(0.2)  # until the readers are matched, too
    return pair


def until(condition):
    end = time.monotonic() + LIMIT
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def tick(leading, following, now):
    """A tick that has reached the one that follows."""
    leading.publish_time(now)
    until(lambda: following.wait(0.05) or following.newest == now)


def join(leading, following, now):
    """Who follows begins at this tick, which the leader has published."""
    tick(leading, following, now)
    until(lambda: following.publish_time(0.0) or following.jump(0.0))
    assert not following.allows(now)


def duration(call, *arguments):
    begin = time.monotonic()
    call(*arguments)
    return time.monotonic() - begin


def test_who_follows_begins_where_the_clock_is_and_never_goes_beyond_the_newest_tick(pair):
    leading, following = pair
    assert not following.allows(0.0)
    assert following.warning() == NO_CLOCK_WARNING
    tick(leading, following, 0.4)
    assert following.warning() == ""
    assert not following.allows(0.0)
    assert following.jump(0.0) == 0.0  # the leader does not know of it
    until(lambda: following.publish_time(0.0) or following.jump(0.0) == 0.4)
    leading.wait(0.0)
    assert leading.followers.names() == ["right/hand_sim"]
    assert following.jump(0.39) == 0.0
    assert following.allows(0.39)
    assert not following.allows(0.4)


def test_a_clock_whose_publisher_waits_for_nobody_is_followed_a_little_later(node):
    ticks, follower = node("left").create_publisher(Clock, "/clock", RELIABLE), node("right")
    following = shared_clock(follower, publish=False)
    until(ticks.get_subscription_count)
    ticks.publish(Clock(clock=stamp_of_seconds(0.4)))
    until(lambda: following.wait(0.05) or following.newest)
    begin = time.monotonic()
    until(lambda: following.publish_time(0.0) or following.jump(0.0))
    assert JOIN_TIMEOUT <= time.monotonic() - begin < 2 * JOIN_TIMEOUT


def test_a_clock_that_was_set_back_takes_who_follows_along(pair):
    leading, following = pair
    join(leading, following, 7.0)
    leading.publish_time(0.5)
    until(lambda: following.wait(0.05) or following.jump(7.0))
    assert following.jump(7.0) == -6.5


@pytest.mark.parametrize("sec", [-1, -(2**31), 2**31 - 1])
def test_a_tick_that_no_simulation_can_have_is_left_alone(pair, node, sec):
    leading, following = pair
    join(leading, following, 7.0)
    hostile = node("stranger").create_publisher(Clock, "/clock", RELIABLE)
    until(lambda: hostile.get_subscription_count())
    message = Clock()
    message.clock.sec = sec
    hostile.publish(message)
    following.wait(0.3)
    assert following.jump(7.0) == 0.0


def test_who_leads_waits_for_who_is_behind_and_forgets_who_falls_silent(pair):
    leading, following = pair
    tick(leading, following, 1.0)
    following.publish_time(1.0)
    until(lambda: leading.wait(0.05) or leading.followers.names())
    assert duration(leading.publish_time, 1.0 + 0.5 * MAX_FOLLOWER_LAG) < 0.5 * FOLLOWER_TIMEOUT
    assert duration(leading.publish_time, 2.0) >= FOLLOWER_TIMEOUT
    following.publish_time(2.0)
    time.sleep(0.1)
    assert duration(leading.publish_time, 2.01) < 0.5 * FOLLOWER_TIMEOUT
    time.sleep(ANSWER_TIMEOUT + 0.5)  # it waited for an answer of its driver that was lost
    assert duration(leading.publish_time, 3.0) >= FOLLOWER_TIMEOUT
    time.sleep(FOLLOWER_MEMORY - ANSWER_TIMEOUT)
    assert duration(leading.publish_time, 9.0) < 0.5 * FOLLOWER_TIMEOUT


def test_names_that_come_in_masses_are_cut_and_forgotten(pair, node):
    leading, _ = pair
    stranger = node("stranger")
    hostile = stranger.create_publisher(Header, FOLLOWERS, RELIABLE)
    until(lambda: hostile.get_subscription_count())
    for number in range(50):
        stamp = stamp_of_seconds(100.0)
        hostile.publish(Header(stamp=stamp, frame_id=f"{number}" + 100_000 * "x"))
        leading.wait(0.1)
    assert 0 < max(map(len, leading.followers.names())) <= 200
    time.sleep(1.1 * FOLLOWER_MEMORY)
    leading.wait(0.0)
    assert not leading.followers.names()


def test_a_second_publisher_of_the_clock_is_told(pair, node):
    third = node("third")
    until(lambda: third.count_publishers("/clock") == 1)
    assert clock_conflict(third) == ""
    third.create_publisher(Clock, "/clock", 10)
    until(lambda: third.count_publishers("/clock") == 2)
    assert clock_conflict(third).startswith("two nodes publish /clock: start all but one")
