"""Scenes: what stands around the hand, and whether the wrist yields."""

from __future__ import annotations

from dataclasses import dataclass

import pybullet

from pneuflex_sim.hand_bodies import ENVIRONMENT


@dataclass(frozen=True)
class SceneDescription:
    """A scene: boxes by name as (half extents, position) [m], object present, wrist rigid, wrist
    pose at the start.
    """

    name: str
    boxes: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]]
    has_object: bool
    rigid_wrist: bool
    wrist_position: tuple[float, float, float]
    wrist_rpy: tuple[float, float, float]


TABLE_FRICTION = 0.6

SCENES = {
    "table": SceneDescription(
        "table",
        {"table": ((0.6, 0.6, 0.05), (0.0, 0.0, -0.05))},
        True,
        False,
        (0.0, 0.0, 0.4),
        (0.0, 2.356194490192345, 0.0),
    ),
    "stand": SceneDescription("stand", {}, False, True, (0.0, 0.0, 0.3), (0.0, 0.0, 0.0)),
}


def load_scene(name: str) -> SceneDescription:
    """Return a scene; raises ValueError that lists the names there are."""
    if name not in SCENES:
        raise ValueError(f"scene: expected one of {', '.join(SCENES)}; got {name!r}")
    return SCENES[name]


def build_scene(scene: SceneDescription, client: int) -> dict[int, str]:
    """Create the fixed bodies of a scene; returns their names by PyBullet id."""
    names = {}
    for name, (half, position) in scene.boxes.items():
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=half, physicsClientId=client
        )
        body = pybullet.createMultiBody(0, shape, -1, position, physicsClientId=client)
        pybullet.changeDynamics(body, -1, lateralFriction=TABLE_FRICTION, physicsClientId=client)
        pybullet.setCollisionFilterGroupMask(body, -1, ENVIRONMENT, -1, physicsClientId=client)
        names[body] = name
    return names
