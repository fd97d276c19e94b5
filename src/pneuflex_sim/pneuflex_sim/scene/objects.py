"""Objects to grasp as data: the shipped ones of data/objects.yaml, YAML and mesh files by path."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from pneuflex_sim.scene.friction import FrictionTable
from pneuflex_sim.scene.mesh import MESH_SUFFIXES
from pneuflex_sim.scene.object_shapes import Geometry, geometry
from softhand_common.documents.quoted import unknown
from softhand_common.documents.yaml_document import (
    Bounds,
    DocumentError,
    Node,
    is_document,
    read_document,
)
from softhand_common.numerics.arrays import Array
from softhand_model.chain.hulls import COLLISION_MARGIN
from softhand_model.hand import plausible

OBJECT_FORMAT, OBJECTS_FORMAT = "pneuflex-object/1", "pneuflex-objects/1"
MESH_DENSITY, MESH_MATERIAL = 500.0, "polyolefin"  # [kg/m3], of a mesh file without YAML
DECOMPOSITIONS = ("decomposed", "hull")
OBJECT_SIZE = Bounds(1e-5, 10.0, "m")
OBJECT_MASS = Bounds(1e-6, 1e3, "kg")
CONTACT_STIFFNESS, CONTACT_DAMPING = Bounds(0.1, 1e9, "N/m"), Bounds(0.0, 1e6, "N s/m")
HINGE_FRICTION = Bounds(1e-12, 10.0, "N m")
MESH_SCALE = Bounds(1e-6, 1e6, "")
MAX_STRIPS = 99

REQUIRED_DIMENSIONS = {
    "cylinder": ("diameter", "length"),
    "box": ("size",),
    "sphere": ("diameter",),
    "boxes": ("boxes",),
    "ellipsoid": ("size",),
    "cup": ("diameter", "base_diameter", "length", "wall"),
    "sheet": ("size", "strips", "contact_thickness", "hinge_friction"),
    "mesh": ("file",),
}
OPTIONAL_DIMENSIONS = {"ellipsoid": ("neck",), "mesh": ("scale", "pieces")}


@dataclass(frozen=True)
class Compliance:
    """Stiffness [N/m] and damping [N s/m] of each contact point of a compliant surface."""

    stiffness: float
    damping: float


@dataclass(frozen=True)
class ObjectDescription:
    """An object to grasp.

    Attributes:
        name, shape: see `SHAPE_GEOMETRIES` for the shapes.
        dimensions: lengths of the shape [m], by name. A cylinder's may give the number of collision
            `parts` (2).
        mass: mass [kg].
        material: name of its material in the table of friction.
        rpy: orientation of the object at rest in the scene [rad].
        compliance: compliance of its surface, None for a rigid surface.
        note: what the model leaves out.
    """

    name: str
    shape: str
    dimensions: Mapping[str, Any]
    mass: float
    material: str
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)
    compliance: Compliance | None = None
    note: str = ""

    @cached_property
    def geometry(self) -> Geometry:
        """Collision shapes and mass properties; raises ValueError for a mesh that cannot be
        used.
        """
        return geometry(self.shape, self.dimensions)

    @property
    def half_extents(self) -> tuple[float, float, float]:
        """Half the bounding box of a box, cylinder, sphere or sheet along its own axes [m]."""
        if self.shape in ("box", "sheet"):
            x, y, z = self.dimensions["size"]
            thick = self.dimensions.get("contact_thickness", z)
            return x / 2, y / 2, max(thick, z) / 2
        radius = self.dimensions["diameter"] / 2
        return radius, radius, self.dimensions.get("length", 2 * radius) / 2

    @property
    def half_sizes(self) -> Array:
        """Half the sides (3,) [m] of the box around the object along its own axes.

        >>> load_objects()["cylinder"].half_sizes.tolist()
        [0.0325, 0.0325, 0.0875]
        """
        if self.geometry.pieces:
            corners = np.concatenate(self.geometry.pieces)
            return np.asarray(0.5 * np.ptp(corners, axis=0))
        return np.array(self.half_extents)

    @property
    def rest_height(self) -> float:
        """Height of the origin of the object's axes above the surface on which it lies [m]."""
        return self.reach((0.0, 0.0, -1.0)) + (COLLISION_MARGIN if self.geometry.pieces else 0.0)

    def reach(self, direction: tuple[float, float, float]) -> float:
        """How far the object reaches from the origin of its axes in a direction (a unit vector in
        the world) as it lies in the scene [m].

        >>> ball = load_objects()["ball"]
        >>> ball.reach((1.0, 0.0, 0.0))
        0.0325
        """
        along = Rotation.from_euler("xyz", self.rpy).inv().apply(direction)
        if self.geometry.pieces:
            return max(float((piece @ along).max()) for piece in self.geometry.pieces)
        if self.shape == "sphere":
            return self.half_extents[0]
        if self.shape == "cylinder":
            across = np.sqrt(max(0.0, 1 - along[2] ** 2))
            return float(self.half_extents[2] * abs(along[2]) + self.half_extents[0] * across)
        return float(np.abs(along) @ self.half_extents)

    @property
    def corner_place(self) -> tuple[float, float]:
        """Where the origin of its axes is (x, y) [m] when the object touches the planes x = 0 and
        y = 0 from x > 0 and y < 0 (thesis, section 8.1.2).
        """
        return self.reach((-1.0, 0.0, 0.0)), -self.reach((0.0, 1.0, 0.0))


