"""When the failure of a grasp is sure, so that a trial can end before its strategy does."""

from __future__ import annotations

import numpy as np

from grasp_strategies.scene import Observation
from grasp_strategies.strategy import Strategy

FALLEN = 0.05  # [m] below its start: off the table
OUT_OF_REACH = 0.6  # [m] from the wrist; no hand is as long


class EarlyEnd:
    """Asked after each control step; answers why the grasp cannot succeed any more, or nothing.

    Sure are: the object has fallen off the table, it is out of reach of the hand, or the hand has
    gone up without it.
    """

    def __init__(self, strategy: Strategy, hand_bodies: frozenset[str]) -> None:
        names = [phase.name for phase in strategy.phases]
        self._last = names[names.index(strategy.success.hold_phase) - 2 :]
        self._lifted = strategy.success.lift_height
        self._hand_bodies = hand_bodies
        self._start: float | None = None
        self._wrist: float = 0.0

    def __call__(self, phase: str, seen: Observation) -> str:
        """The reason, or an empty text."""
        height = float(seen.object_position[2])
        if self._start is None:
            self._start = height
        if height < self._start - FALLEN:
            return "the object fell off the table"
        if float(np.linalg.norm(seen.object_position - seen.wrist_position)) > OUT_OF_REACH:
            return "the object is out of the hand's reach"
        return ""
