"""When the verdict of a grasp is sure, so that a trial can end before its strategy does."""

from __future__ import annotations

import math

import numpy as np

from grasp_strategies.failure import AFTER, BEFORE, HOLD, GraspWatch, stages
from grasp_strategies.judge import SLIPPED, TOO_SHORT, TURNED
from grasp_strategies.scene import Array
from grasp_strategies.strategy import Phase, Strategy, Waypoint

CLEAR = 0.080  # [m] that a hand must have gone up without the object: no finger is hooked below it
EMPTY_TIME = 0.2  # [s] for which it must not have touched it then


class EarlyEnd:
    """Asked after each control step; answers why the verdict is sure, or nothing.

    It is when the hold is over; when the object is off the table, or farther away than the hand
    can still come; when the hand has gone up without it; and when it slipped in the hold, or what
    is left of the hold is too short.

    Args:
        strategy: that runs.
        reach: greatest distance from the wrist to the middle of an object that the hand touches
            [m]; infinite where the object may come back by itself.
    """

    def __init__(self, strategy: Strategy, reach: float) -> None:
        names = [phase.name for phase in strategy.phases]
        hold = names.index(strategy.success.hold_phase)
        stage = stages(strategy)
        before = [phase for phase in strategy.phases if stage[phase.name] == BEFORE]
        self._reach = reach
        self._ways = {
            phase.name: [p.wrist for p in before[k:] if p.wrist is not None]
            for k, phase in enumerate(before)
        }
        self._spare = _spare_time(strategy.phases[hold], strategy.success.hold_time)
        self._low = math.inf  # lowest wrist since the lift began [m]
        self._touched = -math.inf  # when the hand last touched the object [s]
        self._hold_began = self._flawed = math.inf  # [s]

    def __call__(self, watch: GraspWatch) -> str:
        """Why the verdict is sure, or an empty text."""
        if watch.stage == AFTER:
            return "the hold is over"
        if watch.off_table:
            return "the object is off the table"
        if watch.touched:
            self._touched = watch.last.time
        if watch.stage == BEFORE:
            return "the object is out of reach" if self._out_of_reach(watch) else ""
        if self._went_up_empty(watch):
            return "the hand went up without the object"
        return self._lost_hold(watch) if watch.stage == HOLD else ""

    def _out_of_reach(self, watch: GraspWatch) -> bool:
        """Whether no goal before the lift brings the wrist near enough to the object."""
        away = float(np.linalg.norm(watch.last.object_position - watch.last.wrist_position))
        if watch.touched or away < self._reach:
            return False
        return away > self._reach + _way_left(self._ways[watch.phase], watch.last.wrist_position)

    def _went_up_empty(self, watch: GraspWatch) -> bool:
        height = float(watch.last.wrist_position[2])
        self._low = min(self._low, height)
        return height > self._low + CLEAR and watch.last.time > self._touched + EMPTY_TIME

    def _lost_hold(self, watch: GraspWatch) -> str:
        flaw, now = watch.judge.flaw(), watch.last.time
        self._hold_began = min(self._hold_began, now)
        if flaw is None:
            return ""
        if flaw.cause != TOO_SHORT:
            self._flawed = min(self._flawed, now)
        late = self._hold_began + self._spare
        never = now > late and not watch.judge.was_held
        broken = late < self._flawed < math.inf
        return flaw.sentence if flaw.cause in (SLIPPED, TURNED) or never or broken else ""


def _spare_time(hold: Phase, needed: float) -> float:
    """How much longer the hold lasts than it must [s]; infinite if a condition ends it."""
    if hold.conditional or hold.wrist is not None:
        return math.inf
    return (hold.duration or 0.0) - needed


def _way_left(goals: list[Waypoint], wrist: Array) -> float:
    """How far the wrist can still go [m], at most."""
    way = 0.0
    for goal in goals:
        turned = 2.0 * float(np.linalg.norm(goal.pivot))
        if goal.frame == "object":
            return math.inf
        start = wrist if goal.frame == "environment" else np.zeros(3)
        way += float(np.linalg.norm(np.array(goal.position) - start)) + turned
    return way
