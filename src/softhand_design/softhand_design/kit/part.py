"""A part as its file has it, and where its copies lie in the hand."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import trimesh

from softhand_design.kit.solids import Solid, grown
from softhand_design.mould.measure import OUTSIDE, read_stl, stl_of
from softhand_design.mould.plan import Array
from softhand_design.mould.surface import solid_of

SILICONE, POLYAMIDE = "silicone", "polyamide"
RAYS_ACROSS = 40  # and as many along, through each part


@dataclass(frozen=True)
class Part:
    """A part to print or to cast.

    name: of its file. density [kg/m3]. solid [mm]. copies: poses (3, 4) [mm] in the frame of the
    wrist, by the names of the copies; empty for a tray, which is not in the hand. formula: volume
    [mm3] by a formula, None if there is none. filled: solid of an actuator with its chamber filled;
    None for other parts.
    """

    name: str
    material: str
    density: float
    solid: Solid
    copies: dict[str, Array] = field(default_factory=dict)
    formula: float | None = None
    filled: Solid | None = None

    @cached_property
    def file(self) -> bytes:
        """Its STL file [mm]."""
        return stl_of(self.solid)

    @cached_property
    def mesh(self) -> trimesh.Trimesh:
        """The mesh [mm] in its file."""
        return read_stl(self.file)

    @cached_property
    def read(self) -> Solid:
        """The solid as read from its file."""
        return solid_of(self.mesh.vertices, self.mesh.faces)

    @cached_property
    def volume_by_rays(self) -> float:
        """Volume [mm3] of the solid in the part's file, measured with rays."""
        return volume_by_rays(self.read)

    def placed(self) -> dict[str, Solid]:
        """Its copies in the wrist frame, by their names, as read from the file."""
        return {name: self.read.transform(pose) for name, pose in self.copies.items()}

    def room(self, gap: float = 0.0) -> dict[str, Solid]:
        """The space of its copies in the wrist frame, chambers filled, with a gap [mm] around
        them."""
        solid = self.read if self.filled is None else self.filled
        wide = grown(solid, gap) if gap else solid
        return {name: wide.transform(pose) for name, pose in self.copies.items()}


def volume_by_rays(solid: Solid, across: int = RAYS_ACROSS, seed: int = 0) -> float:
    """Volume [mm3] from the lengths inside of rays along z, one at random in each cell of a grid
    across * across over the solid's box.
    """
    low, high = np.reshape(solid.bounding_box(), (2, 3))
    size = (high - low)[:2] / across
    cells = np.moveaxis(np.indices((across, across)), 0, 2)
    places = low[:2] + (cells + np.random.default_rng(seed).uniform(size=cells.shape)) * size
    inside = 0.0
    for x, y in places.reshape(-1, 2).tolist():
        hits = [hit.distance for hit in solid.ray_cast((x, y, -OUTSIDE), (x, y, OUTSIDE))]
        inside += sum(hits[1::2]) - sum(hits[: 2 * (len(hits) // 2) : 2])
    return 2.0 * OUTSIDE * inside * float(np.prod(size))
