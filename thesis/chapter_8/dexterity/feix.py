"""The 33 grasp types of Feix's taxonomy: which parts press against which (8.2.2, Fig. 8.9)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from softhand_common.documents.yaml_document import Node, read_document

FILE = Path(__file__).parent / "data" / "feix.yaml"
FORMAT = "softhand-grasp-types/1"
POWERS = ("power", "intermediate", "precision")
OPPOSITIONS = ("palm", "pad", "side")
THUMBS = ("abducted", "adducted")
PALM_TYPE, PAD_TYPE, SIDE_TYPE = OPPOSITIONS
PALM, THUMB = "palm", "thumb"
FINGERS = ("index", "middle", "ring", "little")
PARTS = (PALM, THUMB, *FINGERS)
COUNT, CUTKOSKY = 33, 17  # types; the first of them are those of Cutkosky


@dataclass(frozen=True)
class GraspType:
    """A grasp type: power, opposition and posture of the thumb, the parts of the hand that form the
    first and the second virtual finger, the name of the object, and a note.
    """

    number: int
    name: str
    power: str
    opposition: str
    thumb: str
    first: tuple[str, ...]
    second: tuple[str, ...]
    object: str
    note: str = ""

    @property
    def required(self) -> frozenset[str]:
        """Parts of the hand that have to touch the object."""
        return frozenset(self.first + self.second)

    @property
    def excluded(self) -> frozenset[str]:
        """Fingers that belong to neither virtual finger; the thumb may help in palm grasps."""
        free = {THUMB} if self.opposition == PALM_TYPE else set()
        return frozenset({THUMB, *FINGERS}) - self.required - free


@lru_cache(maxsize=1)
def grasp_types() -> dict[int, GraspType]:
    """All types by their numbers.

    >>> grasp_types()[16].opposition, sorted(grasp_types()[16].required)
    ('side', ['index', 'thumb'])
    """
    top = read_document(FILE, FORMAT).fields(["format", "types"])
    rows = top["types"].value
    nodes = Node(top["types"].file, "types", {str(key): row for key, row in rows.items()})
    return {int(number): _grasp_type(int(number), row) for number, row in nodes.mapping().items()}


def _grasp_type(number: int, node: Node) -> GraspType:
    required = ["name", "power", "opposition", "thumb", "first", "second", "object"]
    row = node.fields(required, ["note"])
    return GraspType(
        number,
        row["name"].text(),
        row["power"].choice(POWERS),
        row["opposition"].choice(OPPOSITIONS),
        row["thumb"].choice(THUMBS),
        tuple(part.choice(PARTS) for part in row["first"].items()),
        tuple(part.choice(FINGERS) for part in row["second"].items()),
        row["object"].name(),
        row["note"].text() if "note" in row else "",
    )
