"""The fixed bodies of a scene in PyBullet: table and wall, with the friction of every pair.

What hand and object need of a surface may differ by more than the engine's product of two
coefficients can say; then the surface stands there twice, once for the hand and once for the
object, each with its own coefficient.
"""

from __future__ import annotations

import math

import pybullet

from pneuflex_sim.collision_groups import ENVIRONMENT
from pneuflex_sim.friction import FrictionTable
from pneuflex_sim.scenes import SceneDescription, Table, Wall

HAND = ~ENVIRONMENT  # all groups of the hand
TABLE_SIZE = (1.2, 1.2, 0.04)  # [m] of a table with an edge


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
    """Whom each body of a part touches (a mask of collision groups), and its coefficients."""
    hand = {"lateralFriction": friction.towards_hand(part.material), "rollingFriction": 0.0}
    if object_material is None:
        return [(-1, hand)]
    lateral = friction.towards_object(part.material, object_material)
    # the engine multiplies it with the object's coefficient of sliding friction
    rolling = part.rolling_resistance / friction.towards_hand(object_material)
    if math.isclose(lateral, hand["lateralFriction"]) and not rolling:
        return [(-1, hand)]
    of_object = {"lateralFriction": lateral, "rollingFriction": rolling}
    return [(HAND, hand), (ENVIRONMENT, of_object)]


def _table_shape(table: Table, client: int) -> int:
    """A plane, or a box with an edge, on which a lying cylinder gains speed by itself without
    rolling resistance.
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
    pybullet.setCollisionFilterGroupMask(body, -1, ENVIRONMENT, mask, physicsClientId=client)
    return int(body)
