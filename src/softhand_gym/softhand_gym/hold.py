"""Judges an episode. As it has no phases, any hold counts that meets the criteria for strategies.

A hold begins when the hand alone has the object at the height to be lifted to. If the object slips,
turns or sinks, the hold time starts again. Criteria are those of `grasp_strategies.judging.judge`.
"""

from __future__ import annotations

from grasp_strategies.judging.failure import OFF_TABLE_HEIGHT
from grasp_strategies.judging.judge import (
    CARRIED_HEIGHT,
    OUTCOME_GRIPPED,
    OUTCOME_LOST,
    OUTCOME_NONE,
    TOO_SHORT,
    GraspJudge,
    held_by,
)
from grasp_strategies.scene import Observation
from grasp_strategies.strategy import Success


class HoldWatch:
    """Watches an episode from its first observation on.

    Attributes:
        outcome: `gripped` once an object has been held as required, `lost` once an object that was
            carried lies apart from the hand, or is off the table; else `none`.
        reason: one sentence on the latest hold, or on the end.
        lift_height: greatest rise of the object [m].
        hold_time: duration of the present hold [s]; 0 without one.
        lifted: rise of the object divided by the height to which it has to be lifted [-], 0 to 1; 0
            while anything but the hand touches it.
    """

    def __init__(self, success: Success, hand_bodies: frozenset[str], first: Observation) -> None:
        self._success, self._hand_bodies, self._first = success, hand_bodies, first
        self._carried = False
        self.outcome, self.reason = OUTCOME_NONE, "the object was not held"
        self.lift_height = self.lifted = 0.0
        self._end_hold()

    def _end_hold(self) -> None:
        self._judge = GraspJudge(self._success, self._hand_bodies, self._first)
        self._holding, self.hold_time = False, 0.0

    @property
    def over(self) -> bool:
        """Whether the episode has an outcome."""
        return self.outcome != OUTCOME_NONE

    @property
    def merit(self) -> float:
        """Share of the lift plus share of the hold [-]: 2 for a grasp that was held through."""
        return self.lifted + min(1.0, self.hold_time / self._success.hold_time)

    def watch(self, seen: Observation) -> None:
        """Take in one observation."""
        rise = self._judge.rise(seen)
        held = held_by(seen, self._hand_bodies)
        self.lift_height = max(self.lift_height, rise)
        self._carried |= held and rise > CARRIED_HEIGHT
        self.lifted = min(1.0, max(0.0, rise / self._success.lift_height)) if held else 0.0
        if self._holding or (held and rise >= self._success.lift_height):
            self._watch_hold(seen)
        by_hand = seen.touching & self._hand_bodies
        fallen = self._carried and bool(seen.touching) and not by_hand
        if fallen or (float(seen.object_position[2]) < OFF_TABLE_HEIGHT and not by_hand):
            self.outcome = OUTCOME_LOST
            self.reason = "the object fell out of the hand" if fallen else "fell off the table"

    def _watch_hold(self, seen: Observation) -> None:
        self._holding = True
        self._judge.watch(seen, holding=True)
        flaw, result = self._judge.flaw(), self._judge.result()
        self.reason, self.hold_time = result.reason, result.hold_time
        if flaw is None:
            self.outcome = OUTCOME_GRIPPED
        elif flaw.cause != TOO_SHORT:
            self._end_hold()
