"""The action `pneumaticbox/follow_joint_trajectory`: targets of channels over time, as MoveIt and
ros2_control send them to arms.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from rclpy.node import Node
from rclpy.task import Future
from trajectory_msgs.msg import JointTrajectoryPoint

from pneumaticbox_driver.arrays import Floats
from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.box.commands import TrajectoryPoint
from pneumaticbox_driver.modes import MODES
from pneumaticbox_driver.ros.box_topics import points_of
from pneumaticbox_driver.ros.parameters import CANCEL_ACTIONS
from softhand_ros.actions import offer_action
from softhand_ros.topics import seconds

TRAJECTORY_ACTION = "pneumaticbox/follow_joint_trajectory"
FEEDBACK_PERIOD = 0.1  # of the box's time [s]
GOAL_TIME_TOLERANCE = 2.0  # after the end, unless a goal has its own [s]
# by control mode: largest error at the end, unless a goal has its own; two of the valves' pulses
GOAL_TOLERANCES = {"mass": 5e-6, "pressure": 5e3}  # [kg], [Pa]


@dataclass
class Following:
    """A running goal of the action.

    handle: by which the action server reports on the goal. ended: future of the result. channels,
    modes: indices of the channels and their control modes, in the order of the goal. end [s]: time
    of its last point, on the box's clock. path_tolerance, goal_tolerance (n,): in the units of the
    modes; NaN for none. goal_time [s]: how long after `end` the goal tolerances may still be met.
    """

    handle: Any
    ended: Future
    channels: list[int]
    modes: list[str]
    end: float
    path_tolerance: Floats
    goal_tolerance: Floats
    goal_time: float
    told: float = -math.inf


class TrajectoryAction:
    """Executes one trajectory at a time; a new goal replaces the running one.

    Args:
        node: the node that offers the action; its parameter cancel_action says what a cancel does.
        box: the box that carries out the trajectories.
        now: returns the present time of the box [s].
        of_stamp: returns the time of the box [s] for a message's stamp [s].
        accepted: called after a valid goal.
    """

    def __init__(
        self,
        node: Node,
        box: PneumaticBox,
        now: Callable[[], float],
        of_stamp: Callable[[float], float],
        accepted: Callable[[], None],
    ) -> None:
        self._node, self._box, self._accepted = node, box, accepted
        self._now, self._of_stamp = now, of_stamp
        self._goal: Following | None = None
        self._type = offer_action(node, "FollowJointTrajectory", TRAJECTORY_ACTION, self)

    @property
    def offered(self) -> bool:
        """Whether this machine has the action's type."""
        return self._type is not None

    def accepts(self, goal: Any) -> bool:
        """True always: the result of a goal says what is wrong with it."""
        return True

    async def execute(self, handle: Any) -> Any:
        """Command the trajectory and return the result when it has ended."""
        try:
            goal = self._begin(handle)
        except ValueError as error:
            text = str(error)
            codes = self._type.Result
            wrong_name = text.startswith("joint_names")
            handle.abort()
            return self._result(codes.INVALID_JOINTS if wrong_name else codes.INVALID_GOAL, text)
        code, text, stop = await goal.ended
        stop()  # the state of the goal; only here, when a request to cancel has been answered
        return self._result(code, text)

    def _result(self, code: int, text: str) -> Any:
        return self._type.Result(error_code=code, error_string=text)

    def _begin(self, handle: Any) -> Following:
        """Give the trajectory to the box; raises ValueError when it refuses."""
        goal, box = handle.request, self._box
        trajectory = goal.trajectory
        names = list(trajectory.joint_names)
        box.commands.rules.check_names(names)
        channels = [box.settings.channels.index(name) for name in names]
        modes = [box.control.modes[channel] for channel in channels]
        other = sorted({*modes} - GOAL_TOLERANCES.keys())
        if other:
            expected = " or ".join(GOAL_TOLERANCES)
            raise ValueError(f"control_mode: expected {expected} for an action, got {other}")
        usual = np.array([GOAL_TOLERANCES[mode] for mode in modes])
        path = tolerances(goal.path_tolerance, names, np.full(len(names), np.nan))
        end = tolerances(goal.goal_tolerance, names, usual)
        points = [with_effort(point) for point in points_of(trajectory)]
        start, now = self._of_stamp(seconds(trajectory.header.stamp)), self._now()
        box.commands.rules.check(names, points, start)
        if points[0].time_from_start > 0:
            points.insert(0, self._begin_of(channels, modes, start or now))
        box.command(names, points, start, now)
        self._accepted()
        self.displace("another goal has come")
        last = (start or now) + points[-1].time_from_start
        time_after = seconds(goal.goal_time_tolerance) or GOAL_TIME_TOLERANCE
        self._goal = Following(handle, Future(), channels, modes, last, path, end, time_after)
        return self._goal

    def displace(self, why: str) -> None:
        """Abort a running goal for the reason `why`: the channels no longer follow it."""
        if self._goal is not None:
            self._end(self._type.Result.INVALID_GOAL, why)

    def _begin_of(self, channels: list[int], modes: list[str], start: float) -> TrajectoryPoint:
        """The point from which a trajectory begins: the setpoints, or what is measured for lack of
        one.
        """
        measured = self._measured(channels, modes)
        values = []
        for channel, mode, present in zip(channels, modes, measured, strict=True):
            _, most = self._box.commands.rules.ranges[mode]
            planned = self._box.commands.setpoints.planned(channel, start)
            present = min(max(float(present), 0.0), float(most[channel]))
            values.append(present if math.isnan(planned) else planned)
        return TrajectoryPoint(0.0, positions=values, effort=values)

    def _measured(self, channels: list[int], modes: list[str]) -> Floats:
        """Estimated masses [kg] or gauge pressures [Pa] of channels, as their modes have it."""
        values = {"mass": self._box.observer.mass, "pressure": self._box.pressures}
        pairs = zip(channels, modes, strict=True)
        return np.array([values[mode][channel] for channel, mode in pairs])

    def cancel(self, handle: Any) -> None:
        """Hold the present content of all channels, or vent, as cancel_action says."""
        if self._goal is None or self._goal.handle.goal_id != handle.goal_id:
            return
        if self._node.get_parameter("cancel_action").value == CANCEL_ACTIONS[1]:
            self._box.vent("a trajectory was cancelled")
            done = "vented until pneumaticbox/reset"
        else:
            done = self._box.hold()
        self._end(self._type.Result.SUCCESSFUL, f"cancelled: {done}", handle.canceled)

    def look(self, stamp: Time) -> None:
        """Publish feedback, with this stamp, on the progress of the running goal, and end the goal
        when it is reached or missed. Call it after each sample.
        """
        goal, box = self._goal, self._box
        if goal is None or not box.time - goal.told >= FEEDBACK_PERIOD:
            return
        goal.told, codes = box.time, self._type.Result
        if box.latch:
            self.displace(f"vented: {box.latch.reasons[0]}")
            return
        now = [box.control.modes[channel] for channel in goal.channels]
        if not box.enabled or now != goal.modes:
            self.displace("disabled, or control modes were changed")
            return
        desired = np.array([box.commands.setpoints.planned(c, box.time) for c in goal.channels])
        actual = self._measured(goal.channels, now)
        error = desired - actual
        self._tell(goal, stamp, (desired, actual, error))
        if (np.abs(error) > goal.path_tolerance).any() and box.time <= goal.end:
            self._end(codes.PATH_TOLERANCE_VIOLATED, f"{self._far(goal, error)}: {box.hold()}")
        elif box.time >= goal.end and not (np.abs(error) > goal.goal_tolerance).any():
            self._end(codes.SUCCESSFUL, "", goal.handle.succeed)
        elif box.time > goal.end + goal.goal_time:
            self._end(codes.GOAL_TOLERANCE_VIOLATED, self._far(goal, error))

    def _end(self, code: int, text: str, stop: Callable[[], None] | None = None) -> None:
        """End the goal; without `stop`, as aborted."""
        goal, self._goal = self._goal, None
        if goal is not None:
            goal.ended.set_result((code, text, stop or goal.handle.abort))

    def _far(self, goal: Following, error: Floats) -> str:
        worst = int(np.argmax(np.abs(error)))
        name = self._box.settings.channels[goal.channels[worst]]
        unit = MODES[goal.modes[worst]].unit
        return f"channel {name} is off by {error[worst]:.3g} {unit}"

    def _tell(self, goal: Following, stamp: Time, values: Sequence[Floats]) -> None:
        feedback = self._type.Feedback()
        feedback.header.stamp = stamp
        feedback.joint_names = [self._box.settings.channels[c] for c in goal.channels]
        parts = [JointTrajectoryPoint(positions=value.tolist()) for value in values]
        feedback.desired, feedback.actual, feedback.error = parts
        goal.handle.publish_feedback(feedback)


def with_effort(point: TrajectoryPoint) -> TrajectoryPoint:
    """The point itself, or with its positions as pressures if it has no pressures: MoveIt plans
    positions alone.

    >>> with_effort(TrajectoryPoint(1.0, positions=[2e4])).effort
    [20000.0]
    """
    return point if point.effort else replace(point, effort=point.positions)


def tolerances(given: Sequence[Any], names: Sequence[str], usual: Floats) -> Floats:
    """Tolerances (n,) in the order of `names` from JointTolerance messages: 0 stands for the
    `usual` tolerance (n,), a negative number for none (NaN).

    Raises:
        ValueError: a message has a name that is not in `names`.
    """
    found = usual.copy()
    for one in given:
        if one.name not in names:
            raise ValueError(f"joint_names: expected tolerances of {list(names)}, got {one.name}")
        if one.position != 0:
            found[names.index(one.name)] = one.position if one.position > 0 else math.nan
    return found
