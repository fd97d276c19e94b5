"""Verdict on a grasp: success if the object was lifted and held for a while by the hand alone,
without slip or turn.

After section 8.1.2 of the thesis: the hand lifts the object by 100 mm and holds it for 1 s; the
object follows the hand, does not slip and touches nothing else.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from itertools import chain
from typing import NamedTuple

import numpy as np

from grasp_strategies.judging.adaptability import Adaptability
from grasp_strategies.pose import Pose, angle_between, inverse
from grasp_strategies.scene import Observation
from grasp_strategies.strategy import Success
from softhand_common.numerics.rotations import compose

OUTCOME_GRIPPED, OUTCOME_LOST, OUTCOME_NONE = "gripped", "lost", "none"
# what may be wrong with a hold; others than the hand are named in place of the braces
SLIPPED_IN_HOLD, TURNED_IN_HOLD, DROPPED = "slipped in the hold", "turned in the hold", "dropped"
TOUCHED, TOO_LOW, TOO_SHORT = "touched the {}", "lifted too low", "held too short"
NOT_REACHED, NO_NUMBER, NOT_BEGUN = "hold not reached", "diverged", "not begun"
CARRIED_HEIGHT = 0.010  # [m] above its start, touched by the hand alone: the hand had the object


@dataclass(frozen=True)
class GraspResult:
    """Outcome of one grasp.

    Attributes:
        outcome: `gripped` (held as required), `lost` (the hand lifted the object off the ground,
            but did not hold it as required) or `none`.
        lift_height: greatest rise of the object [m].
        slip, turn: greatest drift [m] and rotation [rad] of the object in the wrist frame while the
            hand alone holds it at height; NaN if it never does.
        hold_time: longest uninterrupted hold [s].
        duration: duration of the whole strategy [s].
        reason: one sentence.
        completed: whether all phases ran.
        safe: False when an abort could not be carried out.
        pose_in_hand: position [m] and quaternion (x, y, z, w) of the object in the wrist frame when
            it was last held; empty if it never was.
        touching: parts of the hand that held the object then; empty if none did.
        lift_slip, lift_turn: drift [m] and rotation [rad] as `slip` and `turn`, but from when the
            hand alone carries the object until the hold begins. They do not count in the verdict:
            soft fingers yield when they take the weight.
        phase, cause: phase and cause of a failure (see `failure`); empty for a success.
        failed_at: time [s] of the failure since the start; NaN for a success.
        contacts: figures of the contacts at the end of the hold of a success; None for a failure,
            and where the scene has no contact points, as over ROS.
    """

    outcome: str
    lift_height: float
    slip: float
    hold_time: float
    duration: float
    reason: str
    completed: bool = True
    safe: bool = True
    turn: float = math.nan
    pose_in_hand: tuple[float, ...] = ()
    touching: tuple[str, ...] = ()
    lift_slip: float = math.nan
    lift_turn: float = math.nan
    phase: str = ""
    cause: str = ""
    failed_at: float = math.nan
    contacts: Adaptability | None = None

    @property
    def gripped(self) -> bool:
        """Whether the grasp counts as a success."""
        return self.outcome == OUTCOME_GRIPPED

    @classmethod
    def not_begun(cls, reason: str) -> GraspResult:
        """Result of a strategy that ended before its first observation of the scene."""
        return cls(OUTCOME_NONE, 0.0, math.nan, 0.0, 0.0, reason, completed=False, cause=NOT_BEGUN)

    def stopped(
        self, reason: str, safe: bool = True, phase: str = "", cause: str = ""
    ) -> GraspResult:
        """A copy of this result for a strategy that ended early; `cause`, if given, is that of the
        failure.
        """
        early = replace(self, reason=reason, completed=False, safe=safe)
        return replace(early, phase=phase, cause=cause, failed_at=self.duration) if cause else early

    def summary(self) -> dict[str, str]:
        """All fields as texts, those of `contacts`, if there are any, as `contacts_links` etc.;
        numbers in SI units.

        >>> GraspResult.not_begun("no simulator").summary()["slip"]
        'nan'
        """
        told = asdict(self)
        contacts = told.pop("contacts") or {}
        told |= {f"contacts_{key}": value for key, value in contacts.items()}
        return {key: _text(value) for key, value in told.items()}


def _text(value: object) -> str:
    if isinstance(value, tuple):
        return ", ".join(map(_text, value))
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def in_hand(observation: Observation) -> Pose:
    """Pose of the object in the wrist frame: constant while the hand holds it."""
    turned = compose(inverse(observation.wrist_orientation), observation.object_orientation)
    return Pose(observation.object_in_wrist, turned)


def held_by(observation: Observation, hand_bodies: frozenset[str]) -> bool:
    """Whether the hand, and nothing else, touches the object."""
    return bool(observation.touching) and observation.touching <= hand_bodies


def is_number(observation: Observation) -> bool:
    """Whether the poses of wrist and object are finite numbers. After a simulation has diverged,
    they are not.
    """
    wrist = (observation.wrist_position, observation.wrist_orientation)
    seen = (*wrist, observation.object_position, observation.object_orientation)
    return all(map(math.isfinite, chain.from_iterable(part.tolist() for part in seen)))


class Flaw(NamedTuple):
    """Why a grasp does not count: a cause (a constant of this module) and a sentence."""

    cause: str
    sentence: str


class Drift:
    """Greatest distance `slip` [m] and angle `turn` [rad] of a pose from its first value; NaN
    before.
    """

    def __init__(self) -> None:
        self._origin: Pose | None = None
        self.slip = self.turn = math.nan

    def watch(self, now: Pose) -> None:
        """Take in the present pose."""
        if self._origin is None:
            self._origin, self.slip, self.turn = now, 0.0, 0.0
        self.slip = max(self.slip, float(np.linalg.norm(now.position - self._origin.position)))
        self.turn = max(self.turn, angle_between(self._origin.orientation, now.orientation))


class GraspJudge:
    """Watches a grasp from its first observation on and judges it by a strategy's criteria."""

    def __init__(self, success: Success, hand_bodies: frozenset[str], first: Observation) -> None:
        self._success, self._hand_bodies = success, hand_bodies
        self._first = self._last = first
        self._lift_height = 0.0
        self._carried = False
        self._lift, self._hold = Drift(), Drift()
        self._held_last: Observation | None = None
        self._held_since: float | None = None
        self._hold_time = 0.0
        self._reached = False
        self._flaw: Flaw | None = None
        self._flaw_time = math.nan

    def rise(self, observation: Observation) -> float:
        """Height of the object above its start [m]."""
        return float(observation.object_position[2] - self._first.object_position[2])

    def watch(self, observation: Observation, holding: bool) -> None:
        """Take in one observation; `holding` says whether the hold phase runs."""
        self._last = observation
        rise = self.rise(observation)
        self._lift_height = max(self._lift_height, rise)
        carried = rise > CARRIED_HEIGHT and held_by(observation, self._hand_bodies)
        self._carried |= carried
        if holding:
            self._watch_hold(observation, rise)
            return
        self._held_since = None
        if not self._reached:
            self._watch_lift(observation, carried)

    @property
    def was_held(self) -> bool:
        """Whether the object was held at any instant of the hold phase."""
        return self._held_last is not None

    @property
    def flaw_time(self) -> float:
        """Time of the scene [s] of the first flaw in the hold; the present time if there was
        none.
        """
        return self._flaw_time if self._flaw else self._last.time

    @property
    def lift_slip(self) -> float:
        """`GraspResult.lift_slip` so far [m]."""
        return self._lift.slip

    def flaw(self) -> Flaw | None:
        """Why the observations so far make no success; None when they do."""
        held = self._hold_time > self._success.hold_time - 1e-6
        drifted = self._drifted()
        if self._flaw and not held and self._flaw.cause not in (SLIPPED_IN_HOLD, TURNED_IN_HOLD):
            return self._flaw
        if drifted or held:
            return drifted
        if not self._reached:
            return Flaw(NOT_REACHED, "the hold was not reached")
        asked = f"{self._success.hold_time:.2f} s"
        return Flaw(TOO_SHORT, f"held only {self._hold_time:.2f} s of {asked}")

    def result(self) -> GraspResult:
        """The outcome by the observations so far."""
        flaw, held = self.flaw(), self._held_last
        pose = held and in_hand(held)
        return GraspResult(
            OUTCOME_LOST if flaw and self._carried else OUTCOME_NONE if flaw else OUTCOME_GRIPPED,
            self._lift_height,
            self._hold.slip,
            self._hold_time,
            self._last.time - self._first.time,
            flaw.sentence if flaw else self._praise(),
            turn=self._hold.turn,
            pose_in_hand=(*pose.position.tolist(), *pose.orientation.tolist()) if pose else (),
            touching=tuple(sorted(held.touching)) if held else (),
            lift_slip=self._lift.slip,
            lift_turn=self._lift.turn,
        )

    def _watch_lift(self, observation: Observation, carried: bool) -> None:
        if not carried:
            self._lift = Drift()
        elif is_number(observation):
            self._lift.watch(in_hand(observation))

    def _watch_hold(self, observation: Observation, rise: float) -> None:
        self._reached = True
        flaw = self._flaw_of(observation, rise)
        if flaw is None:
            self._go_on_holding(observation)
        else:
            self._held_since = None
        if self._flaw is None and (flaw := flaw or self._drifted()):
            self._flaw, self._flaw_time = flaw, observation.time

    def _go_on_holding(self, observation: Observation) -> None:
        self._hold.watch(in_hand(observation))  # a break does not begin the drift anew
        self._held_last = observation
        if self._held_since is None:
            self._held_since = observation.time
        self._hold_time = max(self._hold_time, observation.time - self._held_since)

    def _flaw_of(self, observation: Observation, rise: float) -> Flaw | None:
        """Why this observation does not count as held; None when it does."""
        if not is_number(observation):
            sentence = "the pose of the object or of the wrist was not finite in the hold"
            return Flaw(NO_NUMBER, sentence)
        others = sorted(observation.touching - self._hand_bodies)
        if others:
            cause = TOUCHED.format(others[0]) if rise > CARRIED_HEIGHT else DROPPED
            return Flaw(cause, f"{', '.join(others)} touched the object in the hold")
        if not observation.touching:
            return Flaw(DROPPED, "nothing touched the object in the hold")
        if not rise >= self._success.lift_height:
            return Flaw(TOO_LOW, f"the object was only {1e3 * rise:.0f} mm up in the hold")
        return None

    def _drifted(self) -> Flaw | None:
        """Whether the object slipped or turned too far in the hold."""
        asked, hold = self._success, self._hold
        if hold.slip > asked.max_slip:
            return Flaw(
                SLIPPED_IN_HOLD,
                f"the object slipped by {1e3 * hold.slip:.1f} mm in the hold, more than "
                f"{1e3 * asked.max_slip:.1f} mm",
            )
        if hold.turn > asked.max_turn:
            return Flaw(
                TURNED_IN_HOLD,
                f"the object turned by {math.degrees(hold.turn):.1f} deg in the hand, more than "
                f"{math.degrees(asked.max_turn):.1f} deg",
            )
        return None

    def _praise(self) -> str:
        return (
            f"lifted {1e3 * self._lift_height:.0f} mm, held {self._hold_time:.2f} s by the hand "
            f"alone, slip {1e3 * self._hold.slip:.2f} mm, "
            f"turn {math.degrees(self._hold.turn):.1f} deg"
        )
