"""Pace and clock of the simulators: one simulator publishes /clock, the others follow it.

A follower begins at the newest tick once the leader knows it, never goes beyond the newest tick,
and publishes its own time on /clock_followers. The leader waits for the slowest follower: the
sequencers command both hands by the one clock, so a hand that fell behind would be moved faster
than it is simulated.
"""

from __future__ import annotations

import math
import time
from typing import Protocol

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header

from softhand_ros.diagnostics import cut
from softhand_ros.topics import (
    NEWEST,
    RELIABLE,
    SECOND_NS,
    Inbox,
    full_name,
    nanoseconds,
    stamp_of_seconds,
)

FOLLOWERS = "/clock_followers"
# a message that fills the history of its publisher is acknowledged at once
PROGRESS = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
MAX_FOLLOWER_LAG = 0.02  # simulated time by which a follower may lag behind the leader [s]
FOLLOWER_TIMEOUT = 0.5  # wall time that the leader waits for followers after a tick [s]
# wall time after which a silent follower is forgotten [s]: it may wait for its driver
# (ANSWER_TIMEOUT) and then for its strategy (COMMANDER_MEMORY), each for 5 s
FOLLOWER_MEMORY = 12.0
JOIN_TIMEOUT = 5.0  # wall time that a follower waits until the leader knows it [s]
ACKNOWLEDGE_TIMEOUT = 0.05  # of it, for one message [s]
JUMP_LAG = 1.0  # a follower with a larger lag jumps to the newest tick [s]
MAX_CLOCK_SECONDS = 2**30  # [s], half of the range of a stamp
NO_CLOCK_WARNING = (
    "publish_clock is false, and no /clock has come: another simulator must publish it"
)


class Pace:
    """Sleeps so that simulated time passes at most `limit` times as fast as wall time; 0: never
    sleeps.
    """

    def __init__(self, limit: float) -> None:
        self.limit = limit
        self.restart(0.0)

    def restart(self, simulated: float) -> None:
        """Begin to count at this simulated time [s]."""
        self._wall, self._simulated, self._now = time.monotonic(), simulated, simulated

    def wait(self, simulated: float) -> None:
        """Sleep until wall time has reached this simulated time [s]. A simulation that was late
        does not run faster afterwards.
        """
        self._now = simulated
        if not self.limit:
            return
        ahead = (simulated - self._simulated) / self.limit - (time.monotonic() - self._wall)
        if ahead > 0:
            time.sleep(ahead)
        elif ahead < -0.1:
            self.restart(simulated)

    def factor(self) -> float:
        """Simulated over wall time since the last restart."""
        wall = time.monotonic() - self._wall
        return (self._now - self._simulated) / wall if wall > 0 else 0.0


class SharedClock(Protocol):
    """The part of a simulator's clock that differs between the simulator that publishes /clock and
    those that follow it."""

    follows: bool

    def publish_time(self, now: float) -> None:
        """Publish the simulated time [s]."""

    def wait(self, timeout: float) -> None:
        """Wait up to `timeout` [s] of wall time for messages of the other simulators."""

    def allows(self, now: float) -> bool:
        """Whether the simulation may go on beyond its present time `now` [s]."""

    def jump(self, now: float) -> float:
        """Change [s] that is due at once to the simulation's present time `now` [s]; 0 unless the
        clock jumps.
        """

    def warning(self) -> str:
        """A warning about the other simulators; empty when there is none."""


class ClockPeers:
    """Times that other nodes publish on a topic: stamps of std_msgs/Header, by node name.

    A node that has published nothing for `memory` [s] of wall time is forgotten.
    """

    def __init__(self, node: Node, topic: str, memory: float) -> None:
        self._inbox = Inbox(node, Header, topic, RELIABLE)
        self._memory = memory
        self._peers: dict[str, tuple[int, float]] = {}  # stamp [ns], wall time of arrival [s]

    def receive(self, timeout: float = 0.0) -> bool:
        """Take the messages that have come or come within `timeout` [s] of wall time; returns
        whether there was one.
        """
        message = self._inbox.take(timeout)
        came = message is not None
        while message is not None:
            self._peers[cut(message.frame_id)] = nanoseconds(message.stamp), time.monotonic()
            message = self._inbox.take()
        if self._peers:
            oldest = time.monotonic() - self._memory
            self._peers = {name: peer for name, peer in self._peers.items() if peer[1] > oldest}
        return came

    def forget(self) -> None:
        """Forget all peers."""
        self._peers.clear()

    def names(self) -> list[str]:
        """Names of the nodes that have published a time lately."""
        return list(self._peers)

    def times(self) -> list[int]:
        """Latest time [ns] of each node that has published one lately."""
        return [stamp for stamp, _ in self._peers.values()]


