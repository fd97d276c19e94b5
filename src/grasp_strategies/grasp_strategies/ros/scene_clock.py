"""The scene's time: `/clock` tick by tick, and how far a simulator in lockstep may go.

A strategy acts at ticks that lie a control step apart. What it commands takes effect half a tick
later, so that the simulator goes on meanwhile; it is told the time before which nothing more is
commanded, and stands there. So a run is the same whatever the wall time that anybody takes.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from rclpy.guard_condition import GuardCondition
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.subscription import Subscription
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header

from grasp_strategies.scene import SceneError
from softhand_ros.topics import (
    RELIABLE,
    TICKS,
    TakenByHand,
    clock_conflict,
    full_name,
    seconds,
    stamp_of_seconds,
    subscribe_by_hand,
    take,
)

COMMANDED_UNTIL = "sim/commanded_until"
TICK = 0.01  # from tick to tick, to a step of the simulator's physics [s]
LEAD = 0.005  # from a tick until the commands take effect that are given at it [s]
BEHIND = 0.1  # a simulator so far ahead waits for nobody, and is followed by its newest tick [s]
STILL_PERIOD = 0.5  # wall time after which a wait looks whether time has stopped [s]


class SceneClock:
    """Time of the scene, waits that `interrupt` ends, and word to the simulator.

    All calls but `interrupt` come from one thread.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self.interrupted = threading.Event()
        self._guard = GuardCondition(lambda: None, TakenByHand(), node.context)
        self._wait_set = rclpy_implementation.WaitSet(1, 1, 0, 0, 0, 0, node.context.handle)
        self._subscription = subscribe_by_hand(node, Clock, "/clock", TICKS)
        self._ticks: deque[float] = deque()
        self._newest: float | None = None
        self._told = node.create_publisher(Header, COMMANDED_UNTIL, RELIABLE)
        self._until = Header(frame_id=full_name(node, node.get_name()))

    # ---------------------------------------------------------------- time
    @property
    def simulated(self) -> bool:
        """Whether time is that of `/clock`."""
        return bool(self._node.get_clock().ros_time_is_active)

    @property
    def ticked(self) -> bool:
        """Whether a tick has come."""
        return self._newest is not None

    @property
    def now(self) -> float:
        """Time of the last tick taken, or of the node's clock without simulated time [s]."""
        if self.simulated:
            return self._newest or 0.0
        return float(self._node.get_clock().now().nanoseconds * 1e-9)

    @property
    def effect(self) -> float:
        """When a command takes effect that is given now [s]."""
        return self.now + (LEAD if self.simulated else 0.0)

    def forget(self) -> None:
        """Forget the ticks so far: they may be of a simulator that has ended."""
        self._hear()
        self._ticks.clear()
        self._newest = None

    def take(self, earliest: float) -> bool:
        """Go on to the first tick from `earliest` [s] on, or onto one that jumps back; whether it
        has come.
        """
        self._hear()
        while self._ticks:
            tick, before = self._ticks.popleft(), self._newest
            self._newest = tick
            if before is not None and tick < before - 1e-9:
                return True
            if tick > earliest - 1e-9:
                if self._ticks and self._ticks[-1] - tick > BEHIND:
                    self._newest = self._ticks.pop()
                    self._ticks.clear()
                return True
        return False

    def _hear(self) -> None:
        while (message := take(self._subscription)) is not None:
            self._ticks.append(seconds(message.clock))

    # ---------------------------------------------------------------- waiting
    def pass_time(self, duration: float, check: Callable[[], None]) -> None:
        """Sleep until the time has gone on by `duration` [s] or `interrupt` was called.

        Simulated time may stand still as long as somebody publishes `/clock` (a paused simulation).
        Raises SceneError when nobody does any more, when time jumps back because the simulator was
        reset, and what `check` raises, which is called at every wake.
        """
        self._pass(duration, self.effect + max(duration, TICK), check)

    def _pass(self, duration: float, until: float, check: Callable[[], None]) -> None:
        """Pass time as `pass_time`, telling that nothing more is commanded before `until` [s]."""
        start = self.now
        self.tell(until)
        while not self._passed(start, duration) and not self.interrupted.is_set():
            check()
            if not self.simulated:
                self.wait(start + duration - self.now)
            elif not self.wait(STILL_PERIOD, self._subscription):
                self._look_for_clock()
                self.tell(until)  # who falls silent is waited for no longer
        if self.now < start - 1e-9:
            raise SceneError(
                f"time jumped back from {start:.3f} s to {self.now:.3f} s: "
                f"{clock_conflict(self._node) or 'simulator reset'}"
            )

    def _passed(self, start: float, duration: float) -> bool:
        if self.simulated:
            return self.take(start + max(duration, TICK) - LEAD)
        return self.now > start + duration - 1e-9

    def settle(self, check: Callable[[], None]) -> None:
        """Go on to the next tick and have a simulator in lockstep stand there, with all its samples
        answered; `check` as in `pass_time`.
        """
        if self.simulated:
            self._pass(TICK, self.now + TICK, check)

    def _look_for_clock(self) -> None:
        """Raise SceneError when nobody publishes /clock any more."""
        if not self.interrupted.is_set() and not self._node.count_publishers("/clock"):
            raise SceneError("/clock has no publisher any more (has hand_sim ended?)")

    def await_tick(self, timeout: float) -> None:
        """Go on to the next tick if it comes within `timeout` [s] of wall time."""
        if self.simulated and not self.take(self.now + TICK - LEAD):
            self.wait(timeout, self._subscription)

    def wait(self, timeout: float, subscription: Subscription | None = None) -> bool:
        """Sleep, without the interpreter's lock, for `timeout` [s] of wall time, or until a message
        comes or `wake` is called; whether a message waits.
        """
        waits = self._wait_set
        waits.clear_entities()
        waits.add_guard_condition(self._guard.handle)
        if subscription is not None:
            waits.add_subscription(subscription.handle)
        waits.wait(max(0, int(timeout * 1e9)))
        return bool(subscription and waits.get_ready_entities("subscription"))

    def interrupt(self) -> None:
        """End a wait at once, from any thread; holds until `resume`."""
        self.interrupted.set()
        self.wake()

    def wake(self) -> None:
        """Have a wait look at what has changed, from any thread."""
        self._guard.trigger()

    def resume(self) -> None:
        """Forget an interrupt."""
        self.interrupted.clear()

    # ---------------------------------------------------------------- word to the simulator
    def tell(self, until: float | None = None) -> None:
        """Tell that nothing more is commanded before `until` [s], or at the present tick."""
        if self.simulated:
            self._until.stamp = stamp_of_seconds(self.effect + TICK if until is None else until)
            self._told.publish(self._until)

    def release(self) -> None:
        """Tell that nothing is commanded any more."""
        self._until.stamp = stamp_of_seconds(0.0)
        self._told.publish(self._until)
