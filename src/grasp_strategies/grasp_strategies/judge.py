"""Whether a grasp succeeded: lifted, held for a while by the hand alone, without a slip."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace

import numpy as np

from grasp_strategies.scene import Array, Observation
from grasp_strategies.strategy import Success

GRIPPED, LOST, NONE = "gripped", "lost", "none"
NOT_REACHED = "the hold was not reached"
CARRIED_HEIGHT = 0.010  # [m] above its start, touched by the hand alone: the hand had the object


@dataclass(frozen=True)
class GraspResult:
    """Outcome of one grasp.

    `outcome`: `gripped` (held as asked), `lost` (the hand had it off the ground, but not as asked)
    or `none`. `lift_height`: greatest rise of the object [m]; `slip`: greatest drift of the object
    in the wrist frame while it is held at height by the hand alone [m], NaN if it never is;
    `hold_time`: longest time that this lasts [s]; `duration` of the whole strategy [s]; `reason`:
    one sentence; `completed`: whether all phases ran; `safe`: false when an abort could not be
    carried out.
    """

    outcome: str
    lift_height: float
    slip: float
    hold_time: float
    duration: float
    reason: str
    completed: bool = True
    safe: bool = True

    @property
    def gripped(self) -> bool:
        """Whether the grasp counts as a success."""
        return self.outcome == GRIPPED

    @classmethod
    def not_begun(cls, reason: str) -> GraspResult:
        """Result of a strategy that never saw the scene."""
        return cls(NONE, 0.0, math.nan, 0.0, 0.0, reason, completed=False)

    def stopped(self, reason: str, safe: bool = True) -> GraspResult:
        """The same observations when the strategy ended early."""
        return replace(self, reason=reason, completed=False, safe=safe)

    def summary(self) -> dict[str, str]:
        """All fields as texts; numbers in SI.

        >>> GraspResult.not_begun("no simulator").summary()["slip"]
        'nan'
        """
        return {
            key: f"{value:.6g}" if isinstance(value, float) else str(value)
            for key, value in asdict(self).items()
        }


class GraspJudge:
    """Watches a grasp from its first observation on and judges it by a strategy's criteria."""

    def __init__(self, success: Success, hand_bodies: frozenset[str], first: Observation) -> None:
        self._success, self._hand_bodies = success, hand_bodies
        self._first = self._last = first
        self._lift_height = 0.0
        self._carried = False
        self._hold_origin: Array | None = None
        self._held_since: float | None = None
        self._hold_time = 0.0
        self._slip = math.nan
        self._flaw = NOT_REACHED

    def rise(self, observation: Observation) -> float:
        """Height of the object above its start [m]."""
        return float(observation.object_position[2] - self._first.object_position[2])

    def watch(self, observation: Observation, holding: bool) -> None:
        """Take in one observation; `holding` says whether the hold phase runs."""
        self._last = observation
        rise = self.rise(observation)
        self._lift_height = max(self._lift_height, rise)
        self._carried |= rise > CARRIED_HEIGHT and self._held_by_hand_alone(observation)
        if holding:
            self._watch_hold(observation, rise)
        else:
            self._held_since = None

    def result(self) -> GraspResult:
        """The outcome by what was seen so far."""
        held = self._hold_time > self._success.hold_time - 1e-6
        slipped = self._slip > self._success.max_slip
        gripped = held and not slipped
        outcome = GRIPPED if gripped else LOST if self._carried else NONE
        return GraspResult(
            outcome,
            self._lift_height,
            self._slip,
            self._hold_time,
            self._last.time - self._first.time,
            self._reason(held, slipped),
        )

    def _held_by_hand_alone(self, observation: Observation) -> bool:
        return bool(observation.touching) and observation.touching <= self._hand_bodies

    def _watch_hold(self, observation: Observation, rise: float) -> None:
        if self._flaw == NOT_REACHED:
            self._flaw = ""
        flaw = self._flaw_of(observation, rise)
        if flaw:
            self._flaw = self._flaw or flaw
            self._held_since = None
            return
        if self._hold_origin is None:
            self._hold_origin, self._slip = observation.object_in_wrist, 0.0
        drift = float(np.linalg.norm(observation.object_in_wrist - self._hold_origin))
        self._slip = max(self._slip, drift)
        if self._held_since is None:
            self._held_since = observation.time
        self._hold_time = max(self._hold_time, observation.time - self._held_since)

    def _flaw_of(self, observation: Observation, rise: float) -> str:
        """Why this instant does not count as held; empty when it does."""
        others = sorted(observation.touching - self._hand_bodies)
        if others:
            return f"{', '.join(others)} touched the object in the hold"
        if not observation.touching:
            return "nothing touched the object in the hold"
        if rise < self._success.lift_height:
            return f"the object was only {1e3 * rise:.0f} mm up in the hold"
        return ""

    def _reason(self, held: bool, slipped: bool) -> str:
        if self._flaw and not held:
            return self._flaw
        if slipped:
            return (
                f"the object slipped by {1e3 * self._slip:.1f} mm in the hold, more than "
                f"{1e3 * self._success.max_slip:.1f} mm"
            )
        if not held:
            return f"held only {self._hold_time:.2f} s of {self._success.hold_time:.2f} s"
        return (
            f"lifted {1e3 * self._lift_height:.0f} mm, held {self._hold_time:.2f} s by the hand "
            f"alone, slip {1e3 * self._slip:.2f} mm"
        )
