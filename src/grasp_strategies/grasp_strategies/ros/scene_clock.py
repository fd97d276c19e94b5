"""Time of the scene in ticks of `/clock`, and the lockstep with the simulator.

A strategy acts at ticks that are one control step apart. Its commands take effect half a tick
later, so that the simulator can go on meanwhile. The strategy publishes the time before which it
commands nothing more, and the simulator stops there. A run is therefore the same, however much wall
time any process takes.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable

from rclpy.clock import ROSClock
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
    now_of,
    seconds,
    stamp_of_seconds,
    subscribe_by_hand,
    take,
)

COMMANDED_UNTIL = "sim/commanded_until"
CLOCK_TICK = 0.01  # period of /clock, up to one physics step of the simulator [s]
COMMAND_LEAD = 0.005  # delay from a tick to the effect of the commands given at it [s]
# with a larger lag the simulator is not in lockstep, and its newest tick is used [s]
MAX_CLOCK_LAG = 0.1
STILL_CHECK_PERIOD = 0.5  # wall time between checks whether /clock still has a publisher [s]
# wall time after which a simulator in lockstep goes on without commands [s]
STANDSTILL_TIMEOUT = 5.0


class SceneClock:
    """The time of the scene, waits that `interrupt` can end, and the messages that keep the
    simulator in lockstep.

    All methods but `interrupt` and `wake` must be called from one thread.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self.interrupted = threading.Event()
        self._guard = GuardCondition(lambda: None, TakenByHand(), node.context)
        self._wait_set = rclpy_implementation.WaitSet(1, 1, 0, 0, 0, 0, node.context.handle)
        self._subscription = subscribe_by_hand(node, Clock, "/clock", TICKS)
        self._ticks: deque[float] = deque()
        self._newest: float | None = None
        self._published = node.create_publisher(Header, COMMANDED_UNTIL, RELIABLE)
        self._until = Header(frame_id=full_name(node, node.get_name()))
        self._due: float | None = None  # wall time of the next look, None when nothing runs [s]
        self._stood_still = 0.0  # the most by which a look was late [s]

    # ---------------------------------------------------------------- time
    @property
    def simulated(self) -> bool:
        """Whether the scene's time is that of `/clock`."""
        clock = self._node.get_clock()
        return isinstance(clock, ROSClock) and clock.ros_time_is_active

    @property
    def ticked(self) -> bool:
        """Whether a tick of `/clock` has come."""
        return self._newest is not None

    @property
    def now(self) -> float:
        """Time of the last tick taken, or of the node's clock without simulated time [s]."""
        if self.simulated:
            return self._newest or 0.0
        return now_of(self._node)

    @property
    def effect(self) -> float:
        """When a command that is given now takes effect [s]."""
        return self.now + (COMMAND_LEAD if self.simulated else 0.0)

    def forget(self) -> None:
        """Forget the ticks so far: they may come from a simulator that has ended."""
        self._receive_ticks()
        self._ticks.clear()
        self._newest = None

    def take(self, earliest: float) -> bool:
        """Advance to the first tick at or after `earliest` [s], or to one that jumps back; returns
        whether there was one.
        """
        self._receive_ticks()
        while self._ticks:
            tick, before = self._ticks.popleft(), self._newest
            self._newest = tick
            if before is not None and tick < before - 1e-9:
                return True
            if tick > earliest - 1e-9:
                if self._ticks and self._ticks[-1] - tick > MAX_CLOCK_LAG:
                    self._newest = self._ticks.pop()
                    self._ticks.clear()
                return True
        return False

    def _receive_ticks(self) -> None:
        while (message := take(self._subscription)) is not None:
            self._ticks.append(seconds(message.clock))

    # ---------------------------------------------------------------- waiting
    def pass_time(self, duration: float, check: Callable[[], None]) -> None:
        """Sleep until the time has advanced by `duration` [s] or `interrupt` was called.

        Simulated time may stand still as long as a node publishes `/clock` (a paused simulation).
        `check` is called at every wake-up.

        Raises:
            SceneError: nobody publishes `/clock` any more, or time jumps back because the simulator
                was reset; also what `check` raises.
        """
        self._pass(duration, self.effect + max(duration, CLOCK_TICK), check)

    def _pass(self, duration: float, until: float, check: Callable[[], None]) -> None:
        """As `pass_time`, announcing that nothing more is commanded before `until` [s]."""
        start = self.now
        self.publish_until(until)
        while not self._passed(start, duration) and not self.interrupted.is_set():
            check()
            if not self.simulated:
                self.wait(start + duration - self.now)
            elif not self.wait(STILL_CHECK_PERIOD, self._subscription):
                self._look_for_clock()
                self.publish_until(until)  # the simulator stops waiting for a silent commander
        self.refuse_standstill()
        if self.now < start - 1e-9:
            raise SceneError(
                f"time jumped back from {start:.3f} s to {self.now:.3f} s: "
                f"{clock_conflict(self._node) or 'simulator reset'}"
            )

    def _passed(self, start: float, duration: float) -> bool:
        if self.simulated:
            return self.take(start + max(duration, CLOCK_TICK) - COMMAND_LEAD)
        return self.now > start + duration - 1e-9

    def settle(self, check: Callable[[], None]) -> None:
        """Advance to the next tick, at which a simulator in lockstep stops with all its samples
        answered; `check` as in `pass_time`.
        """
        if self.simulated:
            self._pass(CLOCK_TICK, self.now + CLOCK_TICK, check)

    # ---------------------------------------------------------------- this process itself
    def watch(self) -> None:
        """Start to detect whether this process itself is stopped, for example by a signal."""
        self._due, self._stood_still = time.monotonic(), 0.0

    def unwatch(self) -> None:
        """End what `watch` has begun: no strategy runs."""
        self._due, self._stood_still = None, 0.0

    def refuse_standstill(self) -> None:
        """Raise SceneError if this process has been stopped since the last call. Then it has
        neither sent commands nor received messages, which is no fault of the other nodes.
        """
        self._look()
        still, self._stood_still = self._stood_still, 0.0
        if self.simulated and still > STANDSTILL_TIMEOUT:
            raise SceneError(f"this sequencer itself stood still for {still:.1f} s of wall time")

    def _look(self, wait: float = 0.0) -> None:
        """Keep by how much this call is late; the next is due in `wait` [s] of wall time."""
        if self._due is not None:
            now = time.monotonic()
            self._stood_still = max(self._stood_still, now - self._due)
            self._due = now + wait

    # ---------------------------------------------------------------- waits of wall time
    def _look_for_clock(self) -> None:
        """Raise SceneError when nobody publishes /clock any more."""
        if not self.interrupted.is_set() and not self._node.count_publishers("/clock"):
            raise SceneError("/clock has no publisher any more (has hand_sim ended?)")

    def await_tick(self, timeout: float) -> None:
        """Advance to the next tick if it comes within `timeout` [s] of wall time."""
        if self.simulated and not self.take(self.now + CLOCK_TICK - COMMAND_LEAD):
            self.wait(timeout, self._subscription)

    def wait(self, timeout: float, subscription: Subscription | None = None) -> bool:
        """Sleep, without the interpreter's lock, for `timeout` [s] of wall time, or until a message
        comes or `wake` is called; returns whether a message waits.
        """
        waits = self._wait_set
        waits.clear_entities()
        waits.add_guard_condition(self._guard.handle)
        if subscription is not None:
            waits.add_subscription(subscription.handle)
        self._look(max(0.0, timeout))
        waits.wait(max(0, int(timeout * 1e9)))
        self._look()
        return bool(subscription and waits.get_ready_entities("subscription"))

    def interrupt(self) -> None:
        """End a wait at once, from any thread; stays in force until `resume`."""
        self.interrupted.set()
        self.wake()

    def wake(self) -> None:
        """Make a wait check its conditions again, from any thread."""
        self._guard.trigger()

    def resume(self) -> None:
        """Clear an interrupt."""
        self.interrupted.clear()

    # ---------------------------------------------------------------- word to the simulator
    def publish_until(self, until: float | None = None) -> None:
        """Announce that nothing more is commanded before `until` [s]; None: before the end of the
        present tick.
        """
        if self.simulated:
            self._until.stamp = stamp_of_seconds(
                self.effect + CLOCK_TICK if until is None else until
            )
            self._published.publish(self._until)

    def release(self) -> None:
        """Announce that this node commands nothing any more."""
        self._until.stamp = stamp_of_seconds(0.0)
        self._published.publish(self._until)
