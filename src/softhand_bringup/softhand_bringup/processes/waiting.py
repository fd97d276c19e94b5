"""Waits for nodes and for simulated time, with a limit for each wait."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from threading import Event
from typing import Protocol

from softhand_bringup.processes.launcher import Launcher

# Limits of wall time for a process that hangs; one that ends is noticed at once. They are long, as
# a busy machine may be slow without a fault.
SUITE_START_LIMIT = 300.0  # for the start of nodes, which may have to compile kernels [s]
STALL_LIMIT = 60.0  # without progress of simulated time [s]
TARES, TARE_PERIOD = 10, 0.2  # number of attempts, simulated time between them [s]


class RunFailed(RuntimeError):
    """A run cannot continue; the message says why."""


class Interrupted(Exception):
    """The user has asked to end the run."""


class Listener(Protocol):
    """The ROS client that receives messages while time passes."""

    @property
    def simulated_time(self) -> float:
        """Latest simulated time [s]."""
        ...

    def spin(self, duration: float) -> None:
        """Receive messages for this wall time [s]."""
        ...

    def tare(self) -> bool:
        """Set the current air masses to zero; False while the pressure is not constant yet."""
        ...

    def missing(self) -> list[str]:
        """Missing nodes and topics, in words."""
        ...

    def simulators(self) -> int:
        """Number of simulators in this ROS domain."""
        ...


class Progress:
    """Checks that simulated time advances."""

    def __init__(self) -> None:
        self._time, self._since = -1.0, time.monotonic()

    def check(self, simulated_time: float) -> None:
        """Raise RunFailed when the simulated time [s] has not changed for STALL_LIMIT [s] of wall
        time.
        """
        if simulated_time != self._time:
            self._time, self._since = simulated_time, time.monotonic()
        if time.monotonic() - self._since > STALL_LIMIT:
            raise RunFailed(f"simulated time has stood still for {STALL_LIMIT:.0f} s")


@dataclass
class Waits:
    """Waits while nodes run; every method also raises the errors of `check`.

    Args:
        launcher: launcher of the nodes.
        listener: receives the simulated clock.
        stopped: set when the user wants to end.
    """

    launcher: Launcher
    listener: Listener
    stopped: Event

    def check(self) -> None:
        """Check the processes and the user's wish to end.

        Raises:
            NodeDied: a process ended by itself.
            Interrupted: `stopped` was set.
        """
        self.launcher.check()
        if self.stopped.is_set():
            raise Interrupted

    def wait_for_nodes(self) -> None:
        """Wait until all expected nodes and topics are there; raises RunFailed after
        SUITE_START_LIMIT [s].
        """
        end = time.monotonic() + SUITE_START_LIMIT
        while missing := self.listener.missing():
            self.check()
            if time.monotonic() > end:
                raise RunFailed(f"not there after {SUITE_START_LIMIT:.0f} s: {', '.join(missing)}")

    def wait_until(self, condition: Callable[[], bool], what: str) -> None:
        """Receive messages until a condition holds; raises RunFailed after STALL_LIMIT [s] of wall
        time, with `what` as the name of what is missing.
        """
        end = time.monotonic() + STALL_LIMIT
        while not condition():
            self.check()
            if time.monotonic() > end:
                raise RunFailed(f"not there after {STALL_LIMIT:.0f} s: {what}")
            self.listener.spin(0.02)

    def let_pass(self, duration: float) -> None:
        """Wait for this simulated time [s]; raises RunFailed if simulated time does not advance or
        a second simulator runs.
        """
        listener, progress = self.listener, Progress()
        end = listener.simulated_time + duration
        while listener.simulated_time < end:
            self.check()
            progress.check(listener.simulated_time)
            if listener.simulators() > 1:
                raise RunFailed(
                    "another simulator runs in this ROS domain: end it, or set ROS_DOMAIN_ID"
                )
            listener.spin(0.02)

    def tare(self) -> None:
        """Tare the air masses; raises RunFailed when the pressure does not become constant."""
        for _ in range(TARES):
            if self.listener.tare():
                return
            self.let_pass(TARE_PERIOD)
        raise RunFailed("the driver cannot be tared: the pressure at rest is not constant")
