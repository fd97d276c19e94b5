"""The simulated scene in which a strategy was tried: optional keys of its file.

* `scene` (default `table`) and the `wall_inclination` [deg] of its wall (default: the scene's);
* `model` of the hand's physics, by name (default: the simulator's), and `segments` per actuator
  (5);
* `step` of the physics [s] (0.002), and whether neighbouring fingers touch each other
  (`finger_contact`, false);
* `place` of the object: (x, y) [m], or `corner`: it touches the planes x = 0 and y = 0 from x > 0
  and y < 0 (thesis, section 8.1.2). The scene's place is [0, 0];
* `upright`: names of the objects that stand on their end; others lie as they are described.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from softhand_common.documents.yaml_document import Bounds, Node
from softhand_model.usual_step import USUAL_STEP

CORNER_PLACE = "corner"
MAX_SEGMENTS = 15  # an actuator, as in the simulator
POSITION_BOUNDS = Bounds(-10.0, 10.0, "m")
INCLINATION_BOUNDS = Bounds(5.0, 120.0, "deg")
STEP_BOUNDS = Bounds(1e-4, 0.02, "s")


@dataclass(frozen=True)
class TriedWith:
    """The keys that the module describes; `place` is None for `corner`."""

    scene: str = "table"
    wall_inclination: float | None = None
    model: str = ""
    segments: int = 5
    place: tuple[float, float] | None = (0.0, 0.0)
    upright: tuple[str, ...] = ()
    step: float = USUAL_STEP
    finger_contact: bool = False


TRIED_WITH_KEYS = tuple(TriedWith.__dataclass_fields__)


def read_tried_with(fields: Mapping[str, Node]) -> TriedWith:
    """The scene of a strategy from the keys of its file, `fields`; keys that are missing have their
    defaults.

    Raises DocumentError naming file, key, expected and got.
    """
    usual = TriedWith()
    return TriedWith(
        fields["scene"].text() if "scene" in fields else usual.scene,
        fields["wall_inclination"].within(INCLINATION_BOUNDS)
        if "wall_inclination" in fields
        else None,
        fields["model"].text() if "model" in fields else usual.model,
        fields["segments"].whole(1, MAX_SEGMENTS) if "segments" in fields else usual.segments,
        _place(fields["place"]) if "place" in fields else usual.place,
        fields["upright"].names() if "upright" in fields else usual.upright,
        fields["step"].within(STEP_BOUNDS) if "step" in fields else usual.step,
        "finger_contact" in fields and fields["finger_contact"].choice((False, True)),
    )


def _place(node: Node) -> tuple[float, float] | None:
    if node.value == CORNER_PLACE:
        return None
    if not isinstance(node.value, list):
        raise node.error(f"{CORNER_PLACE} or x and y [m]")
    x, y = node.vector(2, POSITION_BOUNDS)
    return x, y
