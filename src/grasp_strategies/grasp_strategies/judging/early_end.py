"""Detects that the verdict of a grasp can no longer change, so that a trial can end early."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import numpy as np

from grasp_strategies.judging.failure import (
    STAGE_AFTER_HOLD,
    STAGE_BEFORE_LIFT,
    STAGE_HOLD,
    GraspWatch,
)
from grasp_strategies.judging.judge import SLIPPED_IN_HOLD, TOO_SHORT, TURNED_IN_HOLD
from grasp_strategies.scene import Array
from grasp_strategies.strategy import Phase, Strategy

# rise of the hand without the object [m] beyond which no finger can still hook it
CLEAR_HEIGHT = 0.080
EMPTY_TIME = 0.2  # time [s] without contact that is required as well
# allowed difference [m] of the hand's path from that of the empty hand
PATH_TOLERANCE = 0.010
CHECK_INTERVAL = 10  # control steps between two checks of the object's place
SAMPLE_INTERVAL = 5  # control steps between two stored places of the empty hand


class EmptyHandPath:
    """Path of the hand without an object in its way: boxes around its links, by phase.

    An object that is farther than PATH_TOLERANCE [m] from the boxes of a phase and of all later
    ones will not be touched any more.
    """

    def __init__(self) -> None:
        self._boxes: dict[str, list[Array]] = {}
        self._left: dict[str, Array] = {}
        self._count = 0

    def keep(self, phase: str, boxes: Callable[[], Array]) -> None:
        """Store where the hand is in a phase. `boxes` returns the boxes (k, 2, 3) [m] around its
        links, and is called at every SAMPLE_INTERVAL-th control step only.
        """
        if self._count % SAMPLE_INTERVAL == 0 or phase not in self._boxes:
            self._boxes.setdefault(phase, []).append(boxes())
        self._count += 1

    def gap(self, phase: str, box: Array) -> float:
        """Smallest distance [m] between a box (2, 3) [m] and the hand in this phase and all later
        ones; 0 in a phase that the empty hand did not reach.
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
    """Whether some phase depends on the object's pose even before the object is touched."""
    return any(phase.wrist is not None and phase.wrist.frame == "object" for phase in phases)


class EarlyEnd:
    """Called after each control step; returns why the verdict is certain, or an empty text.

    The verdict is certain when the hold is over; when the object is off the table or outside the
    hand's remaining path; when the hand has risen without the object; and when the object slipped
    in the hold or too little of the hold is left.

    Args:
        strategy: the strategy that runs.
        path: path of the empty hand; None if it does not apply to this trial, or if the object may
            come back by itself.
        object_box: returns the box (2, 3) [m] around the object.
        hand_boxes: returns the boxes (k, 2, 3) [m] around the hand's links.
    """

    def __init__(
        self,
        strategy: Strategy,
        path: EmptyHandPath | None,
        object_box: Callable[[], Array],
        hand_boxes: Callable[[], Array],
    ) -> None:
        hold = next(p for p in strategy.phases if p.name == strategy.success.hold_phase)
        self._spare = _spare_time(hold, strategy.success.hold_time)
        self._path, self._object_box, self._hand_boxes = path, object_box, hand_boxes
        self._looks, self._gap = 0, 0.0
        self._low = math.inf  # lowest wrist since the lift began [m]
        self._touched = -math.inf  # when the hand last touched the object [s]
        self._hold_began = self._flawed = math.inf  # [s]

    def __call__(self, watch: GraspWatch) -> str:
        """Why the verdict is certain; empty while it is not."""
        if watch.stage == STAGE_AFTER_HOLD:
            return "the hold is over"
        if watch.off_table:
            return "the object is off the table"
        if watch.touched:
            self._touched = watch.last.time
        if watch.stage == STAGE_BEFORE_LIFT:
            return "the object is out of reach" if self._out_of_reach(watch) else ""
        if self._went_up_empty(watch):
            return "the hand went up without the object"
        return self._lost_hold(watch) if watch.stage == STAGE_HOLD else ""

    def _out_of_reach(self, watch: GraspWatch) -> bool:
        """Whether the object is outside the hand's remaining path and does not approach it."""
        self._looks += 1
        if self._path is None or watch.touched or self._looks % CHECK_INTERVAL:
            return False
        before, self._gap = self._gap, self._path.gap(watch.phase, self._object_box())
        return self._gap > PATH_TOLERANCE and self._gap >= before > 0.0

    def _went_up_empty(self, watch: GraspWatch) -> bool:
        height = float(watch.last.wrist_position[2])
        self._low = min(self._low, height)
        if watch.last.time < self._touched + EMPTY_TIME:
            return False
        return height > self._low + CLEAR_HEIGHT or self._is_above()

    def _is_above(self) -> bool:
        """Whether every link is above or beside the object, so that lifting cannot hook it."""
        self._looks += 1
        if self._looks % CHECK_INTERVAL:
            return False
        (low, high), hand = self._object_box(), self._hand_boxes()
        above = hand[:, 0, 2] > high[2]
        apart = np.maximum(hand[:, 0, :2] - high[:2], low[:2] - hand[:, 1, :2]).max(axis=1)
        return bool((above | (apart > PATH_TOLERANCE)).all())

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
        return (
            flaw.sentence
            if flaw.cause in (SLIPPED_IN_HOLD, TURNED_IN_HOLD) or never or broken
            else ""
        )


def _spare_time(hold: Phase, needed: float) -> float:
    """Time [s] by which the hold phase exceeds the required hold; infinite if a condition ends
    it.
    """
    if hold.conditional or hold.wrist is not None:
        return math.inf
    return (hold.duration or 0.0) - needed
