"""Lockstep, by which a run is the same each time: commands take effect at stamps of simulated time,
and the simulation does not pass the time until which it has been commanded.
"""

from __future__ import annotations

import time
from bisect import insort
from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from pneuflex_sim.ros.clock import Told
from softhand_ros.topics import RELIABLE, SECOND, Inbox, nanoseconds

COMMANDED_UNTIL = "sim/commanded_until"
COMMANDS_WAIT = 0.05  # wall time to wait for commanders before services are served [s]
LONGEST_LEAD = SECOND  # by which a target's stamp may be ahead; more is another clock's [ns]
AT_ONCE = 10  # commands that are taken at one look: more at a time are a storm


class Commanders:
    """Who commands the simulation, each until a time before which it will command nothing more.

    They tell it on `sim/commanded_until`: name and stamp, 0 when they command no longer. The
    simulation waits where it has reached such a time, until its commander goes on, falls silent or
    leaves.

    Args:
        node: whose topic it is.
        awaited: the simulation stands at its start until the first one commands.
    """

    def __init__(self, node: Node, awaited: bool) -> None:
        self._told = Told(node, COMMANDED_UNTIL)
        self._awaited = awaited
        self.restart()

    def restart(self) -> None:
        """The simulation is back at its start; who commanded it before does no longer."""
        self._told.hear()
        self._told.forget()
        self.awaited = self._awaited

    def hold(self, now: float, timeout: float = 0.0) -> bool:
        """Whether the simulation has to stand at its time `now` [s], after up to `timeout` [s] of
        wall time for word of its commanders.
        """
        end = time.monotonic() + timeout
        self._told.hear()
        while held := self._holds(round(now * SECOND)):
            left = end - time.monotonic()
            if left <= 0:
                break
            self._told.hear(left)
        return held

    def _holds(self, now: int) -> bool:
        until = [told for told in self._told.times() if told]
        if until:
            self.awaited = False
        return self.awaited or any(told <= now for told in until)


class StampedCommands:
    """Commands of a topic, each of which takes effect at the stamp of its header.

    One that comes late, or bears no stamp or that of another clock, takes effect when it comes.

    Args:
        node: whose topic it is.
        kind: of the message.
        topic: its name.
        command: does what a message says, or raises ValueError.
        refuse: is told why a message cannot be used.
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
        """Forget the commands that wait for their time."""
        self._waiting.clear()

    def obey(self, now: float) -> None:
        """Take what has come, and obey what takes effect until `now` [s]."""
        instant = round(now * SECOND)
        for _ in range(AT_ONCE):
            message = self._inbox.take()
            if message is None:
                break
            stamp = nanoseconds(message.header.stamp)
            if instant < stamp <= instant + LONGEST_LEAD:
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
