"""Topics of the box: commands, states and pressures, each at its rate."""

from __future__ import annotations

import array
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from numpy.typing import NDArray
from rclpy.node import Node
from sensor_msgs.msg import FluidPressure, JointState
from trajectory_msgs.msg import JointTrajectory

from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.box.commands import TrajectoryPoint
from pneumaticbox_driver.box.diagnostics import CommandTraffic
from softhand_ros.topics import EACH_STEP, RELIABLE, Due, has_subscribers, seconds

BOX_COMMAND, BOX_SCHEDULE = "pneumaticbox/command", "pneumaticbox/valve_schedule"
BOX_STATE = "pneumaticbox/state"
PRESSURE_RATE = 25.0  # of the FluidPressure topics [Hz]


def points_of(message: JointTrajectory) -> list[TrajectoryPoint]:
    """The points of a message as TrajectoryPoints."""
    return [
        TrajectoryPoint(
            seconds(point.time_from_start), point.positions, point.velocities, point.effort
        )
        for point in message.points
    ]


class Commands:
    """The two topics for commands to the box.

    Args:
        node: the node that subscribes.
        handlers: functions by topic, called with a message's names, points and stamp [s], and the
            present time [s].
        now: returns the present time of the box [s].
        of_stamp: returns the time of the box [s] for a message's stamp [s].
        refuse: called with the reason when a message is refused.
        accepted: called after a valid message.
    """

    def __init__(
        self,
        node: Node,
        handlers: dict[str, Callable[..., None]],
        now: Callable[[], float],
        of_stamp: Callable[[float], float],
        refuse: Callable[[str], None],
        accepted: Callable[[], None],
    ) -> None:
        self.traffic = CommandTraffic()
        self._handlers = handlers
        self._now, self._of_stamp = now, of_stamp
        self._refuse, self._accepted = refuse, accepted
        self._subscriptions = {
            # rclpy passes information on the message as a second argument, not in its annotation
            topic: node.create_subscription(JointTrajectory, topic, self._taker(topic), RELIABLE)  # type: ignore[arg-type]
            for topic in handlers
        }

    def count_commanders(self) -> None:
        """Count the nodes that have sent commands recently; a restarted node counts once."""
        publishers = max(s.get_publisher_count() for s in self._subscriptions.values())
        self.traffic.commanders = min(publishers, self.traffic.speakers(time.monotonic()))

    def _taker(self, topic: str) -> Callable[[JointTrajectory, Any], None]:
        def take(message: JointTrajectory, info: Any) -> None:
            count = self._subscriptions[topic].get_publisher_count
            sequence = info["publication_sequence_number"]
            self.traffic.note(time.monotonic(), topic, sequence, count)
            self._take(topic, message)

        return take

    def _take(self, topic: str, message: JointTrajectory) -> None:
        stamp, names = seconds(message.header.stamp), message.joint_names
        points = points_of(message)
        try:
            self._handlers[topic](names, points, self._of_stamp(stamp), self._now())
        except ValueError as error:
            self._refuse(f"{topic}: {error}")
        else:
            self._accepted()


class StateTopics:
    """The topics with the state of the box.

    Args:
        node: the node that publishes.
        box: the box whose state is published.
        channel_deviation: standard deviation of the channel sensors [Pa].
        supply_deviation: standard deviation of the supply's sensor [Pa].
        state_rate: rate of `pneumaticbox/state` [Hz]; 0: at every sample.
    """

    def __init__(
        self,
        node: Node,
        box: PneumaticBox,
        channel_deviation: float,
        supply_deviation: float,
        state_rate: float,
    ) -> None:
        channels = box.settings.channels
        self._box = box
        self._state_out = node.create_publisher(JointState, BOX_STATE, EACH_STEP)
        self._state = JointState(name=list(channels))
        names = (*channels, "supply")
        self._pressure_out = [
            node.create_publisher(FluidPressure, f"pneumaticbox/{name}/pressure", EACH_STEP)
            for name in names
        ]
        deviations = [channel_deviation] * len(channels) + [supply_deviation]
        self._pressure = [FluidPressure(variance=deviation**2) for deviation in deviations]
        self._slot = 0
        self.state_due = Due(state_rate)

    def publish(self, stamp: Time, pressures_abs: NDArray[np.float64]) -> None:
        """Publish pressures and estimated state, if anyone subscribes.

        pressures_abs: absolute pressures [Pa] of the n channels and the supply.
        """
        if self.state_due(seconds(stamp)) and has_subscribers(self._state_out):
            self._publish_state(stamp)
        self._publish_pressures(stamp, pressures_abs)

    def _publish_state(self, stamp: Time) -> None:
        state, box = self._state, self._box
        state.header.stamp = stamp
        state.position = array.array("d", box.observer.mass.tolist())
        state.velocity = array.array("d", box.observer.flow.tolist())
        state.effort = array.array("d", box.pressures.tolist())
        self._state_out.publish(state)

    def _publish_pressures(self, stamp: Time, pressures_abs: NDArray[np.float64]) -> None:
        """Publish the sensors in turn, each at PRESSURE_RATE, spread over the samples."""
        n = len(self._pressure)
        slot = int(seconds(stamp) * PRESSURE_RATE * n)
        for due in range(max(self._slot + 1, slot - n + 1), slot + 1):
            if not has_subscribers(self._pressure_out[due % n]):
                continue
            message = self._pressure[due % n]
            message.header.stamp = stamp
            message.fluid_pressure = float(pressures_abs[due % n])
            self._pressure_out[due % n].publish(message)
        self._slot = slot
