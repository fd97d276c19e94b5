"""Pace and clock of the simulators: one simulator publishes /clock, the others follow it.

A follower never goes beyond the newest tick, and publishes its own time on /clock_followers. The
leader waits for the slowest follower: the sequencers command both hands by the one clock, so a hand
that fell behind would be moved faster than it is simulated.
"""

from __future__ import annotations

import time
from typing import Protocol

from rclpy.node import Node
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
MAX_FOLLOWER_LAG = 0.02  # simulated time by which a follower may lag behind the leader [s]
FOLLOWER_TIMEOUT = 0.5  # wall time that the leader waits for followers after a tick [s]
# wall time after which a silent follower is forgotten [s]: it may wait for its driver
# (ANSWER_TIMEOUT) and then for its strategy (COMMANDER_MEMORY), each for 5 s
FOLLOWER_MEMORY = 12.0
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
    """

    follows = True

    def __init__(self, node: Node) -> None:
        self._inbox = Inbox(node, Clock, "/clock", NEWEST)
        self._progress = node.create_publisher(Header, FOLLOWERS, RELIABLE)
        self._message = Header(frame_id=full_name(node, node.get_name()))
        self._newest: float | None = None

    def publish_time(self, now: float) -> None:
        """Publish the time of this simulation for the leader, once a tick was received."""
        if self._newest is not None:
            self._message.stamp = stamp_of_seconds(now)
            self._progress.publish(self._message)

    def wait(self, timeout: float) -> None:
        """Wait for the next tick; a tick with an impossible time is ignored."""
        tick = self._inbox.take(timeout)
        if tick is not None and 0 <= tick.clock.sec < MAX_CLOCK_SECONDS:
            self._newest = nanoseconds(tick.clock) / SECOND_NS

    def allows(self, now: float) -> bool:
        """Whether the newest tick lies ahead."""
        return self._newest is not None and now < self._newest - 1e-9

    def jump(self, now: float) -> float:
        """Time [s] from `now` to the newest message of /clock if that is far ahead or the clock was
        set back; else 0.
        """
        if self._newest is None:
            return 0.0
        ahead = self._newest - now
        return ahead if ahead > JUMP_LAG or ahead < -MAX_FOLLOWER_LAG else 0.0

    def warning(self) -> str:
        """A warning while no /clock has been received."""
        return NO_CLOCK_WARNING if self._newest is None else ""


def shared_clock(node: Node, publish: bool) -> SharedClock:
    """The clock of a simulator that publishes /clock, or of one that follows another's."""
    return LeadingClock(node) if publish else FollowingClock(node)
