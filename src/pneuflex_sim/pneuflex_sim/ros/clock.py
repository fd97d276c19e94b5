"""Pace and clock of the simulators: one of them publishes /clock, the others follow it.

Who follows never goes beyond the newest tick and tells on /clock_followers how far it has come. Who
leads waits for the slowest of them: the sequencers command both hands by the one clock, so a hand
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
    SECOND,
    Inbox,
    full_name,
    nanoseconds,
    stamp_of_seconds,
)

FOLLOWERS = "/clock_followers"
LEAD = 0.02  # by which a follower may be behind [s]
PATIENCE = 0.5  # wall time for which one tick waits for the followers [s]
MEMORY = 1.0  # wall time after which a follower that is silent is forgotten [s]
LARGEST_LAG = 1.0  # behind which a follower does not catch up, but jumps to the newest tick [s]
LATEST = 2**30  # [s], half of what a stamp can tell
ALONE = "publish_clock is false, and no /clock has come: another simulator must publish it"


class Pace:
    """Sleeps so that simulated over wall time stays at `limit` or below; 0 never sleeps."""

    def __init__(self, limit: float) -> None:
        self.limit = limit
        self.restart(0.0)

    def restart(self, simulated: float) -> None:
        """Begin to count at this simulated time [s]."""
        self._wall, self._simulated, self._now = time.monotonic(), simulated, simulated

    def wait(self, simulated: float) -> None:
        """Sleep until the wall clock has caught up; time that was lost is not made up for."""
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
    """The part of a simulator's clock that depends on who leads."""

    follows: bool

    def tell(self, now: float) -> None:
        """Tell the others the simulated time [s]."""

    def wait(self, timeout: float) -> None:
        """Wait up to `timeout` [s] of wall time for word of the others."""

    def allows(self, now: float) -> bool:
        """Whether the simulation may go on beyond its time [s]."""

    def jump(self, now: float) -> float:
        """By how much the simulation's time has to change at once [s]; 0 nearly always."""

    def warning(self) -> str:
        """What to say of the others; empty when all is well."""


class Told:
    """Times that others tell on a topic, in the stamps of std_msgs/Header, by their names.

    Who falls silent is forgotten after MEMORY.
    """

    def __init__(self, node: Node, topic: str) -> None:
        self._inbox = Inbox(node, Header, topic, RELIABLE)
        self._told: dict[str, tuple[int, float]] = {}  # time [ns], and when heard

    def hear(self, timeout: float = 0.0) -> None:
        """Take what has been told, or is within `timeout` [s] of wall time."""
        message = self._inbox.take(timeout)
        while message is not None:
            self._told[cut(message.frame_id)] = nanoseconds(message.stamp), time.monotonic()
            message = self._inbox.take()
        if self._told:
            oldest = time.monotonic() - MEMORY
            self._told = {name: told for name, told in self._told.items() if told[1] > oldest}

    def forget(self) -> None:
        """Forget all that was told."""
        self._told.clear()

    def names(self) -> list[str]:
        """Who has told a time of late."""
        return list(self._told)

    def times(self) -> list[int]:
        """What they have told last [ns]."""
        return [told for told, _ in self._told.values()]


class LeadingClock:
    """Publishes /clock and waits for those who follow; a `SharedClock`."""

    follows = False

    def __init__(self, node: Node) -> None:
        self._ticks = node.create_publisher(Clock, "/clock", RELIABLE)
        self.followers = Told(node, FOLLOWERS)

    def tell(self, now: float) -> None:
        """Publish a tick; then wait until nobody who follows is further behind than LEAD."""
        self._ticks.publish(Clock(clock=stamp_of_seconds(now)))
        self.wait(0.0)
        end = time.monotonic() + PATIENCE
        while self._behind(now) and (left := end - time.monotonic()) > 0:
            self.wait(left)

    def _behind(self, now: float) -> bool:
        oldest = (now - LEAD) * SECOND
        return any(told < oldest for told in self.followers.times())

    def wait(self, timeout: float) -> None:
        """Hear the followers."""
        self.followers.hear(timeout)

    def allows(self, now: float) -> bool:
        """Always."""
        return True

    def jump(self, now: float) -> float:
        """Never."""
        return 0.0

    def warning(self) -> str:
        """Nothing: it needs nobody."""
        return ""


class FollowingClock:
    """Follows /clock and tells how far it has come; a `SharedClock`."""

    follows = True

    def __init__(self, node: Node) -> None:
        self._inbox = Inbox(node, Clock, "/clock", NEWEST)
        self._told = node.create_publisher(Header, FOLLOWERS, RELIABLE)
        self._message = Header(frame_id=full_name(node, node.get_name()))
        self._newest: float | None = None

    def tell(self, now: float) -> None:
        """Tell who leads how far this simulation has come, once it follows."""
        if self._newest is not None:
            self._message.stamp = stamp_of_seconds(now)
            self._told.publish(self._message)

    def wait(self, timeout: float) -> None:
        """Wait for the next tick; one that no simulation can have is left alone."""
        tick = self._inbox.take(timeout)
        if tick is not None and 0 <= tick.clock.sec < LATEST:
            self._newest = nanoseconds(tick.clock) / SECOND

    def allows(self, now: float) -> bool:
        """Whether the newest tick lies ahead."""
        return self._newest is not None and now < self._newest - 1e-9

    def jump(self, now: float) -> float:
        """Onto the newest tick when it lies far ahead, or the clock was set back."""
        if self._newest is None:
            return 0.0
        ahead = self._newest - now
        return ahead if ahead > LARGEST_LAG or ahead < -LEAD else 0.0

    def warning(self) -> str:
        """That there is nobody to follow."""
        return ALONE if self._newest is None else ""


def shared_clock(node: Node, publish: bool) -> SharedClock:
    """The clock of a simulator that publishes /clock, or of one that follows another's."""
    return LeadingClock(node) if publish else FollowingClock(node)
