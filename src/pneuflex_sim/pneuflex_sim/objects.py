"""Objects to grasp: rigid boxes, cylinders and spheres, from data/objects.yaml."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources

import numpy as np
import pybullet
import yaml
from scipy.spatial.transform import Rotation

SHAPES = {"cylinder": ("diameter", "length"), "box": ("size",), "sphere": ("diameter",)}


@dataclass(frozen=True)
class ObjectDescription:
    """A rigid object: shape, dimensions [m], mass [kg], friction coefficient, height of its centre
    at rest [m], pose.
    """

    name: str
    shape: str
    dimensions: dict[str, float | list[float]]
    mass: float
    friction: float
    rpy: tuple[float, float, float]

    @property
    def half_extents(self) -> tuple[float, float, float]:
        """Half the bounding box along the object's own axes [m]."""
        if self.shape == "box":
            x, y, z = self.dimensions["size"]  # type: ignore[misc]
            return x / 2, y / 2, z / 2
        radius = float(self.dimensions["diameter"]) / 2  # type: ignore[arg-type]
        return (
            radius,
            radius,
            float(self.dimensions["length"]) / 2 if self.shape == "cylinder" else radius,
        )  # type: ignore[arg-type]

    @property
    def rest_height(self) -> float:
        """Height of the centre above the surface that the object lies on [m]."""
        turned = Rotation.from_euler("xyz", self.rpy).as_matrix()[2]
        if self.shape == "sphere":
            return self.half_extents[0]
        if self.shape == "cylinder":
            along = abs(turned[2])
            return float(
                self.half_extents[2] * along
                + self.half_extents[0] * np.sqrt(max(0.0, 1 - along**2))
            )
        return float(np.abs(turned) @ self.half_extents)


def load_objects() -> dict[str, ObjectDescription]:
    """Read data/objects.yaml; raises ValueError naming the object, the key, what was expected and
    what came.
    """
    text = resources.files("pneuflex_sim").joinpath("data/objects.yaml").read_text()
    return {name: _parse(name, entry) for name, entry in yaml.safe_load(text).items()}


def load_object(name: str) -> ObjectDescription:
    """Return one object; raises ValueError that lists the names there are."""
    objects = load_objects()
    if name not in objects:
        raise ValueError(f"object: expected one of {', '.join(objects)}; got {name!r}")
    return objects[name]


def _parse(name: str, entry: dict) -> ObjectDescription:
    shape = entry.get("shape")
    if shape not in SHAPES:
        raise ValueError(
            f"objects.yaml: {name}.shape: expected one of {', '.join(SHAPES)}, got {shape!r}"
        )
    expected = {"shape", "mass", "friction", "rpy", *SHAPES[shape]}
    if set(entry) != expected:
        raise ValueError(
            f"objects.yaml: {name}: expected the keys {sorted(expected)}, got {sorted(entry)}"
        )
    return ObjectDescription(
        name,
        shape,
        {key: entry[key] for key in SHAPES[shape]},
        float(entry["mass"]),
        float(entry["friction"]),
        tuple(entry["rpy"]),
    )


def collision_shape(description: ObjectDescription, client: int) -> int:
    """Create the PyBullet collision shape of an object."""
    half = description.half_extents
    if description.shape == "box":
        return pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=half, physicsClientId=client
        )
    if description.shape == "sphere":
        return pybullet.createCollisionShape(
            pybullet.GEOM_SPHERE, radius=half[0], physicsClientId=client
        )
    return pybullet.createCollisionShape(
        pybullet.GEOM_CYLINDER, radius=half[0], height=2 * half[2], physicsClientId=client
    )