def load_objects() -> dict[str, ObjectDescription]:
    """The shipped objects by name."""
    return dict(_shipped())


@cache
def _shipped() -> dict[str, ObjectDescription]:
    """The shipped objects, read once."""
    path = Path(str(resources.files("pneuflex_sim").joinpath("data/objects.yaml")))
    entries = read_document(path, OBJECTS_FORMAT).fields(["format", "objects"])["objects"].mapping()
    return {name: _parse(name, entry, entry.mapping()) for name, entry in entries.items()}


def load_object(name: str | Path, friction: FrictionTable | None = None) -> ObjectDescription:
    """The shipped object of that name, or the one in a YAML or mesh file at that path. If a table
    of friction is given, the object's material must be in it; without one, as for drawing, any
    material is accepted.

    Raises ValueError naming file, key, expected and got, or listing the available names.

    >>> load_object("tube").mass
    0.114
    """
    objects = load_objects()
    if str(name) in objects:
        return objects[str(name)]
    path = Path(name)
    if path.suffix.lower() in MESH_SUFFIXES and os.path.isfile(path):
        return _of_mesh_file(path)
    if is_document(path):
        document = read_document(path, OBJECT_FORMAT)
        fields = document.mapping()
        fields.pop("format")
        own = fields.pop("name").text() if "name" in fields else path.stem
        if friction is not None and "material" in fields:
            friction.check_material(fields["material"])
        return _checked(_parse(own, document, fields), document)
    raise ValueError(
        f"object: expected one of {', '.join(objects)}, or the path of a file .yaml, "
        f"{', '.join(MESH_SUFFIXES)}; got {unknown(name, objects)}"
    )


def _of_mesh_file(path: Path) -> ObjectDescription:
    """A mesh in metres with a default density and material; a YAML file can state its own."""
    dimensions = {"file": str(path)}
    volume = geometry("mesh", dimensions).solid.volume
    return ObjectDescription(path.stem, "mesh", dimensions, MESH_DENSITY * volume, MESH_MATERIAL)


def _checked(description: ObjectDescription, document: Node) -> ObjectDescription:
    """The description once its geometry has been made: a mesh must be usable."""
    key = "file" if description.shape == "mesh" else "shape"
    try:
        _ = description.geometry
    except ValueError as reason:
        raise DocumentError(f"{document.mapping()[key].place}: {reason}") from reason
    return description


def _parse(name: str, entry: Node, children: dict[str, Node]) -> ObjectDescription:
    """An object of the keys in `children`; `entry` is where they stand."""
    if "shape" not in children:
        raise entry.error(f"the key `shape` with one of {', '.join(REQUIRED_DIMENSIONS)}")
    shape = children["shape"].choice(REQUIRED_DIMENSIONS)
    sizes, more = REQUIRED_DIMENSIONS[shape], OPTIONAL_DIMENSIONS.get(shape, ())
    keys = {key: child.value for key, child in children.items()}
    fields = Node(entry.file, entry.key, keys, entry.source).fields(
        ["shape", *sizes, "mass", "material"], [*more, "rpy", "compliance", "note"]
    )
    if shape == "sheet" and "compliance" in fields:
        raise fields["compliance"].error("no key `compliance` for a sheet")
    return ObjectDescription(
        name,
        shape,
        {key: READERS[key](fields[key]) for key in (*sizes, *more) if key in fields},
        fields["mass"].within(OBJECT_MASS),
        fields["material"].text(),
        fields["rpy"].vector(bounds=plausible.ANGLE_RANGE) if "rpy" in fields else (0.0, 0.0, 0.0),
        _compliance(fields["compliance"]) if "compliance" in fields else None,
        fields["note"].text() if "note" in fields else "",
    )


def _compliance(node: Node) -> Compliance:
    fields = node.fields(["stiffness", "damping"])
    return Compliance(
        fields["stiffness"].within(CONTACT_STIFFNESS), fields["damping"].within(CONTACT_DAMPING)
    )


def _length(node: Node) -> float:
    return node.within(OBJECT_SIZE)


def _size(node: Node) -> tuple[float, ...]:
    return node.vector(bounds=OBJECT_SIZE)


def _parts(node: Node) -> list[dict[str, tuple[float, ...]]]:
    if not node.items():
        raise node.error("at least one box")
    parts = [item.fields(["size", "position"]) for item in node.items()]
    return [
        {
            "size": _size(part["size"]),
            "position": part["position"].vector(bounds=plausible.POSITION_RANGE),
        }
        for part in parts
    ]


def _neck(node: Node) -> dict[str, float]:
    return {
        k: value.within(OBJECT_SIZE) for k, value in node.fields(["diameter", "length"]).items()
    }


def _odd(node: Node) -> int:
    if node.whole(3, MAX_STRIPS) % 2 == 0:
        raise node.error("an odd number")
    return node.value


def _file(node: Node) -> str:
    """Path of the mesh, from the folder of the file that names it."""
    return str(Path(node.file).parent / node.text())


READERS: dict[str, Callable[[Node], Any]] = {
    **dict.fromkeys(("diameter", "base_diameter", "length", "wall", "contact_thickness"), _length),
    "hinge_friction": lambda node: node.within(HINGE_FRICTION),
    "scale": lambda node: node.within(MESH_SCALE),
    "size": _size,
    "boxes": _parts,
    "neck": _neck,
    "strips": _odd,
    "file": _file,
    "pieces": lambda node: node.choice(DECOMPOSITIONS),
}
