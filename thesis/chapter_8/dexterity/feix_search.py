"""Search for a grasp of the Feix taxonomy: its starting point, variables and objective.

A search is limited to a range around values written by hand for the type
(`data/feix_starts.yaml`), where it starts unless a grasp is known: four air masses before and four
after the grasp, the filling order, and the pose of the object where the types differ in it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from softhand_common.documents.yaml_document import Node, read_document
from softhand_trials.search import Variable, objective
from thesis.chapter_8.dexterity.feix import PAD_TYPE, PALM, GraspType, grasp_types
from thesis.chapter_8.dexterity.feix_judge import (
    LEAST_OPPOSITION,
    MOST_EXCLUDED,
    TOUCHING,
    Touch,
    flat_fingers,
    judge_held,
    judge_type,
    opposition,
    shares,
)
from thesis.chapter_8.dexterity.grasping import (
    FAR,
    SEGMENTS,
    STEP,
    Draw,
    Grasped,
    GraspingHand,
    drawn,
    grasping,
)
from thesis.chapter_8.dexterity.patterns import Pattern, Times
from thesis.chapter_8.dexterity.posture import FOUR

FILE = Path(__file__).parent / "data" / "feix_starts.yaml"
FORMAT = "softhand-grasp-starts/1"
CHANNELS = "abcd"
PLACE, TURN, ORDER = ("x", "y", "z"), ("turn_x", "turn_y", "turn_z"), "palm_first"
MOST_OVERLAP = 0.005  # of the object with the pre-grasp posture [m]

# cost [mm]: what is held by the right parts costs what it drifts
OVERLAPS, DROPPED, AT_ONCE = 150.0, 60.0, 30.0
MISSING, A_GAP, EXCLUDED, BY_PALM, BY_FLAT, WRONG = 10.0, 0.2, 50.0, 10.0, 8.0, 5.0
A_DEGREE, MOST_TURN, WHILE_RELEASED = 0.5, 30.0, 0.1
NOT_HELD, LOST, AT_FIRST = 20.0, 40.0, 20.0


@dataclass(frozen=True)
class Start:
    """Starting point of the search for a type, and its ranges; see the file. `turned` are the
    object's own axes about which it may be turned.
    """

    pattern: Pattern
    turned: tuple[str, ...]
    most: Mapping[str, float]
    pre_within: float
    final_within: float
    place_within: float
    turn_within: float


@lru_cache(maxsize=1)
def starts() -> dict[int, Start]:
    """All starts by the numbers of the types."""
    limits = ["pre_within", "final_within", "place_within", "turn_within"]
    top = read_document(FILE, FORMAT).fields(
        ["format", "most", "balls", "round", *limits, "starts"]
    )
    most = {name: node.positive() for name, node in top["most"].mapping().items()}
    within = {name: top[name].positive() for name in limits}
    turned: dict[str, tuple[str, ...]] = {node.name(): () for node in top["balls"].items()}
    turned |= {node.name(): TURN[:2] for node in top["round"].items()}
    rows = {str(number): row for number, row in top["starts"].value.items()}
    nodes = Node(top["starts"].file, "starts", rows).mapping()
    patterns = {int(number): _pattern(int(number), row, most) for number, row in nodes.items()}
    return {
        number: Start(pattern, turned.get(pattern.object, TURN), most, **within)
        for number, pattern in patterns.items()
    }


def _pattern(number: int, node: Node, most: Mapping[str, float]) -> Pattern:
    row = node.fields(["pre", "final", "palm_first", "position", "rpy"])
    pre, final = (
        {c: s * most[c] for c, s in zip(CHANNELS, row[key].vector(4), strict=True)}
        for key in ("pre", "final")
    )
    turn = Rotation.from_euler("xyz", row["rpy"].vector(3)).as_quat()
    return Pattern(
        grasp_types()[number].object,
        pre,
        final,
        row["palm_first"].choice([True, False]),
        row["position"].vector(3),
        tuple(turn.tolist()),
    )


# ---------------------------------------------------------------- variables
def variables(number: int) -> tuple[Variable, ...]:
    """Variables of the search for a type: masses [kg], order (above 0.5: palm first), shift of the
    object from the start in the wrist frame [m], and its turn in its own axes [rad].
    """
    start = starts()[number]
    place, turn = start.place_within, start.turn_within
    masses = [
        Variable(f"{when}_{channel}", *_range(mass, start.most[channel], within))
        for when, by_channel, within in (
            ("pre", start.pattern.pre, start.pre_within),
            ("final", start.pattern.final, start.final_within),
        )
        for channel, mass in by_channel.items()
    ]
    return (
        *masses,
        Variable(ORDER, 0.0, 1.0),
        *(Variable(name, -place, place) for name in PLACE),
        *(Variable(name, -turn, turn) for name in start.turned),
    )


def _range(mass: float, most: float, within: float) -> tuple[float, float]:
    return max(0.0, mass - within * most), min(most, mass + within * most)


def start_values(number: int) -> dict[str, float]:
    """Values of the variables at the start."""
    pattern = starts()[number].pattern
    own = {f"pre_{c}": m for c, m in pattern.pre.items()}
    own |= {f"final_{c}": m for c, m in pattern.final.items()} | {ORDER: float(pattern.palm_first)}
    return {v.name: own.get(v.name, 0.0) for v in variables(number)}


def pattern_of(number: int, values: Mapping[str, float]) -> Pattern:
    """The pattern that values of the variables stand for."""
    start = starts()[number].pattern
    shift = np.array([values[name] for name in PLACE])
    turn = Rotation.from_rotvec([values.get(name, 0.0) for name in TURN])
    orientation = Rotation.from_quat(start.orientation) * turn
    return Pattern(
        start.object,
        {channel: values[f"pre_{channel}"] for channel in start.pre},
        {channel: values[f"final_{channel}"] for channel in start.final},
        values[ORDER] > 0.5,
        tuple((start.position + shift).tolist()),
        tuple(orientation.as_quat().tolist()),
    )


def values_of(number: int, pattern: Pattern) -> dict[str, float]:
    """Values of the variables that stand for a pattern, the opposite of `pattern_of`; those out of
    range are brought to its border.
    """
    start = starts()[number].pattern
    own = {f"pre_{c}": m for c, m in pattern.pre.items()}
    own |= {f"final_{c}": m for c, m in pattern.final.items()} | {ORDER: float(pattern.palm_first)}
    own |= dict(zip(PLACE, np.subtract(pattern.position, start.position).tolist(), strict=True))
    turn = Rotation.from_quat(start.orientation).inv() * Rotation.from_quat(pattern.orientation)
    own |= dict(zip(TURN, turn.as_rotvec().tolist(), strict=True))
    return {v.name: min(v.high, max(v.low, own[v.name])) for v in variables(number)}


# ---------------------------------------------------------------- objective
@dataclass(frozen=True)
class Moved:
    """How far [m] and by which angle [rad] the object moved in the hand when it was pulled or
    shaken, why the judge does not count it as held, if it was asked, and the share of the shaking
    in which it was within the judge's limits.
    """

    moved: float
    turned: float
    held_reason: str = ""
    kept: float = 1.0


NOT_TRIED = Moved(0.0, 0.0)  # it was not in the hand
NOT_SHAKEN = Moved(0.0, 0.0, "not shaken", kept=0.0)  # it was in the hand in another way


@objective
def grasp(values: Mapping[str, float], settings: Mapping[str, Any]) -> dict[str, Any]:
    """Objective of the search for a grasp: is the object held, and by the right parts?

    Args:
        values: of `variables`.
        settings: `type` (1 to 33), `hand` (see `grasping_hand`), `step` [s], `segments`, `draws`:
            seeds of the jitter with which the grasp is shaken, one after the other until it fails
            (`draw`: a single one, instead); without them the object is pulled without jitter,
            which takes a fifth of the time.

    Returns:
        `cost` [mm] (see `cost`), the mean over the draws, where those after a failure cost as
        much as the failure; and the parts of the last one.
    """
    draws = [settings["draw"]] if "draw" in settings else settings.get("draws", ())
    if not draws:
        return _tried(values, settings, None)
    costs: list[float] = []
    last: dict[str, Any] = {}
    for seed in draws:
        last = _tried(values, settings, seed)
        costs.append(last["cost"])
        if last["typed"] or last["held_reason"] or last["dropped"]:
            break
    costs += costs[-1:] * (len(draws) - len(costs))
    return {**last, "cost": sum(costs) / len(costs)}


def _tried(
    values: Mapping[str, float], settings: Mapping[str, Any], seed: Sequence[int] | None
) -> dict[str, Any]:
    """Cost and its parts with one draw of jitter, or without."""
    kind = grasp_types()[int(settings["type"])]
    draw = Draw() if seed is None else drawn(seed)
    hand = grasping(
        kind.object,
        str(settings.get("hand", FOUR)),
        float(settings.get("step", STEP)),
        int(settings.get("segments", SEGMENTS)),
        draw.modulus_scale,
    )
    try:
        found = hand.grasp(pattern_of(kind.number, values), Times(), draw, MOST_OVERLAP)
        tried = NOT_TRIED
        if found.overlap <= MOST_OVERLAP and not found.dropped:
            tried = Moved(*hand.pull()) if seed is None else _shaken(hand, kind, found)
    except RuntimeError:
        grasping.cache_clear()  # the engine has diverged
        raise
    return {
        "cost": cost(kind, found, tried),
        "overlap": found.overlap,
        "dropped": found.dropped,
        "drift": found.drift,
        "typed": judge_type(kind, found.touches).reason,
        **asdict(tried),
    }


def _shaken(hand: GraspingHand, kind: GraspType, found: Grasped) -> Moved:
    """What is held by the wrong parts is not shaken, and what is lost no longer than until then."""
    if not judge_type(kind, found.touches).good:
        return NOT_SHAKEN
    seen = hand.shaken(until_lost=True)
    return Moved(seen.drift, seen.turn, judge_held(seen).reason, seen.kept)


def cost(kind: GraspType, found: Grasped, tried: Moved) -> float:
    """Cost [mm] of a grasp, in three ranges that do not overlap.

    The highest range is for an object that overlaps the hand, so that the grasp cannot begin. Below
    it are grasps that drop the object: the cost is higher the earlier it is dropped and the more
    the contacts before that differ from the type's. Lowest are grasps that hold it: the cost grows
    with the difference of the contacts from the type's, and with the motion of the object when it
    is pulled or shaken. What moves too far when it is shaken costs more the earlier it does.
    """
    if found.overlap > MOST_OVERLAP:
        return OVERLAPS + 1e3 * found.overlap
    if found.dropped:
        early = AT_ONCE * (1.0 - found.stayed)
        return DROPPED + early + 0.5 * lacking(kind, found.held_out, found.gaps)
    way, turn = 1e3 * min(tried.moved, FAR), min(MOST_TURN, A_DEGREE * math.degrees(tried.turned))
    off = way + turn + WHILE_RELEASED * 1e3 * found.drift + (NOT_HELD if tried.held_reason else 0.0)
    if tried.kept < 1.0:
        off = LOST + AT_FIRST * (1.0 - tried.kept)
    return min(DROPPED, off) + lacking(kind, found.touches, found.gaps)


def lacking(kind: GraspType, touches: Sequence[Touch], gaps: Mapping[str, float]) -> float:
    """Cost [mm] of the difference between contacts and those required by a type; 0 when they
    agree.
    """
    forces = shares(touches, lambda touch: touch.part)
    missing = [part for part in kind.required if forces[part] < TOUCHING]
    found = sum(MISSING + A_GAP * 1e3 * min(FAR, _gap(part, gaps)) for part in missing)
    helping = [forces[part] - MOST_EXCLUDED for part in kind.excluded]
    found += sum(WRONG + EXCLUDED * share for share in helping if share > 0.0)
    if kind.opposition == PAD_TYPE and forces[PALM] >= TOUCHING:
        found += BY_PALM * (1.0 + forces[PALM])
    short = LEAST_OPPOSITION - opposition(kind, touches)
    if short >= 0:
        found += WRONG * (1.0 + short)
    return found + BY_FLAT * len(flat_fingers(kind, touches))


def _gap(part: str, gaps: Mapping[str, float]) -> float:
    names = (PALM, "palm_plate") if part == PALM else (part,)
    return max(0.0, min(gaps.get(name, FAR) for name in names))
