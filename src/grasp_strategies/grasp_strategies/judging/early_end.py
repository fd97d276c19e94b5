"""When the verdict of a grasp is sure, so that a trial can end before its strategy does."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import numpy as np

from grasp_strategies.judging.failure import AFTER, BEFORE, HOLD, GraspWatch
from grasp_strategies.judging.judge import SLIPPED, TOO_SHORT, TURNED
from grasp_strategies.scene import Array
from grasp_strategies.strategy import Phase, Strategy

CLEAR = 0.080  # [m] that a hand must have gone up without the object: no finger is hooked below it
EMPTY_TIME = 0.2  # [s] for which it must not have touched it then
NEAR = 0.010  # [m] from the object, in which the way of a hand may differ from that without one
LOOK_EVERY = 10  # control steps between two looks at where the object is
KEEP_EVERY = 5  # control steps between two places of the hand that are kept


class EmptyCourse:
    """Where the hand comes when there is no object in its way: boxes around its links by phase.

    An object that is farther away from all of them, from a phase on, is not touched any more.
    """

    def __init__(self) -> None:
        self._boxes: dict[str, list[Array]] = {}
        self._left: dict[str, Array] = {}
        self._count = 0

    def keep(self, phase: str, boxes: Callable[[], Array]) -> None:
        """Take in where the hand is in a phase: boxes (k, 2, 3) [m], asked for now and then."""
        if self._count % KEEP_EVERY == 0 or phase not in self._boxes:
            self._boxes.setdefault(phase, []).append(boxes())
        self._count += 1

    def gap(self, phase: str, box: Array) -> float:
        """Least distance [m] of a box (2, 3) from the hand in this phase and all later ones; 0 in
        a phase that the empty hand did not come to.
        """
        if phase not in self._left:
            phases = list(self._boxes)
            later = phases[phases.index(phase) :] if phase in phases else []
            parts = [part for name in later for part in self._boxes[name]]
            self._left[phase] = np.concatenate(parts) if parts else box[np.newaxis]
        left = self._left[phase]
        apart = np.maximum(np.maximum(left[:, 0] - box[1], box[0] - left[:, 1]), 0.0)
        return float(np.sqrt((apart * apart).sum(axis=1).min()))


def looks_at_object(phases: Iterable[Phase]) -> bool:
    """Whether a course of phases depends on where the object is, even if it is not touched."""
    return any(phase.wrist is not None and phase.wrist.frame == "object" for phase in phases)


class EarlyEnd:
    """Asked after each control step; answers why the verdict is sure, or nothing.

    It is when the hold is over; when the object is off the table, or where the hand does not come
    any more; when the hand has gone up without it; and when it slipped in the hold, or what is left
    of the hold is too short.

    Args:
        strategy: that runs.
        course: of the empty hand, None where it says nothing of this one or the object may come
            back by itself.
        object_box: asked for the box (2, 3) [m] around the object.
        hand_boxes: asked for those around the hand's links (k, 2, 3) [m].
    """

    def __init__(
        self,
        strategy: Strategy,
        course: EmptyCourse | None,
        object_box: Callable[[], Array],
        hand_boxes: Callable[[], Array],
    ) -> None:
        hold = next(p for p in strategy.phases if p.name == strategy.success.hold_phase)
        self._spare = _spare_time(hold, strategy.success.hold_time)
        self._course, self._object_box, self._hand_boxes = course, object_box, hand_boxes
        self._looks, self._gap = 0, 0.0
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
        """Whether the hand comes nowhere near the object any more, which does not come nearer."""
        self._looks += 1
        if self._course is None or watch.touched or self._looks % LOOK_EVERY:
            return False
        before, self._gap = self._gap, self._course.gap(watch.phase, self._object_box())
        return self._gap > NEAR and self._gap >= before > 0.0

    def _went_up_empty(self, watch: GraspWatch) -> bool:
        height = float(watch.last.wrist_position[2])
        self._low = min(self._low, height)
        if watch.last.time < self._touched + EMPTY_TIME:
            return False
        return height > self._low + CLEAR or self._is_above()

    def _is_above(self) -> bool:
        """Whether all of the hand is above the object or beside it: a lift hooks nothing."""
        self._looks += 1
        if self._looks % LOOK_EVERY:
            return False
        (low, high), hand = self._object_box(), self._hand_boxes()
        above = hand[:, 0, 2] > high[2]
        apart = np.maximum(hand[:, 0, :2] - high[:2], low[:2] - hand[:, 1, :2]).max(axis=1)
        return bool((above | (apart > NEAR)).all())

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
