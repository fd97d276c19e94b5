"""The scene contract over ROS topics.

All calls but `interrupt` come from the strategy's thread. It takes the messages itself, and only
when it needs them: its subscriptions belong to a callback group that no executor serves, so that
500 messages a second cost neither a callback each nor the interpreter's lock. It sees the state of
the tick at which it acts, by the stamps, whatever has come since.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection
from functools import partial
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.node import Node
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState
from visualization_msgs.msg import MarkerArray

from grasp_strategies.ros.air_command import AirCommand
from grasp_strategies.ros.driver_calls import DriverCalls
from grasp_strategies.ros.marker_bytes import MarkerBytes
from grasp_strategies.ros.messages import (
    WORLD,
    Feed,
    read_air_state,
    read_force,
    read_modes,
    read_pose,
    read_touching,
)
from grasp_strategies.ros.object_command import ObjectCommand
from grasp_strategies.ros.reports import DRIVER, FAULT_MEMORY, SIMULATOR, Reports
from grasp_strategies.ros.scene_clock import SceneClock
from grasp_strategies.ros.stamped_bytes import POSE, WRENCH, StampedBytes
from grasp_strategies.scene import AirTarget, Array, Observation, SceneError
from softhand_ros.diagnostics import cut
from softhand_ros.topics import RELIABLE_DEEP, stamp_of_seconds, subscribe_by_hand, take

MASS_MODE, PRESSURE_MODE = "mass", "pressure"  # control modes
SILENCE_TIME = 0.5  # [s] of scene time without a message of a topic ...
SILENCE_WALL_TIME = 1.0  # [s] ... and of wall time: its publisher has gone
PUBLISHER_CHECK_PERIOD = 0.05  # [s] of wall time between two looks while waiting for publishers
STATE_TIMEOUT = 0.3  # [s] of wall time for which a tick waits for the state of its time


class TopicScene:
    """`grasp_strategies.scene.Scene` over the topics of simulator and driver.

    `hand_bodies`: which names in the namespaces of contact markers are parts of the hand. The
    channels are those of `pneumaticbox/state`, known after `connect`.
    """

    def __init__(self, node: Node, hand_bodies: frozenset[str]) -> None:
        self._node = node
        self.hand_bodies = hand_bodies
        self.channels: tuple[str, ...] = ()
        self._clock = SceneClock(node)
        self.interrupt, self.resume = self._clock.interrupt, self._clock.resume
        self.release = self._clock.release
        self._subscriptions: dict[str, Subscription] = {}
        self._of_bytes: dict[str, Callable[[bytes], Any] | None] = {}  # None: not serialised
        pose, wrench = (partial(StampedBytes, count=count) for count in (POSE, WRENCH))
        self._wrist = self._feed(PoseStamped, "wrist/pose", SIMULATOR, read_pose, pose)
        self._object = self._feed(PoseStamped, "scene/object_pose", SIMULATOR, read_pose, pose)
        self._force = self._feed(WrenchStamped, "wrist/wrench", SIMULATOR, read_force, wrench)
        self._contacts = self._feed(
            MarkerArray, "hand/contacts", SIMULATOR, read_touching, MarkerBytes
        )
        self._contacts.each_tick = False
        self._air = self._feed(JointState, "pneumaticbox/state", DRIVER, read_air_state)
        self.feeds = (self._wrist, self._object, self._force, self._contacts, self._air)
        self._wrist_target = node.create_publisher(PoseStamped, "wrist/target_pose", 10)
        self._reports = Reports(node)
        self._object_command = ObjectCommand(node, self._reports.names[SIMULATOR])
        self._air_command = AirCommand(node)
        node.create_subscription(DiagnosticArray, "/diagnostics", self._receive_diagnostics, 10)
        self._driver = DriverCalls(node)
        self._target = AirTarget(np.zeros(0), np.zeros(0))
        self._modes: tuple[str, ...] = ()  # of the channels, as switched last
        self._reported_modes: tuple[str, ...] = ()  # by a report since then

    def _feed(
        self,
        kind: type,
        topic: str,
        source: str,
        read: Callable[[Any], Any],
        of_bytes: Callable[[bytes], Any] | None = None,
    ) -> Feed:
        raw = of_bytes is not None
        subscription = subscribe_by_hand(self._node, kind, topic, RELIABLE_DEEP, raw)
        self._subscriptions[topic], self._of_bytes[topic] = subscription, of_bytes
        return Feed(topic, source, read)

    # ---------------------------------------------------------------- waiting for the others
    def connect(self, time_out: float, on_wait: Callable[[str], None] = lambda what: None) -> None:
        """Wait until every topic delivers messages and every command has a subscriber.

        `on_wait` is called with what is missing, and may raise SceneError to end the wait. Time in
        which a node reports that it is starting up does not count towards `time_out` [s] of wall
        time. Once all are connected, simulated time advances tick by tick, so that a strategy
        begins at the same simulated time in each run.

        Raises:
            SceneError: after `time_out`, naming what is missing and which node should provide it;
                and when interrupted.
        """
        self._clock.forget()
        for feed in self.feeds:
            while self._take(feed) is not None:
                pass  # what lies there may be from a simulator that has ended
            feed.forget()
        self._await_end_of(self._missing, time_out, on_wait)
        # both report once a second, also that a fault is over
        self._await_end_of(self._standing_fault, FAULT_MEMORY, on_wait)
        self.channels = self._air.value.channels
        nothing = np.full(len(self.channels), np.nan)
        self._target = AirTarget(nothing, nothing)
        reported = self._reported_modes or self._modes
        self._modes = reported if len(reported) == len(nothing) else (MASS_MODE,) * len(nothing)
        self._clock.watch()

    def check_object(self, names: Collection[str]) -> None:
        """Raise SceneError unless the simulator has an object of one of these names, or when it
        does not report one within FAULT_MEMORY.
        """
        self._await_end_of(self._object_unknown, FAULT_MEMORY)
        self._object_command.check(names)

    def _object_unknown(self) -> str:
        if self._object_command.name:
            return ""
        self._clock.publish_until()
        self._clock.wait(PUBLISHER_CHECK_PERIOD)
        return "the simulator's report of its object"

    def _await_end_of(
        self,
        obstacle: Callable[[], str],
        time_out: float,
        on_wait: Callable[[str], None] = lambda what: None,
    ) -> None:
        end = time.monotonic() + time_out
        while what := obstacle():
            on_wait(what)
            if self._clock.interrupted.is_set():
                raise SceneError(f"aborted while waiting: {what}")
            if self._reports.preparing:
                end = time.monotonic() + time_out
            if time.monotonic() > end:
                raise SceneError(f"after {time_out:g} s of waiting: {what}")

    def _standing_fault(self) -> str:
        """A fault that persists for a moment, in which the simulator stands still as well."""
        if fault := self._reports.fault:
            self._clock.publish_until()
            self._clock.wait(PUBLISHER_CHECK_PERIOD)
        return fault

    def _receive_diagnostics(self, message: DiagnosticArray) -> None:
        self._reports.receive(message)
        if modes := read_modes(message, self._reports.names[DRIVER]):
            self._reported_modes = modes
        self._object_command.receive(message)
        if self._reports.fault:
            self._clock.wake()  # a strategy that sleeps ends at once

    def _missing(self) -> str:
        """What is not available yet, by the node that should provide it; empty when nothing is
        missing.
        """
        absent = self._missing_listeners()
        if absent:
            self._clock.wait(PUBLISHER_CHECK_PERIOD)
            self._clock.take(self._clock.now)
        else:
            self._clock.publish_until()
            self._clock.await_tick(PUBLISHER_CHECK_PERIOD)
        self._catch_up()
        if self._clock.simulated and not self._clock.ticked:
            absent.setdefault(SIMULATOR, []).insert(0, "/clock")
        for feed in self.feeds:
            if self._silent(feed):
                absent.setdefault(feed.source, []).append(_complaint(feed))
        return "; ".join(
            f"{', '.join(parts)} ({self._reports.reason(source)})"
            for source, parts in absent.items()
        )

    def _missing_listeners(self) -> dict[str, list[str]]:
        """Commands without a subscriber, by the node that should subscribe."""
        absent: dict[str, list[str]] = {}
        if not self._wrist_target.get_subscription_count():
            absent[SIMULATOR] = [f"a subscriber of {self._wrist_target.topic_name}"]
        if listener := self._air_command.missing():
            absent[DRIVER] = [listener]
        if service := self._driver.missing():
            absent.setdefault(DRIVER, []).append(service)
        return absent

    # ---------------------------------------------------------------- time
    @property
    def time(self) -> float:
        """Time of the tick at which the strategy acts, or of the node's clock without simulated
        time [s].
        """
        return self._clock.now

    def step(self, duration: float) -> None:
        """Sleep until the scene's time has advanced by `duration` [s] or `interrupt` was called.

        Raises SceneError when time cannot advance (`SceneClock.pass_time`), and at once when driver
        or simulator report a fault.
        """
        self._air_command.repeat(self.time)
        self._clock.pass_time(duration, self._refuse_fault)

    # ---------------------------------------------------------------- commands
    def command_wrist(self, position: Array, orientation: Array) -> None:
        """Publish the target pose of the wrist: position (3,) [m], quaternion (4,); in simulated
        time it takes effect half a tick from now.
        """
        message = PoseStamped()
        message.header.stamp = stamp_of_seconds(self._clock.effect)
        message.header.frame_id = WORLD
        place, rotation = message.pose.position, message.pose.orientation
        place.x, place.y, place.z = map(float, position)
        rotation.x, rotation.y, rotation.z, rotation.w = map(float, orientation)
        self._wrist_target.publish(message)

    def hold_object(self, position: Array, orientation: Array) -> None:
        """Publish the pose at which the object is held out, position (3,) [m] and quaternion (4,)
        in the wrist frame; in simulated time it takes effect half a tick from now.

        Raises SceneError when nobody subscribes.
        """
        self._object_command.hold(position, orientation, self._clock.effect)

    def release_object(self, duration: float) -> None:
        """Publish that the holding spring fades within a duration [s]; takes effect and raises as
        `hold_object`.
        """
        self._object_command.release(duration, self._clock.effect)

    def command_air(self, masses: Array) -> None:
        """Publish target air masses (channels,) [kg above rest], NaN for a channel that keeps its
        command; in simulated time they take effect half a tick from now.
        """
        keeps = np.isnan(masses)
        self._command(
            AirTarget(
                np.where(keeps, self._target.masses, masses),
                np.where(keeps, self._target.pressures, np.nan),
            )
        )

    def command_pressure(self, pressures: Array) -> None:
        """Publish target gauge pressures (channels,) [Pa], NaN for a channel that keeps its
        command; they take effect as in `command_air`.

        A change of a channel's control mode takes one tick, at which the simulation stands still.
        Raises SceneError when the driver does not change the mode.
        """
        keeps = np.isnan(pressures)
        self._command(
            AirTarget(
                np.where(keeps, self._target.masses, np.nan),
                np.where(keeps, self._target.pressures, pressures),
            )
        )

    def _command(self, target: AirTarget) -> None:
        self._target = target
        modes = tuple(
            PRESSURE_MODE if np.isfinite(pressure) else MASS_MODE if np.isfinite(mass) else mode
            for mode, mass, pressure in zip(self._modes, *target, strict=True)
        )
        if modes != self._modes:
            self._clock.settle(self._refuse_fault)
            if refusal := self._driver.set_modes(modes):
                raise SceneError(refusal)
            self._modes, self._reported_modes = modes, ()
            self._clock.watch()  # the driver's answer may have taken long
        effect = self._clock.effect if self._clock.simulated else 0.0
        self._air_command.send(self.channels, target, self.time, effect)

    def take_air(self) -> None:
        """Begin to command the air; this and `go_on_holding` must be called in the executor's
        thread.
        """
        self._air_command.begin()

    def go_on_holding(self) -> bool:
        """After a strategy: keep the air in the hand, if there is any; returns whether there is."""
        self._clock.unwatch()
        return self._air_command.hold(obeyed=not self._reports.fault)

    def vent(self) -> None:
        """Let all air out, by the driver's service `vent`.

        When the driver does not confirm, all air is commanded out and SceneError is raised.
        """
        refusal = self._driver.vent()
        if not refusal:
            self._air_command.forget()
        else:
            if self.channels:
                self.command_air(np.zeros(len(self.channels)))
            raise SceneError(refusal)

    # ---------------------------------------------------------------- observation
    def _silent(self, feed: Feed) -> bool:
        """Whether the publisher of a topic has not begun, or has gone."""
        return feed.silent_for(self.time, time.monotonic(), SILENCE_TIME, SILENCE_WALL_TIME)

    def greatest_pressure(self) -> float:
        """Greatest gauge pressure of a channel as reported last [Pa]; NaN before a report."""
        air = self._air.value
        return math.nan if air is None else float(np.max(air.pressure))

    def observe(self) -> Observation:
        """Return the state at the scene's time. Raises SceneError when a topic, which the message
        names, has fallen silent, or when this process itself was stopped.
        """
        self._refuse_fault()
        self._catch_up()
        self._clock.refuse_standstill()
        for feed in self.feeds:
            if self._silent(feed):
                raise SceneError(
                    f"no usable message on {_complaint(feed)} for {SILENCE_TIME:g} s "
                    f"(has {feed.source} ended?)"
                )
        air = self._air.value
        if air.channels != self.channels:
            raise SceneError(
                f"pneumaticbox/state: expected the channels {self.channels}, "
                f"got {cut(str(air.channels))}"
            )
        return Observation(
            self.time,
            self._wrist.value.position,
            self._wrist.value.orientation,
            self._force.value,
            self._object.value.position,
            self._object.value.orientation,
            air.air_mass,
            air.pressure,
            self._contacts.value,
        )

    def _refuse_fault(self) -> None:
        self._clock.refuse_standstill()
        if fault := self._reports.fault:
            raise SceneError(fault)

    def _catch_up(self) -> None:
        """Take the messages of every topic up to the scene's time, waiting briefly for those of
        this tick.
        """
        for feed in self.feeds:
            there = self._follow(feed)
            if feed.each_tick and self._clock.ticked:
                feed.punctual = there or (feed.punctual and self._await(feed))

    def _await(self, feed: Feed) -> bool:
        """Wait for the message of a topic at the scene's time; whether it has come."""
        end = time.monotonic() + STATE_TIMEOUT
        while (left := end - time.monotonic()) > 0 and not self._clock.interrupted.is_set():
            self._clock.wait(left, self._subscriptions[feed.topic])
            if self._follow(feed):
                return True
        return False

    def _follow(self, feed: Feed) -> bool:
        return feed.follow(partial(self._take, feed), self.time, time.monotonic())

    def _take(self, feed: Feed) -> Any:
        message = take(self._subscriptions[feed.topic])
        of_bytes = self._of_bytes[feed.topic]
        return message if message is None or of_bytes is None else of_bytes(message)


def _complaint(feed: Feed) -> str:
    """Name of a topic, with the last refusal when messages came but none could be used."""
    return f"{feed.topic} (refused: {feed.last_refusal})" if feed.last_refusal else feed.topic
