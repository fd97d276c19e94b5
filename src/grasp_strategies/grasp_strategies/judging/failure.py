"""Phase and cause of the failure of a grasp, from the observations of the run.

Failures in the hold are those of the judge: the object slips, turns, is dropped or touched by
something else. For a failure before the hold, the cause is the first of these that is true when the
grasp has ended:

* `diverged`: a pose is not finite.
* `fell off the table`: the object is below the table and the hand does not touch it.
* `tipped`: since before the lift, the object leans by more than 45 deg against its start, and its
  centre is higher or lower than at the start.
* `slipped in the lift`: the hand touched the object when the lift began, or had lifted it, and has
  lost it.
* `rolled away`, `pushed away`: the object left its place and the hand closed without it; rolled, if
  it leaned by more than 45 deg on the way.
* `missed`: the hand closed without the object, which is still in its place.

If the object is still in the hand at the end of a failed grasp, it was `lifted too low`, `touched
the table` (or another body), or was `held too short`. A grasp that ended before its hold was
`aborted`, `timed out`, or the `scene failed`.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

from grasp_strategies.judging.judge import (
    CARRIED_HEIGHT,
    DROPPED,
    NO_NUMBER,
    SLIPPED_IN_HOLD,
    TOO_LOW,
    TOUCHED,
    GraspJudge,
    GraspResult,
    is_number,
)
from grasp_strategies.scene import Observation
from grasp_strategies.strategy import Strategy

MISSED_OBJECT, TIPPED, ROLLED, PUSHED = "missed", "tipped", "rolled away", "pushed away"
FELL_OFF, SLIPPED_IN_LIFT, DIVERGED = "fell off the table", "slipped in the lift", NO_NUMBER
TIMED_OUT, ABORTED, SCENE_FAILED = "timed out", "aborted", "scene failed"

LEANING_ANGLE = math.radians(45.0)
TIPPED_HEIGHT_CHANGE = 0.005  # change of the centre's height of what has tipped and not rolled [m]
MOVED_AWAY_DISTANCE = 0.020  # horizontal way beyond which an object has left its place [m]
OFF_TABLE_HEIGHT = -0.02  # height of a centre that is off the table, whose surface is at 0 [m]
STAGE_BEFORE_LIFT, STAGE_LIFT, STAGE_HOLD, STAGE_AFTER_HOLD = range(4)  # stages of a strategy


class Failure(NamedTuple):
    """Phase in which a grasp failed, its cause (listed in the module), and the time [s] since the
    first observation.
    """

    phase: str
    cause: str
    time: float


class Moment(NamedTuple):
    """A phase and a time [s] since the first observation."""

    phase: str
    time: float


def stages(strategy: Strategy) -> dict[str, int]:
    """Stage of each phase: before the lift, lift, hold, after the hold.

    The lift is the last run of phases before the hold that move the wrist upwards or let time pass;
    without such phases, it begins with the last motion of the wrist.
    """
    phases = strategy.phases
    names = [phase.name for phase in phases]
    hold = lift = names.index(strategy.success.hold_phase)
    for index in reversed(range(hold)):
        phase = phases[index]
        if phase.wrist is not None and phase.wrist.position[2] > 0 and phase.wrist.rpy is None:
            lift = index
        elif phase.wrist is not None or phase.air_mass or phase.pressure:
            break
    moving = [index for index in range(hold) if phases[index].wrist is not None]
    lift = moving[-1] if lift == hold and moving else lift
    return {
        name: STAGE_BEFORE_LIFT
        if i < lift
        else STAGE_LIFT
        if i < hold
        else STAGE_HOLD
        if i == hold
        else STAGE_AFTER_HOLD
        for i, name in enumerate(names)
    }


class GraspWatch:
    """Watches one run of a strategy from its first observation on; can be queried at any time.

    Attributes:
        judge: decides whether the grasp succeeded.
        first, last: first and latest observation.
        carried: whether the hand has lifted the object; other bodies may have touched it meanwhile.
        touched: whether the hand touches the object.
        stage: STAGE_BEFORE_LIFT, STAGE_LIFT, STAGE_HOLD or STAGE_AFTER_HOLD.
    """

    def __init__(self, strategy: Strategy, hand_bodies: frozenset[str], first: Observation) -> None:
        self._stages, self._hand_bodies = stages(strategy), hand_bodies
        self._success = strategy.success
        self.judge = GraspJudge(strategy.success, hand_bodies, first)
        self.first = self.last = first
        self.carried = self.touched = False
        self.stage = STAGE_BEFORE_LIFT
        self._now = self._closed = Moment("", 0.0)  # the latter: the last before the lift
        self._let_go: Moment | None = None  # when the hand last left the object
        self._had_in_lift = False
        self._lost: Moment | None = None  # when the hand left what it had in the lift
        self._most_leaning = 0.0
        # since when it is so, None when it is not
        self._tipped: Moment | None = None
        self._off: Moment | None = None
        self._no_number: Moment | None = None

    @property
    def phase(self) -> str:
        """Name of the phase in which the last observation was made."""
        return self._now.phase

    @property
    def off_table(self) -> bool:
        """Whether the object is below the table's surface and the hand does not touch it."""
        return self._off is not None

    @property
    def way(self) -> float:
        """Horizontal distance of the object from its first place [m]."""
        x, y, _ = self.last.object_position - self.first.object_position
        return math.hypot(x, y)

    def watch(self, observation: Observation, phase: str) -> None:
        """Take in one observation, made in the phase of this name; raises KeyError if the strategy
        has no such phase.
        """
        before, self.stage = self.stage, self._stages[phase]
        self.judge.watch(observation, self.stage == STAGE_HOLD)
        self.last = observation
        if self.stage == STAGE_AFTER_HOLD:
            return
        self._now = Moment(phase, observation.time - self.first.time)
        self._follow_hand(observation, begins=before == STAGE_BEFORE_LIFT)
        self._follow_object(observation)

    def _follow_hand(self, seen: Observation, begins: bool) -> None:
        """Track contact of the hand with the object during the lift, and when it was lost."""
        had, self.touched = self.touched, bool(seen.touching & self._hand_bodies)
        self.carried = self.touched and self.judge.rise(seen) > CARRIED_HEIGHT
        if had and not self.touched:
            self._let_go = self._now
        if self.stage == STAGE_BEFORE_LIFT:
            self._closed = self._now
            return
        self._had_in_lift |= self.carried or (begins and (had or self.touched))
        self._lost = self._since(self._lost, self._had_in_lift and not self.touched)

    def _follow_object(self, seen: Observation) -> None:
        """Track since when the object is tipped, off the table, or not at a finite pose."""
        if not is_number(seen):
            self._no_number = self._since(self._no_number, True)
            return
        leaning = self._leaning(seen)
        self._most_leaning = max(self._most_leaning, leaning)
        other_height = abs(self.judge.rise(seen)) > TIPPED_HEIGHT_CHANGE
        tipped = leaning > LEANING_ANGLE and other_height and not self.carried
        off = not self.touched and float(seen.object_position[2]) < OFF_TABLE_HEIGHT
        self._tipped, self._off = self._since(self._tipped, tipped), self._since(self._off, off)

    def _since(self, began: Moment | None, holds: bool) -> Moment | None:
        """When a condition that still holds became true; None when it does not hold."""
        return (began or self._now) if holds else None

    def _leaning(self, seen: Observation) -> float:
        """Angle from the vertical of the axis of the object that was vertical at first [rad]."""
        # x and y of the rotation since; in floats, as a scipy Rotation takes ten times as long
        x0, y0, z0, w0 = self.first.object_orientation.tolist()
        x1, y1, z1, w1 = seen.object_orientation.tolist()
        x = x1 * w0 - w1 * x0 + z1 * y0 - y1 * z0
        y = y1 * w0 - w1 * y0 + x1 * z0 - z1 * x0
        return 2.0 * math.asin(min(1.0, math.hypot(x, y)))

    def failure(self) -> Failure | None:
        """Phase, cause and time of the failure if the grasp ended now; None when it has
        succeeded.
        """
        flaw = self.judge.flaw()
        if flaw is None:
            return None
        if self.judge.was_held:
            cause = SLIPPED_IN_HOLD if flaw.cause in (DROPPED, TOO_LOW) else flaw.cause
            time = self.judge.flaw_time - self.first.time
            return Failure(self._success.hold_phase, cause, time)
        if self._no_number:
            return _failure(self._no_number, DIVERGED)
        return self._failure_in_hand(flaw.cause) if self.carried else self._failure_on_table()

    def _failure_in_hand(self, cause: str) -> Failure:
        """Failure of a grasp whose object is lifted, but was never held as required."""
        others = sorted(self.last.touching - self._hand_bodies)
        if others:
            return _failure(self._now, TOUCHED.format(others[0]))
        slipped = self.judge.lift_slip > self._success.max_slip
        return _failure(self._now, SLIPPED_IN_LIFT if slipped else cause)

    def _failure_on_table(self) -> Failure:
        """Failure of a grasp whose object is not lifted now."""
        if self._off:
            return _failure(self._off, FELL_OFF)
        if self._tipped and self._stages[self._tipped.phase] == STAGE_BEFORE_LIFT:
            return _failure(self._tipped, TIPPED)
        if self._had_in_lift:
            return _failure(self._lost or self._now, SLIPPED_IN_LIFT)
        went = ROLLED if self._most_leaning > LEANING_ANGLE else PUSHED
        return _failure(
            self._let_go or self._closed, went if self.way > MOVED_AWAY_DISTANCE else MISSED_OBJECT
        )

    def result(self) -> GraspResult:
        """The judge's verdict, with phase, cause and time of a failure."""
        phase, cause, time = self.failure() or ("", "", math.nan)
        return replace(self.judge.result(), phase=phase, cause=cause, failed_at=time)


def _failure(moment: Moment, cause: str) -> Failure:
    return Failure(moment.phase, cause, moment.time)
