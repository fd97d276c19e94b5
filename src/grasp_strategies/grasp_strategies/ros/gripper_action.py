"""The action `~/gripper_cmd`, as MoveIt calls grippers: closing runs a strategy, opening empties.

A position is how far the hand is open, from 0 (closed) to 1 (open), and an effort the greatest
gauge pressure of a channel [Pa]. While the hand closes, the position falls by the same amount with
each phase that begins.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any, Protocol

from rclpy.node import Node
from rclpy.task import Future
from sensor_msgs.msg import JointState

from grasp_strategies.judging.judge import GraspResult
from grasp_strategies.ros.parameters import GRIPPER_TYPES
from grasp_strategies.strategy import Condition, Phase, Strategy, Success
from grasp_strategies.strategy.tried_with import TriedWith
from softhand_ros.actions import offer_action

GRIPPER_ACTION = "~/gripper_cmd"
CALLERS = f"{GRIPPER_ACTION}/_action/send_goal"  # the service whose clients are the callers
OPENS_FROM = 0.5  # position from which on a goal opens the hand
EMPTY_PRESSURE = 3e3  # gauge, below which a channel counts as empty [Pa]
EMPTYING_TIME = 10.0  # of the scene, longest [s]
JOINT = "gripper"  # where a goal names none
WIDE_OPEN, CLOSED = 1.0, 0.0


class GripperRun(Protocol):
    """A running strategy: the number of its phases, how many of them have begun, and the future of
    its result.
    """

    begun: int
    phases: int
    ended: Future


def opening(hand: str, channels: tuple[str, ...]) -> Strategy:
    """The strategy that lets the air out of all channels of a hand; the wrist stays."""
    phase = Phase(
        name="open",
        wrist=None,
        speed=None,
        turn_speed=1.0,
        duration=None,
        air_mass=dict.fromkeys(channels, 0.0),
        pressure={},
        air_ramp=0.0,
        until=(Condition("pressure", above=False, threshold=EMPTY_PRESSURE),),
        until_touching=frozenset(),
        time_out=EMPTYING_TIME,
        next_on_time_out=False,
        option=None,
    )
    text, success = "lets the air out", Success(hold_phase=phase.name)
    return Strategy("open", text, hand, None, (), success, (phase,), TriedWith())


class GripperAction:
    """Goals of the gripper, one at a time.

    Args:
        node: the node that offers the action, with the type that its parameter `gripper_type`
            names.
        busy: returns why no goal can be taken now; empty when one can.
        begin: called with whether to open (True) or close (False) and with a function, begins a run
            and returns it, or raises ValueError; the function is called with the run at each phase,
            in the strategy's thread.
        interrupt: aborts a run.
        pressure: returns the greatest gauge pressure now [Pa].
    """

    def __init__(
        self,
        node: Node,
        busy: Callable[[], str],
        begin: Callable[[bool, Callable[[GripperRun], None]], GripperRun],
        interrupt: Callable[[Any], None],
        pressure: Callable[[], float],
    ) -> None:
        self._logger, self._busy, self._begin = node.get_logger(), busy, begin
        self._interrupt, self._pressure = interrupt, pressure
        self._runs: list[tuple[Any, GripperRun]] = []  # the goal under way
        kind = node.get_parameter("gripper_type").value
        self._parallel = kind == GRIPPER_TYPES[1]
        self._type = offer_action(node, kind, GRIPPER_ACTION, self)

    def accepts(self, goal: Any) -> bool:
        """Whether a goal is accepted: none is while another goal or a strategy runs."""
        reason = self._busy()
        try:
            self._wanted(goal)
        except ValueError as error:
            reason = str(error)
        if reason:
            self._logger.warning(f"{GRIPPER_ACTION} refused: {reason}", throttle_duration_sec=1.0)
        return not reason

    def _wanted(self, goal: Any) -> float:
        """The position of a goal; raises ValueError unless it is one finite number."""
        given = goal.command.position
        values = list(given) if self._parallel else [given]
        if len(values) != 1 or not math.isfinite(values[0]):
            raise ValueError(f"command.position: expected one finite number, got {values}")
        return float(values[0])

    def cancel(self, handle: Any) -> None:
        """Abort the running goal; the parameter abort_action says what happens to the air."""
        for goal, run in self._runs:
            if goal.goal_id == handle.goal_id:
                self._interrupt(run)

    async def execute(self, handle: Any) -> Any:
        """Close or open, and return the result: `stalled` when the judge says that the object is
        held, `reached_goal` when all phases ran besides, or when the hand is open.
        """
        to_open = self._wanted(handle.request) >= OPENS_FROM
        result = await self._move(handle, to_open)
        held = result.gripped and not to_open
        done = result.completed and (held or to_open)
        if handle.is_cancel_requested:
            handle.canceled()
        elif done:
            handle.succeed()
        else:
            handle.abort()
        position = WIDE_OPEN if to_open == result.completed else CLOSED
        answer = self._fill(self._type.Result(), handle, position)
        answer.stalled, answer.reached_goal = held, done
        return answer

    async def _move(self, handle: Any, to_open: bool) -> GraspResult:
        if handle.is_cancel_requested:
            return GraspResult.not_begun("cancelled before it began")
        try:
            run = self._begin(to_open, functools.partial(self._tell, handle, to_open))
        except ValueError as error:
            self._logger.warning(f"{GRIPPER_ACTION}: {error}")
            return GraspResult.not_begun(str(error))
        self._runs.append((handle, run))
        result: GraspResult = await run.ended
        self._runs.remove((handle, run))
        return result

    def _tell(self, handle: Any, to_open: bool, run: GripperRun) -> None:
        """Publish feedback."""
        fraction = min(1.0, run.begun / run.phases)
        position = fraction if to_open else WIDE_OPEN - fraction
        handle.publish_feedback(self._fill(self._type.Feedback(), handle, position))

    def _fill(self, message: Any, handle: Any, position: float) -> Any:
        if self._parallel:
            names = list(handle.request.command.name) or [JOINT]
            message.state = JointState(name=names, position=[position], effort=[self._pressure()])
        else:
            message.position, message.effort = position, self._pressure()
        return message
