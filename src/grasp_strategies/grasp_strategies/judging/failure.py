"""In which phase a grasp failed, and of what, by what was observed on the way.

What goes wrong in the hold is the judge's: the object slips, turns, is dropped or touched. Before
it, the first of these that is true when the grasp has ended:

* `diverged`: poses are no numbers.
* `fell off the table`: the object is below the table and the hand does not touch it.
* `tipped`: it stands otherwise than at the start: leaning by more than 45 deg, its centre higher or
  lower than before, and so since before the lift.
* `slipped in the lift`: the hand touched it when the lift began, or had it up, and has it no more.
* `rolled away`, `pushed away`: it went away from its place and the hand closed without it; rolled,
  if it has leant by more than 45 deg on the way.
* `missed`: the hand closed without it, and it is where it was.

An object that is still in the hand at the end of a failed grasp was `lifted too low`, or `touched
the table` (or another thing), or was `held too short`; a grasp that ended before its hold was
`aborted`, `timed out` or the `scene failed`.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

from grasp_strategies.judging.judge import (
    CARRIED_HEIGHT,
    DROPPED,
    NO_NUMBER,
    SLIPPED,
    TOO_LOW,
    TOUCHED,
    GraspJudge,
    GraspResult,
    is_number,
)
from grasp_strategies.scene import Observation
from grasp_strategies.strategy import Strategy

MISSED, TIPPED, ROLLED, PUSHED = "missed", "tipped", "rolled away", "pushed away"
FELL_OFF, SLIPPED_IN_LIFT, DIVERGED = "fell off the table", "slipped in the lift", NO_NUMBER
TIMED_OUT, ABORTED, SCENE_FAILED = "timed out", "aborted", "scene failed"

LEANING = math.radians(45.0)
SUNK = 0.005  # change of the centre's height of what has tipped and not rolled [m]
AWAY = 0.020  # horizontal way beyond which an object has left its place [m]
BELOW = -0.02  # height of a centre that is off the table, whose surface is at 0 [m]
BEFORE, LIFT, HOLD, AFTER = range(4)  # stages of a strategy


class Failure(NamedTuple):
    """Phase in which a grasp failed, the cause in one of the words of this module, and when [s]
    since the first observation.
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
    without any, it begins with the last motion of the wrist.
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
        name: BEFORE if i < lift else LIFT if i < hold else HOLD if i == hold else AFTER
        for i, name in enumerate(names)
    }


class GraspWatch:
    """Watches one run of a strategy from its first observation on; may be asked at any time.

    `judge` decides whether the grasp succeeded. `carried` tells whether the hand has the object up
    now (other things may touch it as well), `touched` whether the hand touches it now, `stage` how
    far the strategy has come, `last` is the last observation.
    """

    def __init__(self, strategy: Strategy, hand_bodies: frozenset[str], first: Observation) -> None:
        self._stages, self._hand_bodies = stages(strategy), hand_bodies
        self._success = strategy.success
        self.judge = GraspJudge(strategy.success, hand_bodies, first)
        self.first = self.last = first
        self.carried = self.touched = False
        self.stage = BEFORE
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
        """Horizontal distance of the object from where it was at first [m]."""
        x, y, _ = self.last.object_position - self.first.object_position
        return math.hypot(x, y)

    def watch(self, observation: Observation, phase: str) -> None:
        """Take in one observation, made in a phase of this name; raises KeyError for another."""
        before, self.stage = self.stage, self._stages[phase]
        self.judge.watch(observation, self.stage == HOLD)
        self.last = observation
        if self.stage == AFTER:
            return
        self._now = Moment(phase, observation.time - self.first.time)
        self._follow_hand(observation, begins=before == BEFORE)
        self._follow_object(observation)

    def _follow_hand(self, seen: Observation, begins: bool) -> None:
        """What the hand touches when the lift begins, or has up later, it may lose."""
        had, self.touched = self.touched, bool(seen.touching & self._hand_bodies)
        self.carried = self.touched and self.judge.rise(seen) > CARRIED_HEIGHT
        if had and not self.touched:
            self._let_go = self._now
        if self.stage == BEFORE:
            self._closed = self._now
            return
        self._had_in_lift |= self.carried or (begins and (had or self.touched))
        self._lost = self._since(self._lost, self._had_in_lift and not self.touched)

    def _follow_object(self, seen: Observation) -> None:
        """Since when the object lies otherwise than at first, is off the table, is nowhere."""
        if not is_number(seen):
            self._no_number = self._since(self._no_number, True)
            return
        leaning = self._leaning(seen)
        self._most_leaning = max(self._most_leaning, leaning)
        other_height = abs(self.judge.rise(seen)) > SUNK
        tipped = leaning > LEANING and other_height and not self.carried
        off = not self.touched and float(seen.object_position[2]) < BELOW
        self._tipped, self._off = self._since(self._tipped, tipped), self._since(self._off, off)

    def _since(self, began: Moment | None, holds: bool) -> Moment | None:
        """When a condition began that held until now, None when it holds no more."""
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
        """Phase, cause and time if the grasp ended now; None when it has succeeded by now."""
        flaw = self.judge.flaw()
        if flaw is None:
            return None
        if self.judge.was_held:
            cause = SLIPPED if flaw.cause in (DROPPED, TOO_LOW) else flaw.cause
            time = self.judge.flaw_time - self.first.time
            return Failure(self._success.hold_phase, cause, time)
        if self._no_number:
            return _failure(self._no_number, DIVERGED)
        return self._failure_in_hand(flaw.cause) if self.carried else self._failure_on_table()

    def _failure_in_hand(self, cause: str) -> Failure:
        """The hand has the object up, but it was never held as asked."""
        others = sorted(self.last.touching - self._hand_bodies)
        if others:
            return _failure(self._now, TOUCHED.format(others[0]))
        slipped = self.judge.lift_slip > self._success.max_slip
        return _failure(self._now, SLIPPED_IN_LIFT if slipped else cause)

    def _failure_on_table(self) -> Failure:
        """The hand has not the object up, at least not now."""
        if self._off:
            return _failure(self._off, FELL_OFF)
        if self._tipped and self._stages[self._tipped.phase] == BEFORE:
            return _failure(self._tipped, TIPPED)
        if self._had_in_lift:
            return _failure(self._lost or self._now, SLIPPED_IN_LIFT)
        went = ROLLED if self._most_leaning > LEANING else PUSHED
        return _failure(self._let_go or self._closed, went if self.way > AWAY else MISSED)

    def result(self) -> GraspResult:
        """The judge's verdict, with phase, cause and time of a failure."""
        phase, cause, time = self.failure() or ("", "", math.nan)
        return replace(self.judge.result(), phase=phase, cause=cause, failed_at=time)


def _failure(moment: Moment, cause: str) -> Failure:
    return Failure(moment.phase, cause, moment.time)
