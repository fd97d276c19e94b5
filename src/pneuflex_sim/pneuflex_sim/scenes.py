"""Scenes: what stands around the hand, and whether the wrist yields; from data/scenes.yaml."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources

import pybullet
import yaml

from pneuflex_sim.collision_groups import ENVIRONMENT


@dataclass(frozen=True)
class SceneDescription:
    """A scene: friction of the table (None without one), whether it has an object, the wrist's
    pose at the start [m, rad] and whether it is rigid.
    """

    name: str
    table_friction: float | None
    has_object: bool
    rigid_wrist: bool
    wrist_position: tuple[float, float, float]
    wrist_rpy: tuple[float, float, float]


def load_scenes() -> dict[str, SceneDescription]:
    """All scenes by name."""
    text = resources.files("pneuflex_sim").joinpath("data/scenes.yaml").read_text()
    return {
        name: SceneDescription(
            name,
            entry["table"],
            entry["object"],
            entry["wrist"] == "rigid",
            tuple(entry["wrist_position"]),
            tuple(entry["wrist_rpy"]),
        )
        for name, entry in yaml.safe_load(text).items()
    }


def load_scene(name: str) -> SceneDescription:
    """Return a scene; raises ValueError that lists the names there are."""
    scenes = load_scenes()
    if name not in scenes:
        raise ValueError(f"scene: expected one of {', '.join(scenes)}; got {name!r}")
    return scenes[name]


def build_scene(scene: SceneDescription, client: int) -> dict[int, str]:
    """Create the fixed bodies of a scene; returns their names by PyBullet id.

    The table is a plane: on a box, a lying cylinder gains speed by itself.
    """
    if scene.table_friction is None:
        return {}
    shape = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client)
    table = pybullet.createMultiBody(0, shape, -1, physicsClientId=client)
    pybullet.changeDynamics(table, -1, lateralFriction=scene.table_friction, physicsClientId=client)
    pybullet.setCollisionFilterGroupMask(table, -1, ENVIRONMENT, -1, physicsClientId=client)
    return {table: "table"}
