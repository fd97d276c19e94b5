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

from grasp_strategies.judge import (
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
    """Phase in which a grasp failed, and the cause in one of the words of this module."""

    phase: str
    cause: str


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
        self._max_slip = strategy.success.max_slip
        self.judge = GraspJudge(strategy.success, hand_bodies, first)
        self.first = self.last = first
        self.carried = self.touched = False
        self.stage = BEFORE
        self._phase = ""  # of the last observation
        self._closed_in = ""  # last phase before the lift
        self._let_go = ""  # phase in which the hand last left the object
        self._had_in_lift = False
        self._lost_in = ""  # phase in which what was had in the lift was lost
        self._most_leaning = 0.0
        self._tipped_in = self._off_in = self._no_number_in = ""
        self._in_hold: Failure | None = None

    @property
    def phase(self) -> str:
        """Name of the phase in which the last observation was made."""
        return self._phase

    @property
    def off_table(self) -> bool:
        """Whether the object is below the table's surface and the hand does not touch it."""
        return bool(self._off_in)

    @property
    def way(self) -> float:
        """Horizontal distance of the object from where it was at first [m]."""
        x, y, _ = self.last.object_position - self.first.object_position
        return math.hypot(x, y)

    def watch(self, observation: Observation, phase: str) -> None:
        """Take in one observation, made in a phase of this name."""
        self.stage = self._stages.get(phase, BEFORE)
        self.judge.watch(observation, self.stage == HOLD)
        self.last = observation
        if self.stage != AFTER:
            self._follow(observation, phase)
        self._phase = phase

    def _follow(self, seen: Observation, phase: str) -> None:
        had, self.touched = self.touched, bool(seen.touching & self._hand_bodies)
        self.carried = self.touched and self.judge.rise(seen) > CARRIED_HEIGHT
        if had and not self.touched:
            self._let_go = phase
        if self.stage == BEFORE:
            self._closed_in = phase
        else:
            self._follow_lift(phase, had or self.touched)
        self._follow_object(seen, phase)

    def _follow_lift(self, phase: str, had: bool) -> None:
        """What the hand touches when the lift begins, or has up later, it may lose."""
        begins = self._stages.get(self._phase, BEFORE) == BEFORE
        self._had_in_lift |= self.carried or (begins and had)
        if self.touched:
            self._lost_in = ""
        elif self._had_in_lift:
            self._lost_in = self._lost_in or phase

    def _follow_object(self, seen: Observation, phase: str) -> None:
        """Since which phase the object lies otherwise than at first, is off the table, nowhere."""
        if not is_number(seen):
            self._no_number_in = self._no_number_in or phase
            return
        leaning = self._leaning(seen)
        self._most_leaning = max(self._most_leaning, leaning)
        height = abs(self.judge.rise(seen))
        tipped = leaning > LEANING and height > SUNK and not self.carried
        off = not self.touched and float(seen.object_position[2]) < BELOW
        self._tipped_in = (self._tipped_in or phase) if tipped else ""
        self._off_in = (self._off_in or phase) if off else ""

    def _leaning(self, seen: Observation) -> float:
        """Angle from the vertical of the axis of the object that was vertical at first [rad]."""
        # x and y of the rotation since; in floats, as a scipy Rotation takes ten times as long
        x0, y0, z0, w0 = self.first.object_orientation.tolist()
        x1, y1, z1, w1 = seen.object_orientation.tolist()
        x = x1 * w0 - w1 * x0 + z1 * y0 - y1 * z0
        y = y1 * w0 - w1 * y0 + x1 * z0 - z1 * x0
        return 2.0 * math.asin(min(1.0, math.hypot(x, y)))

    def failure(self) -> Failure | None:
        """Phase and cause if the grasp ended now; None when it has succeeded by now."""
        flaw = self.judge.flaw()
        if flaw is None:
            return None
        if self.judge.was_held:
            hold = next(name for name, stage in self._stages.items() if stage == HOLD)
            return Failure(hold, SLIPPED if flaw.cause in (DROPPED, TOO_LOW) else flaw.cause)
        if self._no_number_in:
            return Failure(self._no_number_in, DIVERGED)
        return self._failure_in_hand(flaw.cause) if self.carried else self._failure_on_table()

    def _failure_in_hand(self, cause: str) -> Failure:
        """The hand has the object up, but it was never held as asked."""
        others = sorted(self.last.touching - self._hand_bodies)
        if others:
            return Failure(self._phase, TOUCHED.format(others[0]))
        if self.judge.lift_slip > self._max_slip:
            return Failure(self._phase, SLIPPED_IN_LIFT)
        return Failure(self._phase, cause)

    def _failure_on_table(self) -> Failure:
        """The hand has not the object up, at least not now."""
        if self._off_in:
            return Failure(self._off_in, FELL_OFF)
        if self._tipped_in and self._stages[self._tipped_in] == BEFORE:
            return Failure(self._tipped_in, TIPPED)
        if self._had_in_lift:
            return Failure(self._lost_in or self._phase, SLIPPED_IN_LIFT)
        went = ROLLED if self._most_leaning > LEANING else PUSHED
        return Failure(self._let_go or self._closed_in, went if self.way > AWAY else MISSED)

    def result(self) -> GraspResult:
        """The judge's verdict, with phase and cause of a failure."""
        phase, cause = self.failure() or ("", "")
        return replace(self.judge.result(), phase=phase, cause=cause)
