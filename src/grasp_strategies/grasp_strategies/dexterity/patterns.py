"""Stored grasp patterns: what brings a hand to a grasp of an object that is held out to it.

The file has the keys

* `format: softhand-grasp-patterns/1`, `hand` (name of a shipped one), `step` [s] and `segments` of
  the simulation in which they were found;
* `times` [s]: `pre`, the ramp to the pre-grasp masses; `settle`, a pause after each ramp; `grasp`,
  each ramp to the final masses; `release`, in which the spring that holds the object fades;
* `grasps`, by the number of the type, each with
  - `object`: name of a shipped object;
  - `pre`, `final`: {channel: air mass [kg above the fill at rest]};
  - `palm_first`: whether the channels of palm and thumb are filled first, then those of the
    fingers, each in a ramp of its own; else all in one ramp;
  - `position` [m], `orientation` (x, y, z, w): of the object in the wrist frame, where the spring
    holds it from the end of the pre-grasp on;
  - `seed`, `evaluation`, `cost`: where the search found it;
  - `held`, `typed`: in how many of its `trials` the object was held, and by the right parts;
  - `robust`: least force [N] that moved the object by 10 mm, of six directions;
  - `trials`: by their numbers, what each jittered run found (see `TRIAL`).

Numbers are written so that they come back bit for bit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import yaml

from softhand_model.documents.yaml_document import Node, read_document

FORMAT = "softhand-grasp-patterns/1"
FILE = Path(__file__).parents[1] / "data" / "dexterity" / "feix_patterns.yaml"
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
    """What brings a hand to one grasp; see the module's text. Masses [kg] by channel."""

    object: str
    pre: Mapping[str, float]
    final: Mapping[str, float]
    palm_first: bool
    position: tuple[float, ...]
    orientation: tuple[float, ...]


@dataclass(frozen=True)
class StoredGrasp:
    """A pattern with how it was found and what was found with it."""

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
    path.parent.mkdir(parents=True, exist_ok=True)
    text = yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=150)
    path.write_text(text, encoding="utf-8")


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
    rows = top["grasps"].value
    nodes = Node(top["grasps"].file, "grasps", {str(key): row for key, row in rows.items()})
    return Patterns(
        top["hand"].name(),
        top["step"].number(),
        top["segments"].whole(1, 100),
        Times(**{key: node.positive() for key, node in times.items()}),
        {int(number): _stored(row) for number, row in nodes.mapping().items()},
    )


def _stored(node: Node) -> StoredGrasp:
    own = list(StoredGrasp.__dataclass_fields__)[1:]
    row = node.fields([*Pattern.__dataclass_fields__, *own])
    pattern = Pattern(
        row["object"].name(),
        _masses(row["pre"]),
        _masses(row["final"]),
        row["palm_first"].choice([True, False]),
        row["position"].vector(3),
        row["orientation"].vector(4),
    )
    return StoredGrasp(
        pattern,
        row["seed"].whole(0, 2**32 - 1),
        row["evaluation"].text(),
        row["cost"].number(),
        row["held"].whole(0, 1000),
        row["typed"].whole(0, 1000),
        row["robust"].number(),
        tuple(item.value for item in row["trials"].items()),
    )


def _masses(node: Node) -> dict[str, float]:
    return {channel: child.number() for channel, child in node.mapping().items()}
