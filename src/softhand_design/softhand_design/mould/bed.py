"""All parts of several moulds laid out on a printing bed.

Cores lie on their plates. Shells of straight actuators stand on their feet, where the nose over
the foot needs support; those of arcs lie on their backs, where the rim does. One mould is enough
for all actuators of a kind, as it can be reused.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import manifold3d
import numpy as np

from softhand_common.documents.output_file import write_file
from softhand_common.numerics.arrays import Array
from softhand_design.mould.measure import stl_of
from softhand_design.mould.report import PARTS, CheckedMould

SPACE = 4.0  # between parts [mm]
TURNS = (0.0, 90.0)


@dataclass(frozen=True)
class Bed:
    """Parts by name as they lie on a bed of size (2,) [mm], a corner of which is the origin."""

    size: tuple[float, float]
    parts: dict[str, manifold3d.Manifold]

    def text(self) -> str:
        """Text on where each part lies, and how much room is needed."""
        rows = [f"{'on the bed [mm]':<32}{'x':>16}{'y':>16}{'height':>9}"]
        high = np.zeros(3)
        for name, part in self.parts.items():
            x0, y0, _, x1, y1, z1 = part.bounding_box()
            high = np.maximum(high, (x1, y1, z1))
            places = (f"{x0:.0f} to {x1:.0f}", f"{y0:.0f} to {y1:.0f}")
            rows.append(f"{name:<32}{places[0]:>16}{places[1]:>16}{z1:>9.0f}")
        need = " x ".join(f"{value:.0f}" for value in high)
        return "\n".join([*rows, f"needs {need} of {self.size[0]:g} x {self.size[1]:g}"])


def lay_out(moulds: Sequence[CheckedMould], size: tuple[float, float]) -> Bed:
    """Place all parts in rows, the deepest first; raises ValueError for too small a bed."""
    upright = {f"{made.name}_{name}": _as_printed(made, name) for made in moulds for name in PARTS}
    turned = {name: _turned(part, size) for name, part in upright.items()}
    order = sorted(turned, key=lambda name: -_extent(turned[name])[1])
    left, low, depth = SPACE, SPACE, 0.0
    placed = {}
    for name in order:
        width, deep = _extent(turned[name])
        if left + width + SPACE > size[0]:
            left, low, depth = SPACE, low + depth + SPACE, 0.0
        placed[name] = turned[name].translate((left, low, 0.0))
        left, depth = left + width + SPACE, max(depth, deep)
        if low + depth + SPACE > size[1] or width + 2.0 * SPACE > size[0]:
            raise ValueError(
                f"bed: expected room for {len(order)} parts, got {size[0]:g} x {size[1]:g} mm, "
                f"where {name} is the first part without room"
            )
    return Bed(size, placed)


def _as_printed(made: CheckedMould, name: str) -> manifold3d.Manifold:
    part = made.part(name)
    if name == "shell":
        stands = made.mould.line.radius is None
        part = part.rotate((0.0, 90.0, 0.0) if stands else (180.0, 0.0, 0.0))
    return _grounded(part)


def _grounded(part: manifold3d.Manifold) -> manifold3d.Manifold:
    return part.translate(tuple(-low for low in part.bounding_box()[:3]))


def _turned(part: manifold3d.Manifold, size: tuple[float, float]) -> manifold3d.Manifold:
    """The part with its longer side along the bed's depth, if it fits there."""
    both = [_grounded(part.rotate((0.0, 0.0, angle))) for angle in TURNS]
    fitting = [turn for turn in both if _extent(turn)[1] + 2.0 * SPACE <= size[1]] or both
    return min(fitting, key=lambda turn: _extent(turn)[0])


def _extent(part: manifold3d.Manifold) -> Array:
    return np.array(part.bounding_box()[3:5])


def write_bed(bed: Bed, path: Path) -> None:
    """Write all parts into one STL file [mm]."""
    write_file(path, stl_of(manifold3d.Manifold.compose(list(bed.parts.values()))))