class LeadingClock:
    """The `SharedClock` of the simulator that publishes /clock: it waits for those that follow."""

    follows = False

    def __init__(self, node: Node) -> None:
        self._ticks = node.create_publisher(Clock, "/clock", RELIABLE)
        self.followers = ClockPeers(node, FOLLOWERS, FOLLOWER_MEMORY)

    def publish_time(self, now: float) -> None:
        """Publish a tick; then wait until no follower is further behind than MAX_FOLLOWER_LAG."""
        self._ticks.publish(Clock(clock=stamp_of_seconds(now)))
        self.wait(0.0)
        end = time.monotonic() + FOLLOWER_TIMEOUT
        while self._behind(now) and (left := end - time.monotonic()) > 0:
            self.wait(left)

    def _behind(self, now: float) -> bool:
        oldest = (now - MAX_FOLLOWER_LAG) * SECOND_NS
        return any(stamp < oldest for stamp in self.followers.times())

    def wait(self, timeout: float) -> None:
        """Receive the followers' times."""
        self.followers.receive(timeout)

    def allows(self, now: float) -> bool:
        """True always."""
        return True

    def jump(self, now: float) -> float:
        """0 always."""
        return 0.0

    def warning(self) -> str:
        """Always empty: the leader depends on nobody."""
        return ""


class FollowingClock:
    """The `SharedClock` of a simulator that keeps to /clock of another one, and publishes on
    /clock_followers how far it has come.

    It stands until the leader has received its time. A leader that did not know of it would run
    ahead; the jump that then makes up for the lag is, for the driver, a lack of samples. A /clock
    whose publisher waits for nobody is followed after JOIN_TIMEOUT.
    """

    follows = True

    def __init__(self, node: Node) -> None:
        self._inbox = Inbox(node, Clock, "/clock", NEWEST)
        self._progress = node.create_publisher(Header, FOLLOWERS, PROGRESS)
        self._message = Header(frame_id=full_name(node, node.get_name()))
        self._node = node
        self.newest: float | None = None  # tick [s]
        self._join_by = math.inf  # wall time [s]
        self._joined = self._began = False

    def publish_time(self, now: float) -> None:
        """Publish the time of this simulation for the leader, once a tick was received."""
        if self.newest is None:
            return
        self._message.stamp = stamp_of_seconds(now)
        self._progress.publish(self._message)
        if not self._joined:
            self._join_by = min(self._join_by, time.monotonic() + JOIN_TIMEOUT)
            self._joined = self._known() or time.monotonic() > self._join_by

    def _known(self) -> bool:
        """Whether all who subscribe to the followers' times, the leader too, have received this."""
        subscribed = self._node.count_subscribers(FOLLOWERS)
        return 0 < subscribed <= self._progress.get_subscription_count() and bool(
            self._progress.wait_for_all_acked(Duration(seconds=ACKNOWLEDGE_TIMEOUT))
        )

    def wait(self, timeout: float) -> None:
        """Wait for the next tick; a tick with an impossible time is ignored."""
        tick = self._inbox.take(timeout)
        if tick is not None and 0 <= tick.clock.sec < MAX_CLOCK_SECONDS:
            self.newest = nanoseconds(tick.clock) / SECOND_NS

    def allows(self, now: float) -> bool:
        """Whether the leader knows of this simulation, and the newest tick lies ahead."""
        return self._began and self.newest is not None and now < self.newest - 1e-9

    def jump(self, now: float) -> float:
        """Time [s] from `now` to the newest message of /clock in three cases: in the first call
        after the leader has received this simulator's time, if the clock is far ahead, and if it
        was set back. Otherwise 0.
        """
        if self.newest is None or not self._joined:
            return 0.0
        ahead = self.newest - now
        if not self._began:
            self._began = True
            return ahead
        return ahead if ahead > JUMP_LAG or ahead < -MAX_FOLLOWER_LAG else 0.0

    def warning(self) -> str:
        """A warning while no /clock has been received."""
        return NO_CLOCK_WARNING if self.newest is None else ""


def shared_clock(node: Node, publish: bool) -> SharedClock:
    """The clock of a simulator that publishes /clock, or of one that follows another's."""
    return LeadingClock(node) if publish else FollowingClock(node)
