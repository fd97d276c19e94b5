"""Trays in which passive layers and the palm's sheet are cast flat, and the cut of their mesh."""

from __future__ import annotations

from xml.etree import ElementTree

import manifold3d
import numpy as np

from softhand_design.choke_foil import FOIL_LINE, SVG_SPACE
from softhand_design.kit.parameters import KitParameters

CORNER_PIECES = 32  # of a round corner
MESH_OVER = 1.0  # than the trimmed layer is the mesh, within the tray's margin [mm]


def tray(shape: manifold3d.CrossSection, depth: float, used: KitParameters) -> manifold3d.Manifold:
    """A tray [mm] whose recess is as deep as the sheet and a margin wider than its outline."""
    round_join = manifold3d.JoinType.Round
    room = shape.offset(used.margin, round_join, circular_segments=CORNER_PIECES)
    around = shape.offset(used.margin + used.tray, round_join, circular_segments=CORNER_PIECES)
    block = around.extrude(depth + used.tray)
    return block - room.extrude(depth + 1.0).translate((0.0, 0.0, used.tray))


def mesh_cut(shape: manifold3d.CrossSection) -> str:
    """The outline of the mesh as SVG in mm, larger than the layer all around."""
    cut = shape.offset(MESH_OVER, manifold3d.JoinType.Round, circular_segments=CORNER_PIECES)
    loops = [np.asarray(polygon, float) for polygon in cut.to_polygons()]
    low = np.min([loop.min(axis=0) for loop in loops], axis=0) - FOIL_LINE
    wide, tall = np.max([loop.max(axis=0) for loop in loops], axis=0) + FOIL_LINE - low
    head = {"viewBox": f"0 0 {wide:g} {tall:g}", "width": f"{wide:g}mm", "height": f"{tall:g}mm"}
    drawing = ElementTree.Element("svg", {"xmlns": SVG_SPACE, **head})
    way = " ".join(
        "M" + " L".join(f"{x:.3f},{tall - y:.3f}" for x, y in loop - low) + " Z" for loop in loops
    )
    look = {"fill": "none", "stroke": "red", "stroke-width": f"{FOIL_LINE}"}
    ElementTree.SubElement(drawing, "path", {"d": way, **look})
    ElementTree.indent(drawing)
    return ElementTree.tostring(drawing, encoding="unicode") + "\n"
