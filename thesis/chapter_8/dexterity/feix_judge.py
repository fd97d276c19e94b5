"""Judge of the grasps of the Feix taxonomy: is the object held, and by the right parts (8.2.2)?

In the thesis a person judges: a grasp counts when the contacts between hand and object do not
change while the hand is turned and moved. The two verdicts here are independent of each other. All
limits are our choice, fixed before any search.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from thesis.chapter_8.dexterity.feix import FINGERS, PAD_TYPE, PALM, SIDE_TYPE, GraspType

Array = NDArray[np.float64]
Region = tuple[str, int]  # part of the hand, and third of a finger from its base on (else 0)
THIRDS = 3

MOST_DRIFT, MOST_TURN = 0.010, math.radians(20.0)  # of the object in the wrist frame [m], [rad]
PRESENT = 0.05  # least share of the force of a region that has to be there after the shaking [-]
TOUCHING = 0.01  # least share of the force of what counts as touching [-]
# of a contact's place, as a share of the finger's length: a finger of 6 rigid segments touches a
# round thing at an end of one of them, and the least turn moves that by a whole segment [-]
RESOLUTION = 1.0 / 6.0
MOST_EXCLUDED = 0.20  # share of the force that an excluded finger may carry [-]
LEAST_OPPOSITION = math.radians(120.0)  # between the mean normals of the virtual fingers [rad]
LEAST_ON_SIDE = 0.5  # share of a finger's force that has to be on its flanks in side types [-]


@dataclass(frozen=True)
class Touch:
    """A contact of the object with a part of the hand.

    Place along the finger as a share of its length from the base (0 to 1; 0 for palm and thumb),
    side of the skin (`pad`, `back`, `+y`, `-y`; empty for the palm), unit normal (3,) in the wrist
    frame, and normal force [N].
    """

    part: str
    along: float
    side: str
    normal: tuple[float, ...]
    force: float

    @property
    def region(self) -> Region:
        """Part and third."""
        return self.part, min(THIRDS - 1, int(THIRDS * self.along))

    @property
    def on_flank(self) -> bool:
        """Whether the normal is within 45 deg of the finger's lateral axis."""
        return self.side in ("+y", "-y")


@dataclass(frozen=True)
class Shaken:
    """Observations of a grasp that was turned and shaken: contacts before and after, greatest drift
    [m] and turn [rad] of the object in the wrist frame during the motions, the drift and turn at
    the end, after elastic recovery, and the share of the motions' time in which drift and turn were
    within the limits (0 to 1).
    """

    before: Sequence[Touch]
    after: Sequence[Touch]
    drift: float
    turn: float
    left: tuple[float, float] = (math.inf, math.inf)
    kept: float = 1.0

    @property
    def at_rest(self) -> Shaken:
        """A copy with the values at the end in place of the greatest."""
        return replace(self, drift=self.left[0], turn=self.left[1])


@dataclass(frozen=True)
class Verdict:
    """Whether a criterion is met, and if not, why."""

    good: bool
    reason: str = ""


def judge_held(seen: Shaken, resolution: float = RESOLUTION) -> Verdict:
    """Whether the object kept its place in the hand and its contacts: each in the same region, or
    beside it by no more than the resolution of a contact's place (share of a finger's length).
    """
    reasons = []
    if not seen.before:
        return Verdict(False, "nothing touches the object")
    if seen.drift > MOST_DRIFT:
        reasons.append(f"drifts by {1e3 * seen.drift:.0f} mm")
    if seen.turn > MOST_TURN:
        reasons.append(f"turns by {math.degrees(seen.turn):.0f} deg")
    lost = [
        region
        for region in regions(seen.before, PRESENT)
        if share_near(seen.after, region, resolution) < TOUCHING
    ]
    if lost:
        reasons.append("loses " + ", ".join(name_of(region) for region in sorted(lost)))
    return Verdict(not reasons, "; ".join(reasons))


def judge_type(kind: GraspType, touches: Sequence[Touch]) -> Verdict:
    """Whether the object is held by the parts of the hand, and in the opposition, that define a
    type.
    """
    forces = shares(touches, lambda touch: touch.part)
    reasons = []
    missing = sorted(part for part in kind.required if forces[part] < TOUCHING)
    if missing:
        reasons.append(f"not touched by {', '.join(missing)}")
    reasons += [
        f"{part} carries {100 * forces[part]:.0f} %"
        for part in sorted(kind.excluded)
        if forces[part] > MOST_EXCLUDED
    ]
    if kind.opposition == PAD_TYPE and forces[PALM] >= TOUCHING:
        reasons.append("touched by the palm")
    angle = opposition(kind, touches)
    if not angle > LEAST_OPPOSITION:
        reasons.append(f"virtual fingers at {math.degrees(angle):.0f} deg")
    reasons += [f"{part} not with its side" for part in flat_fingers(kind, touches)]
    return Verdict(not reasons, "; ".join(reasons))


def opposition(kind: GraspType, touches: Sequence[Touch]) -> float:
    """Angle [rad] between the force-weighted mean normals of the two virtual fingers; 0 where one
    of them does not touch, or its mean normal vanishes.
    """
    first, second = (_mean_normal(touches, parts) for parts in (kind.first, kind.second))
    sizes = np.linalg.norm(first) * np.linalg.norm(second)
    if sizes < 1e-12:
        return 0.0
    return float(np.arccos(np.clip(first @ second / sizes, -1.0, 1.0)))


def flat_fingers(kind: GraspType, touches: Sequence[Touch]) -> list[str]:
    """Fingers that should touch with a flank, but have more than half of their force elsewhere;
    empty for types of another opposition.
    """
    if kind.opposition != SIDE_TYPE:
        return []
    found = []
    for part in sorted(kind.required & set(FINGERS)):
        own = [touch for touch in touches if touch.part == part]
        if own and shares(own, lambda touch: touch.on_flank)[True] < LEAST_ON_SIDE:
            found.append(part)
    return found


def _mean_normal(touches: Iterable[Touch], parts: Sequence[str]) -> Array:
    total = np.zeros(3)
    for touch in touches:
        if touch.part in parts:
            total += touch.force * np.array(touch.normal)
    return total


def shares(touches: Sequence[Touch], key: Callable[[Touch], object]) -> dict[object, float]:
    """Share of the normal force by the value of `key` of a contact; 0 for missing values."""
    found: dict[object, float] = defaultdict(float)
    total = sum(touch.force for touch in touches)
    for touch in touches:
        found[key(touch)] += touch.force / total if total > 0 else 0.0
    return found


def regions(touches: Sequence[Touch], least: float) -> set[Region]:
    """Regions that carry at least this share of the force."""
    found = shares(touches, lambda touch: touch.region)
    return {region for region, share in found.items() if share >= least}  # type: ignore[misc]


def share_near(touches: Sequence[Touch], region: Region, margin: float) -> float:
    """Share of the normal force in a region that is wider by a margin at both of its ends."""
    part, third = region
    low, high = third / THIRDS - margin, (third + 1) / THIRDS + margin
    return shares(touches, lambda touch: touch.part == part and low <= touch.along <= high)[True]


def name_of(region: Region) -> str:
    """Name of a region for messages."""
    part, third = region
    return f"{part}'s {('base', 'middle', 'end')[third]} third" if part in FINGERS else part
