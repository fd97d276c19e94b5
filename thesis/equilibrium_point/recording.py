"""Recording of a push from its bag: pressure, volume of the bent finger, air, force, valves."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from pneuflex_sim.hand.air import AirCoupling
from pneuflex_sim.hand.layout import build_layout
from pneuflex_sim.urdf import joint_orientations
from softhand_bringup.bags.reading import Bag, JointSeries, stamp_seconds
from softhand_model.gas import AMBIENT_PRESSURE, GAS_CONSTANT, ROOM_TEMPERATURE
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model
from thesis.frame import Array

HAND = "single_finger"
STATE, VALVES = "/pneumaticbox/state", "/pneumaticbox/valves"
JOINTS, WRENCH = "/hand/joint_states", "/wrist/wrench"
AVERAGED = 0.5  # of standing pressures and volumes [s]


@dataclass(frozen=True)
class Push:
    """Times of one push under a controller, in simulated time [s]: the wrist moves down from
    `start` to `pressed`, stays until `released`, and is up again at `free`; the recording ends at
    `end`.
    """

    mode: str
    start: float
    pressed: float
    released: float
    free: float
    end: float


@dataclass(frozen=True)
class Recording:
    """One push over time [s] from its start: measured gauge pressure [Pa], volume [m3] computed
    from the finger's shape, estimated air mass [kg above rest], force on the wrist [N]; `openings`
    [s] are the times when a valve was opened.
    """

    push: Push
    time: Array
    pressure: Array
    volume: Array
    mass: Array
    force: Array
    openings: Array

    def before(self, values: Array) -> float:
        """Mean over an interval just before the push."""
        return self._mean(values, self.push.start)

    def pressed(self, values: Array) -> float:
        """Mean over the last interval in which the finger is pressed."""
        return self._mean(values, self.push.released)

    def after(self, values: Array) -> float:
        """Mean over the last interval in which the finger is free again."""
        return self._mean(values, self.push.end)

    def _mean(self, values: Array, end: float) -> float:
        end -= self.push.start
        return float(np.mean(values[(self.time >= end - AVERAGED) & (self.time < end)]))

    @property
    def enclosed(self) -> Array:
        """Air in the finger (k,) [kg], by `m = p_abs V/(R_s T)` (section 4.2)."""
        heat = GAS_CONSTANT * ROOM_TEMPERATURE
        return (AMBIENT_PRESSURE + self.pressure) * self.volume / heat


def read_recordings(bag: Path, pushes: list[Push]) -> list[Recording]:
    """Recordings of the pushes from the bag of their session.

    Raises:
        ValueError: a topic has no messages.
    """
    with Bag(bag) as recording:
        state, joints = recording.joints(STATE), recording.joints(JOINTS)
        valves = recording.joints(VALVES)
        wrenches = [message for _, message in recording.messages(WRENCH)]
    times = np.array([stamp_seconds(message.header.stamp) for message in wrenches])
    forces = np.array([message.wrench.force.z for message in wrenches])
    volume = np.interp(state.time, joints.time, volumes(joints.position))
    force = np.interp(state.time, times, forces)
    return [_course(push, state, volume, force, valves) for push in pushes]


def volumes(positions: Array) -> Array:
    """Volume (k,) [m3] of the finger's chamber and tube for joint angles (k, 3 n) [rad]; computed
    from geometry alone.
    """
    segments = positions.shape[1] // 3
    layout = build_layout(load_hand(HAND), segments, load_model(None))
    air, to_rest = AirCoupling(layout), Rotation.from_quat(layout.rest).inv()
    shapes = (Rotation.from_quat(joint_orientations(row)) for row in positions)
    return np.array([air.volumes((to_rest * shape).as_rotvec())[0] for shape in shapes])


def _course(
    push: Push, state: JointSeries, volume: Array, force: Array, valves: JointSeries
) -> Recording:
    inside = (state.time >= push.start - AVERAGED) & (state.time <= push.end)
    opened = np.flatnonzero((valves.position[1:, 0] != 0) & (valves.position[:-1, 0] == 0)) + 1
    openings = valves.time[opened]
    return Recording(
        push,
        state.time[inside] - push.start,
        state.effort[inside, 0],
        volume[inside],
        state.position[inside, 0],
        force[inside],
        openings[(openings >= push.start) & (openings <= push.end)] - push.start,
    )
