"""Stored grasp patterns: the air masses and object pose of each grasp of an object that is held out
to the hand.

The file has the keys

* `format: softhand-grasp-patterns/1`, `hand` (name of a shipped one), `step` [s] and `segments` of
  the simulation in which the patterns were found;
* `times` [s]: `pre`, the ramp to the pre-grasp masses; `settle`, a pause after each ramp; `grasp`,
  each ramp to the final masses; `release`, in which the spring that holds the object fades;
* `grasps`, by the number of the type, each with
  - `object`: name of a shipped object;
  - `pre`, `final`: {channel: air mass [kg above the fill at rest]};
  - `palm_first`: whether the channels of palm and thumb are filled first and then those of the
    fingers, each in a ramp of its own; else all in one ramp;
  - `position` [m], `orientation` (x, y, z, w): of the object in the wrist frame, where the spring
    holds it from the end of the pre-grasp on;
  - `seed`, `evaluation`, `cost`: where the search found it;
  - `held`, `typed`: in how many of its `trials` the object was held, and by the right parts;
  - `robust`: least force [N] that moved the object by 10 mm, of six directions;
  - `trials`: by their numbers, the results of each jittered run (see `TRIAL`).

Numbers are written so that they are read back bit for bit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import yaml

from softhand_common.documents.output_file import write_file
from softhand_common.documents.quoted import quoted
from softhand_common.documents.yaml_document import Bounds, Node, read_document

FORMAT = "softhand-grasp-patterns/1"
FILE = Path(__file__).parent / "data" / "feix_patterns.yaml"
STEP, DURATION = Bounds(1e-4, 0.1, "s"), Bounds(1e-3, 1e3, "s")
PLACE, AIR = Bounds(-10.0, 10.0, "m"), Bounds(-0.1, 0.1, "kg")
MOST_TYPES = 1000
TRIAL = {
    "held": "whether the object was held through all that the judge does",
    "by_thirds": "whether it was, were no contact allowed past the border of its third",
    "at_rest": "whether it was, by drift and turn that are left when all has sprung back",
    "typed": "whether the right parts of the hand held it in the right way",
    "held_reason": "why not, in words; empty if it was",
    "typed_reason": "the same of the type",
    "markers": "finger: position (3,) [m] in the wrist frame of the marker on its tip, on its back "
    "or on the thumb's side, once the object is released and rests",
    "object": "position (3,) [m] and orientation (4,) of the object in the wrist frame then",
}


@dataclass(frozen=True)
class Times:
    """Durations [s] of the parts of a grasp; see the module's text."""

    pre: float = 0.6
    settle: float = 0.3
    grasp: float = 1.0
    release: float = 0.4


@dataclass(frozen=True)
class Pattern:
    """Commands of one grasp; see the module. Masses [kg] by channel."""

    object: str
    pre: Mapping[str, float]
    final: Mapping[str, float]
    palm_first: bool
    position: tuple[float, ...]
    orientation: tuple[float, ...]


@dataclass(frozen=True)
class StoredGrasp:
    """A pattern with its origin in the search and the results of its trials."""

    pattern: Pattern
    seed: int
    evaluation: str
    cost: float
    held: int
    typed: int
    robust: float
    trials: tuple[Mapping[str, Any], ...]


@dataclass(frozen=True)
class Patterns:
    """A file of patterns: hand, step [s], segments, times, and the grasps by type."""

    hand: str
    step: float
    segments: int
    times: Times
    grasps: Mapping[int, StoredGrasp]


def write_patterns(patterns: Patterns, path: Path) -> None:
    """Write a file of patterns, over an earlier one."""
    content = {
        "format": FORMAT,
        "hand": patterns.hand,
        "step": patterns.step,
        "segments": patterns.segments,
        "times": asdict(patterns.times),
        "grasps": {number: _plain(stored) for number, stored in patterns.grasps.items()},
    }
    text = yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=150)
    write_file(path, text)


def _plain(stored: StoredGrasp) -> dict[str, Any]:
    own = asdict(stored)
    pattern = own.pop("pattern")
    own["trials"] = list(own["trials"])
    lists = {key: list(pattern[key]) for key in ("position", "orientation")}
    return {**pattern, **lists, **own}


def load_patterns(path: Path = FILE) -> Patterns:
    """Read a file of patterns; raises ValueError naming file, key, expected and got."""
    top = read_document(path, FORMAT).fields(
        ["format", "hand", "step", "segments", "times", "grasps"]
    )
    times = top["times"].fields(list(Times.__dataclass_fields__))
    return Patterns(
        top["hand"].name(),
        top["step"].within(STEP),
        top["segments"].whole(1, 100),
        Times(**{key: node.within(DURATION) for key, node in times.items()}),
        {number: _stored(row) for number, row in _by_type(top["grasps"]).items()},
    )


def _by_type(node: Node) -> dict[int, Node]:
    """Children of a mapping whose keys are numbers of grasp types."""
    if not isinstance(node.value, dict):
        raise node.error("a mapping of grasps by the number of their type")
    for key in node.value:
        if isinstance(key, bool) or not isinstance(key, int) or not 0 < key <= MOST_TYPES:
            raise node.error(f"numbers of types from 1 to {MOST_TYPES}", quoted(key))
    rows = Node(node.file, node.key, {str(k): v for k, v in node.value.items()}, node.source)
    return {int(number): row for number, row in rows.mapping().items()}


def _stored(node: Node) -> StoredGrasp:
    own = list(StoredGrasp.__dataclass_fields__)[1:]
    row = node.fields([*Pattern.__dataclass_fields__, *own])
    pattern = Pattern(
        row["object"].name(),
        _masses(row["pre"]),
        _masses(row["final"]),
        row["palm_first"].choice([True, False]),
        row["position"].vector(3, PLACE),
        _orientation(row["orientation"]),
    )
    return StoredGrasp(
        pattern,
        row["seed"].whole(0, 2**32 - 1),
        row["evaluation"].text(),
        row["cost"].number(),
        row["held"].whole(0, 1000),
        row["typed"].whole(0, 1000),
        row["robust"].number(),
        tuple(_trial(item) for item in row["trials"].items()),
    )


def _orientation(node: Node) -> tuple[float, ...]:
    found = node.vector(4, Bounds(-1.0, 1.0, ""))
    if not 0.99 < sum(part**2 for part in found) < 1.01:
        raise node.error("a quaternion of length 1")
    return found


def _trial(node: Node) -> Mapping[str, Any]:
    for key, child in node.mapping().items():  # others are kept
        if key in ("held_reason", "typed_reason"):
            if not isinstance(child.value, str):
                raise child.error("text")
        elif key == "markers":
            for marker in child.mapping().values():
                marker.vector(3)
        elif key == "object":
            _pose(child)
        elif key in TRIAL:
            child.choice([True, False])
    return dict(node.value)


def _pose(node: Node) -> None:
    parts = node.items()
    if len(parts) != 2:
        raise node.error("a position and an orientation")
    parts[0].vector(3)
    parts[1].vector(4)


def _masses(node: Node) -> dict[str, float]:
    return {channel: child.within(AIR) for channel, child in node.mapping().items()}
