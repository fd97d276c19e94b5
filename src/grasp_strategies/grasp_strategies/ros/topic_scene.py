"""The scene contract over ROS topics.

All calls but `interrupt` come from the strategy's thread. It takes the messages itself, the newest
of each topic and only when it needs them: its subscriptions belong to a callback group that no
executor serves, so that 500 messages a second cost neither a callback each nor the interpreter's
lock. Between two control steps it sleeps in a wait set on `/clock`.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.client import Client
from rclpy.guard_condition import GuardCondition
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.subscription import Subscription
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from visualization_msgs.msg import MarkerArray

from grasp_strategies.ros.messages import (
    WORLD,
    Feed,
    read_air_state,
    read_fault,
    read_force,
    read_pose,
    read_touching,
)
from grasp_strategies.scene import Array, Observation, SceneError
from softhand_ros.topics import (
    NEWEST,
    TakenByHand,
    clock_conflict,
    full_name,
    seconds,
    stamp_of_seconds,
    subscribe_by_hand,
    take,
)

SIMULATOR, DRIVER = "hand_sim", "driver"
REPORTERS = {"pneumaticbox": "the driver", "hand_sim": "the simulator"}  # by the node's name
SILENCE = 0.5  # [s] of scene time without a message of a topic ...
SILENCE_WALL = 1.0  # [s] ... and of wall time: its publisher has gone
FAULT_MEMORY = 2.5  # [s] of wall time after which a fault that is not taken back stands
VENT_TIME_OUT = 2.0  # [s] of wall time
LOOK_PERIOD = 0.05  # [s] of wall time between two looks while waiting for publishers
STILL_PERIOD = 0.5  # [s] of wall time after which a wait looks whether time has stopped


class TopicScene:
    """`grasp_strategies.scene.Scene` over the topics of simulator and driver.

    `hand_bodies`: names in the contact namespaces that are parts of the hand. The channels are
    those of `pneumaticbox/state`, known after `connect`.
    """

    def __init__(self, node: Node, hand_bodies: frozenset[str]) -> None:
        self._node = node
        self.hand_bodies = hand_bodies
        self.channels: tuple[str, ...] = ()
        self._interrupted = threading.Event()
        self._guard = GuardCondition(lambda: None, TakenByHand(), node.context)
        self._subscriptions: dict[str, Subscription] = {}
        self._clock_subscription = subscribe_by_hand(node, Clock, "/clock", NEWEST)
        self._simulated_time: float | None = None
        self._wait_set = rclpy_implementation.WaitSet(1, 1, 0, 0, 0, 0, node.context.handle)
        self._wrist = self._feed(PoseStamped, "wrist/pose", SIMULATOR, read_pose)
        self._object = self._feed(PoseStamped, "scene/object_pose", SIMULATOR, read_pose)
        self._force = self._feed(WrenchStamped, "wrist/wrench", SIMULATOR, read_force)
        self._contacts = self._feed(MarkerArray, "hand/contacts", SIMULATOR, read_touching)
        self._air = self._feed(JointState, "pneumaticbox/state", DRIVER, read_air_state)
        self.feeds = (self._wrist, self._object, self._force, self._contacts, self._air)
        self._wrist_target = node.create_publisher(PoseStamped, "wrist/target_pose", 10)
        self._air_command = node.create_publisher(JointTrajectory, "pneumaticbox/command", 10)
        self._faults: dict[str, str] = {}
        node.create_subscription(DiagnosticArray, "/diagnostics", self._hear_faults, 10)
        self._vent: Client = node.create_client(Trigger, "pneumaticbox/vent")

    def _feed(self, kind: type, topic: str, source: str, read: Any) -> Feed:
        self._subscriptions[topic] = subscribe_by_hand(self._node, kind, topic, NEWEST)
        return Feed(topic, source, read)

    # ---------------------------------------------------------------- waiting for the others
    def connect(self, time_out: float) -> None:
        """Wait until every topic delivers and every command has a listener.

        Raises SceneError after `time_out` [s] of wall time, which names what is missing and who
        should provide it, and when interrupted.
        """
        for feed in self.feeds:
            self._take(feed)  # what lies there may be from a simulator that has ended
            feed.forget()
        self._take_clock()
        self._simulated_time = None
        self._await_end_of(self._missing, time_out)
        # both tell once a second that a fault is over
        self._await_end_of(lambda: self._fault, FAULT_MEMORY)
        self.channels = self._air.value.channels

    def _await_end_of(self, obstacle: Callable[[], str], time_out: float) -> None:
        end = time.monotonic() + time_out
        while what := obstacle():
            if self._interrupted.wait(LOOK_PERIOD):
                raise SceneError(f"aborted while waiting: {what}")
            if time.monotonic() > end:
                raise SceneError(f"after {time_out:g} s of waiting: {what}")

    def _hear_faults(self, message: DiagnosticArray) -> None:
        for node, who in REPORTERS.items():
            fault = read_fault(message, full_name(self._node, node))
            if fault is not None:
                self._faults[node] = fault and f"{who} reports: {fault}"

    @property
    def _fault(self) -> str:
        """What driver and simulator report; empty when all is well."""
        return "; ".join(filter(None, self._faults.values()))

    def _missing(self) -> str:
        """What is not there yet, by who should provide it; empty when all is there."""
        self._take_clock()
        for feed in self.feeds:
            self._take(feed)
        absent: dict[str, list[str]] = {}
        if self._simulated and self._simulated_time is None:
            absent.setdefault(SIMULATOR, []).append("/clock")
        for feed in self.feeds:
            if feed.arrived is None:
                absent.setdefault(feed.source, []).append(_complaint(feed))
        for publisher, source in ((self._wrist_target, SIMULATOR), (self._air_command, DRIVER)):
            if not publisher.get_subscription_count():
                absent.setdefault(source, []).append(f"a subscriber of {publisher.topic_name}")
        if not self._vent.service_is_ready():  # no motion before it can be aborted
            absent.setdefault(DRIVER, []).append(f"the service {self._vent.srv_name}")
        return "; ".join(
            f"{', '.join(parts)} (is {source} running, and not paused?)"
            for source, parts in absent.items()
        )

    # ---------------------------------------------------------------- time
    @property
    def _simulated(self) -> bool:
        return bool(self._node.get_clock().ros_time_is_active)

    @property
    def time(self) -> float:
        """Time of the newest `/clock` taken, or of the node's clock without simulated time [s]."""
        if self._simulated:
            return self._simulated_time or 0.0
        return float(self._node.get_clock().now().nanoseconds * 1e-9)

    def step(self, duration: float) -> None:
        """Sleep until the scene's time has gone on by `duration` [s] or `interrupt` was called.

        Simulated time may stand still as long as somebody publishes `/clock` (a paused simulation).
        Raises SceneError when nobody does any more, when it stands and driver or simulator report a
        fault, and when time jumps back because the simulator was reset.
        """
        start = self.time
        while (left := start + duration - self.time) > 1e-9 and not self._interrupted.is_set():
            if self._simulated:
                self._await_clock()
            else:
                self._wait(left, clock=False)
            if self.time < start - 1e-9:
                raise SceneError(
                    f"time jumped back from {start:.3f} s to {self.time:.3f} s: "
                    f"{clock_conflict(self._node) or 'simulator reset'}"
                )

    def _await_clock(self) -> None:
        ticked = self._wait(STILL_PERIOD, clock=True)
        if not ticked and not self._interrupted.is_set():
            if self._fault:
                raise SceneError(self._fault)
            if not self._node.count_publishers("/clock"):
                raise SceneError("/clock has no publisher any more (has hand_sim ended?)")
        self._take_clock()

    def _wait(self, time_out: float, *, clock: bool) -> bool:
        """Sleep, without the interpreter's lock, until `/clock`, `interrupt` or time-out [s]."""
        waits = self._wait_set
        waits.clear_entities()
        waits.add_guard_condition(self._guard.handle)
        if clock:
            waits.add_subscription(self._clock_subscription.handle)
        waits.wait(max(0, int(time_out * 1e9)))
        return bool(clock and waits.get_ready_entities("subscription"))

    def interrupt(self) -> None:
        """End a wait at once, from any thread; holds until `resume`."""
        self._interrupted.set()
        self._guard.trigger()

    def resume(self) -> None:
        """Forget an interrupt."""
        self._interrupted.clear()

    # ---------------------------------------------------------------- commands
    def command_wrist(self, position: Array, orientation: Array) -> None:
        """Publish the target pose of the wrist: position (3,) [m], quaternion (4,)."""
        message = PoseStamped()
        message.header.stamp, message.header.frame_id = stamp_of_seconds(self.time), WORLD
        place, rotation = message.pose.position, message.pose.orientation
        place.x, place.y, place.z = map(float, position)
        rotation.x, rotation.y, rotation.z, rotation.w = map(float, orientation)
        self._wrist_target.publish(message)

    def command_air(self, masses: Array) -> None:
        """Publish target air masses (channels,) [kg above rest], valid at once."""
        point = JointTrajectoryPoint(positions=[float(mass) for mass in masses])
        self._air_command.publish(JointTrajectory(joint_names=list(self.channels), points=[point]))

    def vent(self) -> None:
        """Call the driver's vent.

        When it does not confirm, all air is commanded out and SceneError raised.
        """
        refusal = self._call_vent()
        if refusal:
            if self.channels:
                self.command_air(np.zeros(len(self.channels)))
            raise SceneError(refusal)

    def _call_vent(self) -> str:
        """Why the vent is not confirmed; empty when it is."""
        if not self._vent.wait_for_service(VENT_TIME_OUT):  # it may not be discovered yet
            return f"the service {self._vent.srv_name} is not there (is driver running?)"
        answered = threading.Event()
        future = self._vent.call_async(Trigger.Request())
        future.add_done_callback(lambda done: answered.set())
        if not answered.wait(VENT_TIME_OUT):
            return f"the service {self._vent.srv_name} did not answer within {VENT_TIME_OUT:g} s"
        answer = future.result()
        return "" if answer.success else f"the driver refused to vent: {answer.message}"

    # ---------------------------------------------------------------- observation
    def observe(self) -> Observation:
        """Return the newest of every topic; raises SceneError that names one that fell silent."""
        if self._fault:
            raise SceneError(self._fault)
        now, wall = self.time, time.monotonic()
        for feed in self.feeds:
            self._take(feed)
            if feed.silent_for(now, wall, SILENCE, SILENCE_WALL):
                raise SceneError(
                    f"no usable message on {_complaint(feed)} for {SILENCE:g} s "
                    f"(has {feed.source} ended?)"
                )
        air = self._air.value
        if air.channels != self.channels:
            raise SceneError(
                f"pneumaticbox/state: expected the channels {self.channels}, got {air.channels}"
            )
        return Observation(
            now,
            self._wrist.value.position,
            self._wrist.value.orientation,
            self._force.value,
            self._object.value.position,
            self._object.value.orientation,
            air.air_mass,
            air.pressure,
            self._contacts.value,
        )

    def _take(self, feed: Feed) -> None:
        message = take(self._subscriptions[feed.topic])
        if message is not None:
            feed.accept(message, self.time, time.monotonic())

    def _take_clock(self) -> None:
        tick = take(self._clock_subscription)
        if tick is not None:
            self._simulated_time = seconds(tick.clock)


def _complaint(feed: Feed) -> str:
    """Name of a topic, with the last refusal when messages came but none could be used."""
    return f"{feed.topic} (refused: {feed.last_refusal})" if feed.last_refusal else feed.topic
