"""Trials of a stored grasp: run, shaken and judged; each gives one record of results."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, replace

from softhand_trials.sweep.task import DIGEST_DIGITS, Record
from thesis.chapter_8.dexterity.feix import grasp_types
from thesis.chapter_8.dexterity.feix_judge import judge_held, judge_type
from thesis.chapter_8.dexterity.grasping import SEGMENTS, STEP, Draw, drawn, grasping
from thesis.chapter_8.dexterity.patterns import Pattern, Times
from thesis.chapter_8.dexterity.posture import FOUR


@dataclass(frozen=True)
class HandSettings:
    """Settings of the simulation of a trial: object, variant of the hand, step [s], segments per
    actuator, factor on the rubber's modulus.
    """

    object: str
    hand: str = FOUR
    step: float = STEP
    segments: int = SEGMENTS
    modulus_scale: float = 1.0


@dataclass(frozen=True)
class PatternTrial:
    """One judged run of a pattern of a type; the result depends on these fields alone.

    Args:
        key: its name in the results.
        number: of the type.
        pattern: the grasp, with its times.
        draw: variation of the run.
        strength: of shaking and swinging; 1 is that of the judge.
        robust: whether the force that moves the object is measured as well.
        settings: of the simulation.
    """

    key: str
    number: int
    pattern: Pattern
    times: Times
    draw: Draw
    strength: float
    robust: bool
    settings: HandSettings

    @property
    def digest(self) -> str:
        """Hash of all but the key."""
        text = json.dumps(asdict(replace(self, key="")), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:DIGEST_DIGITS]

    def describe(self) -> Record:
        """Key, digest, type, and how it differs from the pattern."""
        return {
            "key": self.key,
            "digest": self.digest,
            "type": self.number,
            "draw": asdict(self.draw),
            "strength": self.strength,
        }

    def result(self) -> Record:
        """See `patterns.TRIAL`; `joints` (n, 4) with it, and `robust` [N] if asked for. A run that
        diverges has failed.
        """
        try:
            return self._judged()
        except RuntimeError as reason:
            grasping.cache_clear()
            words = {"held_reason": str(reason), "typed_reason": str(reason)}
            return {"held": False, "typed": False, **words}

    def _judged(self) -> Record:
        settings = self.settings
        hand = grasping(
            settings.object,
            settings.hand,
            settings.step,
            settings.segments,
            settings.modulus_scale,
        )
        found = hand.grasp(self.pattern, self.times, self.draw)
        typed = judge_type(grasp_types()[self.number], found.touches)
        markers, pose = hand.markers(), hand.object_in_wrist()
        joints = hand.simulation.bodies.q.tolist()
        robust = {"robust": hand.robust()} if self.robust else {}
        seen = hand.shaken(self.strength)
        held = judge_held(seen)
        return {
            "held": held.good,
            "by_thirds": judge_held(seen, resolution=0.0).good,
            "at_rest": judge_held(seen.at_rest).good,
            "typed": typed.good,
            "held_reason": held.reason,
            "typed_reason": typed.reason,
            "markers": markers,
            "object": [pose.position.tolist(), pose.orientation.tolist()],
            "joints": joints,
            **robust,
        }


def fresh_trials(
    key: str,
    number: int,
    pattern: Pattern,
    times: Times,
    settings: HandSettings,
    seed: int,
    count: int,
    *,
    strength: float = 1.0,
    friction_scale: float = 1.0,
) -> list[PatternTrial]:
    """Jittered runs of a pattern, each with a draw of its own; only the first measures
    robustness.
    """
    found = []
    for trial in range(count):
        draw = drawn((seed, number, trial))
        draw = replace(draw, friction_scale=friction_scale * draw.friction_scale)
        own = replace(settings, modulus_scale=draw.modulus_scale)
        robust = trial == 0 and strength == 1.0 and friction_scale == 1.0
        name = f"{key}/{number}/{trial + 1}"
        found.append(PatternTrial(name, number, pattern, times, draw, strength, robust, own))
    return found
