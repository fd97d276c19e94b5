"""The world in which a strategy was tried: keys of its file, all optional.

* `scene` (`table`) and `wall_inclination` [deg] of it (the scene's);
* `model` of the hand's physics, by name (the simulator's), and `segments` an actuator (5);
* `place` of the object: (x, y) [m], or `corner`: it touches the planes x = 0 and y = 0 from x > 0
  and y < 0 (thesis, section 8.1.2). The scene's place is [0, 0];
* `upright`: names of the objects that stand on their end; others lie as they are described.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from softhand_model.documents.yaml_document import Bounds, Node

CORNER = "corner"
MOST_SEGMENTS = 15  # an actuator, as in the simulator
PLACE = Bounds(-10.0, 10.0, "m")
INCLINATION = Bounds(5.0, 120.0, "deg")


@dataclass(frozen=True)
class TriedWith:
    """See the module; `place` is None for the corner."""

    scene: str = "table"
    wall_inclination: float | None = None
    model: str = ""
    segments: int = 5
    place: tuple[float, float] | None = (0.0, 0.0)
    upright: tuple[str, ...] = ()


KEYS = tuple(TriedWith.__dataclass_fields__)


def read_tried_with(fields: Mapping[str, Node]) -> TriedWith:
    """The world of the keys that there are; raises an error with file, key, expected and got."""
    usual = TriedWith()
    return TriedWith(
        fields["scene"].text() if "scene" in fields else usual.scene,
        fields["wall_inclination"].within(INCLINATION) if "wall_inclination" in fields else None,
        fields["model"].text() if "model" in fields else usual.model,
        fields["segments"].whole(1, MOST_SEGMENTS) if "segments" in fields else usual.segments,
        _place(fields["place"]) if "place" in fields else usual.place,
        fields["upright"].names() if "upright" in fields else usual.upright,
    )


def _place(node: Node) -> tuple[float, float] | None:
    if node.value == CORNER:
        return None
    if not isinstance(node.value, list):
        raise node.error(f"{CORNER} or x and y [m]")
    x, y = node.vector(2, PLACE)
    return x, y
