"""Waiting for nodes and for simulated time, each wait with a limit."""

from __future__ import annotations

import time
from dataclasses import dataclass
from threading import Event
from typing import Protocol

from softhand_bringup.processes.launcher import Launcher

START_LIMIT = 90.0  # [s] of wall time; the first start compiles
STALL_LIMIT = 30.0  # wall time without a tick of the simulated clock [s]
TARES, TARE_PERIOD = 10, 0.2  # how often taring is tried, simulated time between two [s]


class RunFailed(RuntimeError):
    """What was begun cannot go on; the message says why."""


class Interrupted(Exception):
    """Somebody pressed Ctrl-C."""


class Listener(Protocol):
    """The ROS side that is listened to while time passes."""

    @property
    def simulated_time(self) -> float:
        """Newest time of the simulation [s]."""
        ...

    def spin(self, duration: float) -> None:
        """Listen for so much wall time [s]."""
        ...

    def tare(self) -> bool:
        """Let air masses count from here; False when the pressure does not stand still yet."""
        ...

    def missing(self) -> list[str]:
        """What is not there yet, in words."""
        ...

    def simulators(self) -> int:
        """How many there are in this ROS domain."""
        ...


@dataclass
class Patience:
    """Lets time pass on a running bench; every method raises what `check` does.

    Args:
        launcher: of the processes.
        listener: hears the simulated clock.
        stopped: set when the user wants to end.
    """

    launcher: Launcher
    listener: Listener
    stopped: Event

    def check(self) -> None:
        """Look whether all is well.

        Raises:
            NodeDied: a process ended by itself.
            Interrupted: `stopped` was set.
        """
        self.launcher.check()
        if self.stopped.is_set():
            raise Interrupted

    def wait_for_nodes(self) -> None:
        """Until nothing is missing; RunFailed names what still is after START_LIMIT."""
        end = time.monotonic() + START_LIMIT
        while missing := self.listener.missing():
            self.check()
            if time.monotonic() > end:
                raise RunFailed(f"not there after {START_LIMIT:.0f} s: {', '.join(missing)}")

    def let_pass(self, duration: float) -> None:
        """Let so much simulated time [s] pass; RunFailed if it stands still or two clocks tick."""
        listener = self.listener
        end, wall, before = listener.simulated_time + duration, time.monotonic(), -1.0
        while listener.simulated_time < end:
            self.check()
            if listener.simulated_time != before:
                before, wall = listener.simulated_time, time.monotonic()
            if listener.simulators() > 1:
                raise RunFailed(
                    "another simulator runs in this ROS domain: end it, or set ROS_DOMAIN_ID"
                )
            if time.monotonic() - wall > STALL_LIMIT:
                raise RunFailed(f"simulated time has stood still for {STALL_LIMIT:.0f} s")
            listener.spin(0.02)

    def tare(self) -> None:
        """Zero the estimate of the air mass; RunFailed when the pressure never stands still."""
        for _ in range(TARES):
            if self.listener.tare():
                return
            self.let_pass(TARE_PERIOD)
        raise RunFailed("the driver cannot be tared: the pressure does not stand still at rest")
