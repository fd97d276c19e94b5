"""A part as its file has it, and where its copies lie in the hand."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from softhand_design.kit.solids import Solid, grown
from softhand_design.mould.measure import read_stl, stl_of
from softhand_design.mould.plan import Array
from softhand_design.mould.surface import solid_of

SILICONE, POLYAMIDE = "silicone", "polyamide"


@dataclass(frozen=True)
class Part:
    """A part: name of its file, material and density [kg/m3], its solid [mm], the poses (3, 4) [mm]
    in the wrist frame of its copies by their names, and the volume [mm3] that it has by a formula,
    if there is one; for an actuator also the solid with its chamber filled.

    A tray is in no hand: it has no copies.
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
    def read(self) -> Solid:
        """The solid as read from its file."""
        mesh = read_stl(self.file)
        return solid_of(mesh.vertices, mesh.faces)

    def placed(self) -> dict[str, Solid]:
        """Its copies in the wrist frame, by their names, as read from the file."""
        return {name: self.read.transform(pose) for name, pose in self.copies.items()}

    def room(self, gap: float = 0.0) -> dict[str, Solid]:
        """The room that its copies take in the wrist frame, chambers filled, with a gap [mm]."""
        solid = self.read if self.filled is None else self.filled
        wide = grown(solid, gap) if gap else solid
        return {name: wide.transform(pose) for name, pose in self.copies.items()}
