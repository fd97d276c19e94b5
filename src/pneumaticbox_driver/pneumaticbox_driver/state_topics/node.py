"""Publishes `pneumaticbox/state` at every sample, and the sensors in turn, decimated."""

from __future__ import annotations

import array

import numpy as np
from builtin_interfaces.msg import Time
from numpy.typing import NDArray
from rclpy.node import Node
from sensor_msgs.msg import FluidPressure, JointState

from pneumaticbox_driver.backends.topic.node import RELIABLE
from pneumaticbox_driver.box import PneumaticBox

PRESSURE_RATE = 25.0  # of the FluidPressure topics [Hz]


class StateTopics:
    """The topics that tell of the box's state.

    Args:
        node: whose topics they are.
        box: to tell of.
        channel_deviation: of the channel sensors, one sigma [Pa].
        supply_deviation: of the supply's sensor, one sigma [Pa].
    """

    def __init__(
        self, node: Node, box: PneumaticBox, channel_deviation: float, supply_deviation: float
    ) -> None:
        channels = box.settings.channels
        self._box = box
        self._state_out = node.create_publisher(JointState, "pneumaticbox/state", RELIABLE)
        self._state = JointState(name=list(channels))
        names = (*channels, "supply")
        self._pressure_out = [
            node.create_publisher(FluidPressure, f"pneumaticbox/{name}/pressure", RELIABLE)
            for name in names
        ]
        deviations = [channel_deviation] * len(channels) + [supply_deviation]
        self._pressure = [FluidPressure(variance=deviation**2) for deviation in deviations]
        for message, name in zip(self._pressure, names, strict=True):
            message.header.frame_id = name
        self._slot = 0

    def publish(self, stamp: Time, pressures: NDArray[np.float64]) -> None:
        """Publish the state after a sample of absolute pressures (n + 1,) [Pa]."""
        self._publish_state(stamp)
        self._publish_pressures(stamp, pressures)

    def _publish_state(self, stamp: Time) -> None:
        state, box = self._state, self._box
        state.header.stamp = stamp
        state.position = array.array("d", box.observer.mass.tolist())
        state.velocity = array.array("d", box.observer.flow.tolist())
        state.effort = array.array("d", box.gauge.tolist())
        self._state_out.publish(state)

    def _publish_pressures(self, stamp: Time, pressures: NDArray[np.float64]) -> None:
        """Publish the sensors in turn, each at its rate, spread over the samples."""
        n = len(self._pressure)
        slot = int((stamp.sec + 1e-9 * stamp.nanosec) * PRESSURE_RATE * n)
        for turn in range(max(self._slot + 1, slot - n + 1), slot + 1):
            message = self._pressure[turn % n]
            message.header.stamp = stamp
            message.fluid_pressure = float(pressures[turn % n])
            self._pressure_out[turn % n].publish(message)
        self._slot = slot
