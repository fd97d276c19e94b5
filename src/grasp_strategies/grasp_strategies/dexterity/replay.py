"""Replays of stored grasps: a strategy's file whose values `$name` are those of the stored grasp.

| name | value |
|---|---|
| `type`, `type_name` | number and name of the grasp type |
| `hand`, `segments`, `scene`, `object` | with which it was found; segments an actuator |
| `pre`, `final`, `empty` | {channel: air mass [kg]} of pre-grasp and grasp, and none |
| `final_of_palm`, `final_of_fingers` | `final` of the channels of palm and thumb, of the others |
| `palm_first`, `simultaneous` | whether the former are filled first, or all at once |
| `position`, `orientation` | of the object where it is held out, in the wrist frame [m] |
| `times.pre`, `.settle`, `.grasp`, `.release` | durations [s] |

A phase with `only: $palm_first` is there where that is true. All else is as in any strategy.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from grasp_strategies.dexterity.feix import PALM, THUMB, grasp_types
from grasp_strategies.dexterity.patterns import FILE as PATTERNS
from grasp_strategies.dexterity.patterns import Patterns, load_patterns
from grasp_strategies.strategy import Strategy, read_strategy
from grasp_strategies.strategy.description import FORMAT
from softhand_model.documents.yaml_document import DocumentError, Node, read_document
from softhand_model.hand.hand import load_hand

FILE = Path(__file__).parents[1] / "data" / "dexterity" / "feix_strategy.yaml"
WORD = re.compile(r"\$([a-z_]+(?:\.[a-z_]+)*)")
ONLY = "only"
SCENE = "held"  # without a table, the hand upright


def load_replay(number: int, patterns: Path = PATTERNS, strategy: Path = FILE) -> Strategy:
    """The strategy that replays the stored grasp of a type.

    Args:
        number: of the type.
        patterns: file of stored grasps.
        strategy: file with `$name` in place of what is stored.

    Raises:
        ValueError: nothing is stored for the type, or a file is unusable; it says what there is.
    """
    document = read_document(strategy, FORMAT)
    filled = _filled(document, document.value, words(number, stored_grasps(patterns), patterns))
    filled["phases"] = [
        {key: value for key, value in phase.items() if key != ONLY}
        for phase in filled["phases"]
        if phase.get(ONLY, True)
    ]
    return read_strategy(Node(str(strategy), "", filled))


def stored_grasps(path: Path = PATTERNS) -> Patterns:
    """The stored grasps of a file; raises ValueError when there are none, or it is unusable."""
    if not path.exists():
        raise ValueError(
            f"no grasps are stored: expected {path}, which `python -m thesis run feix` finds and "
            "writes"
        )
    return load_patterns(path)


def simulator_settings(number: int, patterns: Path = PATTERNS) -> dict[str, Any]:
    """What a simulator needs to replay the stored grasp of a type, by the names of its parameters;
    raises ValueError as `load_replay`.
    """
    stored = stored_grasps(patterns)
    return {
        "hand": stored.hand,
        "object": words(number, stored, patterns)["object"],
        "scene": SCENE,
        "step": stored.step,
        "segments": stored.segments,
        "finger_contact": True,
    }


def words(number: int, patterns: Patterns, path: Path = PATTERNS) -> dict[str, Any]:
    """What the names in a replay's file stand for; raises ValueError for a type without a stored
    grasp.
    """
    if number not in patterns.grasps:
        there = ", ".join(map(str, sorted(patterns.grasps))) or "none"
        raise ValueError(
            f"grasp_type: expected one that is stored in {path} ({there}), got {number}"
        )
    pattern = patterns.grasps[number].pattern
    hand = load_hand(patterns.hand)
    palm = {c for name in (PALM, THUMB) for c in hand.chain(name).channels.values()}
    return {
        "type": number,
        "type_name": grasp_types()[number].name,
        "hand": patterns.hand,
        "segments": patterns.segments,
        "scene": SCENE,
        "object": pattern.object,
        "pre": dict(pattern.pre),
        "final": dict(pattern.final),
        "empty": dict.fromkeys(hand.channels, 0.0),
        "final_of_palm": {c: mass for c, mass in pattern.final.items() if c in palm},
        "final_of_fingers": {c: mass for c, mass in pattern.final.items() if c not in palm},
        "palm_first": pattern.palm_first,
        "simultaneous": not pattern.palm_first,
        "position": list(pattern.position),
        "orientation": list(pattern.orientation),
        **{f"times.{key}": value for key, value in asdict(patterns.times).items()},
    }


def _filled(document: Node, value: Any, words: Mapping[str, Any]) -> Any:
    """A value of a document with its names replaced; raises DocumentError for one that has no
    meaning.
    """
    if isinstance(value, dict):
        return {key: _filled(document, child, words) for key, child in value.items()}
    if isinstance(value, list):
        return [_filled(document, child, words) for child in value]
    if not isinstance(value, str):
        return value
    for name in WORD.findall(value):
        if name not in words:
            expected = ", ".join(f"${word}" for word in words)
            raise DocumentError(f"{document.file}: expected one of {expected}, got ${name}")
    whole = WORD.fullmatch(value)
    return words[whole[1]] if whole else WORD.sub(lambda found: str(words[found[1]]), value)
