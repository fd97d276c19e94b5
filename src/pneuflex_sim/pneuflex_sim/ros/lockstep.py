"""Lockstep, which makes runs repeatable: commands take effect at stamps of simulated time, and the
simulation waits at the time up to which it has received all commands.
"""

from __future__ import annotations

import time
from bisect import insort
from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from pneuflex_sim.ros.clock import ClockPeers
from softhand_ros.topics import RELIABLE, SECOND_NS, Inbox, nanoseconds

COMMANDED_UNTIL = "sim/commanded_until"
COMMANDS_WAIT = 0.05  # wall time to wait for commanders before services are served [s]
COMMANDER_MEMORY = 5.0  # wall time after which a silent commander is forgotten [s]
MAX_STAMP_LEAD = SECOND_NS  # by which a target's stamp may be ahead; more is another clock's [ns]
MAX_COMMANDS_AT_ONCE = 10  # commands that are taken at one look: more at a time are a storm


class Commanders:
    """The nodes that command the simulation. Each publishes the time up to which it has sent all
    its commands.

    They publish on `sim/commanded_until`: name and stamp, 0 when they stop commanding. The
    simulation stops at the earliest of these times until its commander goes on, falls silent or
    ends.

    Args:
        node: the node that subscribes.
        awaited: whether the simulation waits at its start until the first node commands.
    """

    def __init__(self, node: Node, awaited: bool) -> None:
        self._peers = ClockPeers(node, COMMANDED_UNTIL, COMMANDER_MEMORY)
        self._awaited, self._heard = awaited, False
        self._until = 0  # earliest time until which a node has commanded, 0 without one [ns]
        self.restart()

    def restart(self) -> None:
        """Forget all commanders: the simulation is back at its start."""
        self._peers.receive()
        self._peers.forget()
        self.awaited, self._until = self._awaited, 0

    @property
    def commanding(self) -> bool:
        """Whether a node commands at present."""
        return self._until > 0

    def hold(self, now: float, timeout: float = 0.0) -> bool:
        """Whether the simulation must wait at its time `now` [s], after waiting up to `timeout` [s]
        of wall time for messages of the commanders. While all commanders have sent their commands
        beyond `now`, messages are not read, as they take effect later.
        """
        instant = round(now * SECOND_NS)
        if self._until > instant:
            return False
        end = time.monotonic() + timeout
        self._receive()
        while held := self.awaited or 0 < self._until <= instant:
            left = end - time.monotonic()
            if left <= 0:
                break
            self._receive(left)
        return held

    def heard(self) -> bool:
        """Whether a commander has published a new time since the last call. Its commands up to that
        time have arrived, as it publishes them first.
        """
        heard, self._heard = self._heard, False
        return heard

    def _receive(self, timeout: float = 0.0) -> None:
        self._heard |= self._peers.receive(timeout)
        self._until = min((stamp for stamp in self._peers.times() if stamp > 0), default=0)
        self.awaited &= not self._until


class StampedCommands:
    """Commands of a topic, each of which takes effect at the stamp of its header.

    A message that comes late, has no stamp, or is stamped by another clock takes effect on arrival.

    Args:
        node: the node that subscribes.
        kind: type of the message.
        topic: name of the topic.
        command: applies a message, or raises ValueError.
        refuse: called with the reason when a message cannot be used.
    """

    def __init__(
        self,
        node: Node,
        kind: type,
        topic: str,
        command: Callable[[Any], None],
        refuse: Callable[[str], None],
    ) -> None:
        self._inbox = Inbox(node, kind, topic, RELIABLE)
        self._topic, self._command, self._refuse = topic, command, refuse
        self._waiting: list[tuple[int, Any]] = []  # by time [ns]

    def forget(self) -> None:
        """Drop the commands that have not taken effect yet."""
        self._waiting.clear()

    def obey(self, now: float, look: bool = True) -> None:
        """Receive messages, if `look`, and apply all commands with stamps up to `now` [s]."""
        instant = round(now * SECOND_NS)
        for _ in range(MAX_COMMANDS_AT_ONCE if look else 0):
            message = self._inbox.take()
            if message is None:
                break
            stamp = nanoseconds(message.header.stamp)
            if instant < stamp <= instant + MAX_STAMP_LEAD:
                insort(self._waiting, (stamp, message), key=lambda waiting: waiting[0])
            else:
                self._obey(message)
        while self._waiting and self._waiting[0][0] <= instant:
            self._obey(self._waiting.pop(0)[1])

    def _obey(self, message: Any) -> None:
        try:
            self._command(message)
        except ValueError as error:
            self._refuse(f"{self._topic}: {error}")
