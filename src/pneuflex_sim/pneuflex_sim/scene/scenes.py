"""Scenes: the surroundings of the hand, from data/scenes.yaml, and their fixed bodies in PyBullet.

The friction of a surface with the hand and with the object may differ by more than the engine's
product of two coefficients can express. Then the surface is created twice, once for the hand and
once for the object, each with its own coefficient.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.hand.collision import ENVIRONMENT_GROUP
from pneuflex_sim.scene.friction import FrictionTable
from softhand_common.documents.quoted import unknown
from softhand_common.documents.yaml_document import Bounds, Node, is_document, read_document
from softhand_model.hand import plausible

SCENE_FORMAT, SCENES_FORMAT = "pneuflex-scene/1", "pneuflex-scenes/1"
# beyond the latter the wall is where the hand starts [deg]
MIN_INCLINATION, MAX_INCLINATION = 5.0, 120.0
HAND_GROUPS = ~ENVIRONMENT_GROUP  # all groups of the hand
POSITION_BOUNDS = Bounds(-10.0, 10.0, "m")
ROLLING_RESISTANCE = Bounds(0.0, 0.1, "m")
# [m]: a marker of 17 mm starts to roll on a slope of 1.35 deg, a cylinder of 65 mm at 0.35 deg
USUAL_ROLLING = 2e-4
TABLE_SIZE = (1.2, 1.2, 0.04)  # [m] of a table with an edge


@dataclass(frozen=True)
class Table:
    """A level table; its top is the plane z = 0.

    Attributes:
        material: name under which `friction.yaml` lists its coefficients of friction.
        edge: x [m] of its edge; the table lies on the side of larger x. None: no edge anywhere.
        rolling_resistance: length [m] that, times the normal force, is the torque that
            brakes an object rolling on the table; fingers are not braked.
    """

    material: str
    edge: float | None = None
    rolling_resistance: float = USUAL_ROLLING


@dataclass(frozen=True)
class Wall:
    """A plane wall that meets the table in the line x = distance [m].

    inclination [deg]: angle to the table. A wall of 90 deg is upright; with less it slopes away
    from the object, with more it leans over the table. rolling_resistance [m]: as for a table.
    """

    material: str
    distance: float
    inclination: float
    rolling_resistance: float = USUAL_ROLLING

    @property
    def normal(self) -> tuple[float, float, float]:
        """Unit normal (3,) to the free side."""
        slope = math.radians(self.inclination)
        return -math.sin(slope), 0.0, math.cos(slope)


@dataclass(frozen=True)
class SceneDescription:
    """A scene: table and wall (None: absent), whether it has an object, the initial pose of the
    wrist [m, rad] and whether the wrist is rigid.
    """

    name: str
    table: Table | None
    wall: Wall | None
    has_object: bool
    rigid_wrist: bool
    wrist_position: tuple[float, ...]
    wrist_rpy: tuple[float, ...]

    def inclined(self, inclination: float | None) -> SceneDescription:
        """The scene with its wall at another inclination [deg]; None: the scene itself. Raises
        ValueError without a wall, or for an inclination outside of MIN_INCLINATION to
        MAX_INCLINATION.
        """
        if inclination is None:
            return self
        if self.wall is None:
            raise ValueError(f"wall_inclination: expected a scene with a wall, got {self.name}")
        if not MIN_INCLINATION <= inclination <= MAX_INCLINATION:
            raise ValueError(
                f"wall_inclination: expected {MIN_INCLINATION:g} to {MAX_INCLINATION:g} deg, "
                f"got {inclination:g}"
            )
        return replace(self, wall=replace(self.wall, inclination=inclination))


def load_scenes() -> dict[str, SceneDescription]:
    """The shipped scenes by name."""
    path = Path(str(resources.files("pneuflex_sim").joinpath("data/scenes.yaml")))
    entries = read_document(path, SCENES_FORMAT).fields(["format", "scenes"])["scenes"].mapping()
    return {name: _parse(name, entry) for name, entry in entries.items()}


def load_scene(name: str | Path, friction: FrictionTable | None = None) -> SceneDescription:
    """The shipped scene of that name, or the one in a YAML file at that path. If a table of
    friction is given, the scene's materials must be in it; without one, as for drawing, any
    materials are accepted.

    Raises ValueError naming file, key, expected and got, or listing the available names.

    >>> load_scene("wall").wall.inclination
    90.0
    """
    scenes = load_scenes()
    if str(name) in scenes:
        return scenes[str(name)]
    path = Path(name)
    if is_document(path):
        document = read_document(path, SCENE_FORMAT)
        own = {key: value for key, value in document.value.items() if key != "format"}
        node = Node(document.file, "", own, document.source)
        found = _parse(path.stem, node)
        if friction is not None:
            for part in (node.mapping().get(key) for key in ("table", "wall")):
                if part is not None:
                    friction.check_material(part.mapping()["material"])
        return found
    raise ValueError(
        f"scene: expected one of {', '.join(scenes)}, or the path of a YAML file; "
        f"got {unknown(name, scenes)}"
    )


def _parse(name: str, entry: Node) -> SceneDescription:
    fields = entry.fields(["object", "wrist", "wrist_position", "wrist_rpy"], ["table", "wall"])
    return SceneDescription(
        name,
        _table(fields["table"]) if "table" in fields else None,
        _wall(fields["wall"]) if "wall" in fields else None,
        fields["object"].choice([True, False]),
        fields["wrist"].choice(["compliant", "rigid"]) == "rigid",
        fields["wrist_position"].vector(bounds=POSITION_BOUNDS),
        fields["wrist_rpy"].vector(bounds=plausible.ANGLE_RANGE),
    )


def _table(node: Node) -> Table:
    fields = node.fields(["material"], ["edge", "rolling_resistance"])
    edge = fields["edge"].within(POSITION_BOUNDS) if "edge" in fields else None
    return Table(fields["material"].text(), edge, _rolling_resistance(fields))


def _wall(node: Node) -> Wall:
    fields = node.fields(["material", "distance", "inclination"], ["rolling_resistance"])
    return Wall(
        fields["material"].text(),
        fields["distance"].within(POSITION_BOUNDS),
        fields["inclination"].number(MIN_INCLINATION, MAX_INCLINATION),
        _rolling_resistance(fields),
    )


def _rolling_resistance(fields: dict[str, Node]) -> float:
    if "rolling_resistance" not in fields:
        return USUAL_ROLLING
    return fields["rolling_resistance"].within(ROLLING_RESISTANCE)


def build_scene(
    scene: SceneDescription, friction: FrictionTable, object_material: str | None, client: int
) -> dict[int, str]:
    """Create the fixed bodies of a scene around an object of a material (None: no object);
    returns their names by PyBullet id.

    Raises ValueError for pairs of materials that the table of friction does not have.
    """
    names: dict[int, str] = {}
    if scene.table is not None:
        for mask, dynamics in _sides(scene.table, friction, object_material):
            names[_fixed(_table_shape(scene.table, client), mask, dynamics, client)] = "table"
    if scene.wall is not None:
        for mask, dynamics in _sides(scene.wall, friction, object_material):
            names[_wall_body(scene.wall, mask, dynamics, client)] = "wall"
    return names


def _sides(
    part: Table | Wall, friction: FrictionTable, object_material: str | None
) -> list[tuple[int, dict[str, float]]]:
    """Collision mask and coefficients of each body of a part: one for hand and object, or one for
    each.
    """
    hand = {"lateralFriction": friction.towards_hand(part.material), "rollingFriction": 0.0}
    if object_material is None:
        return [(-1, hand)]
    lateral = friction.towards_object(part.material, object_material)
    # the engine multiplies it with the object's coefficient of sliding friction
    rolling = part.rolling_resistance / friction.towards_hand(object_material)
    if math.isclose(lateral, hand["lateralFriction"]) and not rolling:
        return [(-1, hand)]
    of_object = {"lateralFriction": lateral, "rollingFriction": rolling}
    return [(HAND_GROUPS, hand), (ENVIRONMENT_GROUP, of_object)]


def _table_shape(table: Table, client: int) -> int:
    """A plane, or a box if the table has an edge. On a box, a lying cylinder without rolling
    resistance gains speed by itself.
    """
    if table.edge is None:
        return _plane_shape((0.0, 0.0, 1.0), client)
    length, width, height = TABLE_SIZE
    return pybullet.createCollisionShape(
        pybullet.GEOM_BOX,
        halfExtents=(length / 2, width / 2, height / 2),
        collisionFramePosition=(table.edge + length / 2, 0.0, -height / 2),
        physicsClientId=client,
    )


def _plane_shape(normal: tuple[float, float, float], client: int) -> int:
    return pybullet.createCollisionShape(
        pybullet.GEOM_PLANE, planeNormal=normal, physicsClientId=client
    )


def _wall_body(wall: Wall, mask: int, dynamics: dict[str, float], client: int) -> int:
    return _fixed(_plane_shape(wall.normal, client), mask, dynamics, client, (wall.distance, 0, 0))


def _fixed(
    shape: int,
    mask: int,
    dynamics: dict[str, float],
    client: int,
    position: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> int:
    body = pybullet.createMultiBody(0, shape, -1, position, physicsClientId=client)
    pybullet.changeDynamics(body, -1, **dynamics, physicsClientId=client)
    pybullet.setCollisionFilterGroupMask(body, -1, ENVIRONMENT_GROUP, mask, physicsClientId=client)
    return int(body)
