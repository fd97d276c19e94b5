"""Casts of a hand's actuators, as their moulds give them, and passive layers (3.2.2)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

import manifold3d
import numpy as np

from softhand_design.kit.frames import Array, after, cast_poses, mount_poses
from softhand_design.kit.parameters import KitParameters
from softhand_design.kit.part import SILICONE, Part
from softhand_design.mould.parts import build_cast, kind_name, sided
from softhand_design.mould.plan import MILLI, Line, outline
from softhand_model.chain.segments import lateral_places
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.hand import ChainDescription, HandDescription

LAYER = " layer"  # follows the name of what it lies under
SAME_PLACE = 0.01  # [mm] between the planes of layers that may be one sheet
BASE_OVERLAP = 30.0  # [mm] of an outline past its base, which is cut off


def density(actuator: Actuator) -> float:
    """Density [kg/m3] of its rubber."""
    return actuator.mass / actuator.rubber_volume()


def casts(hand: HandDescription) -> list[Part]:
    """The casts of all kinds of actuator, each with its copies in the hand.

    ERRATUM: section 7.3 says that a gap of 5 mm is between the arcs of the palm; by the radii and
    widths of Table 7.1 they touch along a line, and 20 mm wide arcs would have that gap.
    """
    frames = mount_poses(hand)
    copies: dict[str, dict[str, Array]] = {}
    kinds: dict[str, tuple[Actuator, int]] = {}
    for chain in hand.chains:
        for name, placed in cast_poses(chain).items():
            actuator = chain.actuators[name]
            kind = kind_name(actuator, chain.turn)
            kinds[kind] = actuator, chain.turn
            copies.setdefault(kind, {})[name] = after(frames[chain.name], placed)
    found = []
    for kind, (actuator, turn) in kinds.items():
        filled, cast = (sided(solid, turn) for solid in build_cast(actuator))
        found.append(
            Part(f"{kind}_cast", SILICONE, density(actuator), cast, copies[kind], None, filled)
        )
    return found


Flat: TypeAlias = manifold3d.CrossSection


def layers(hand: HandDescription, used: KitParameters) -> list[tuple[Part, Flat]]:
    """The passive layers with their outlines [mm]: one for each kind of actuator, one sheet for a
    pair, and one for all chains that a web joins.

    Raises ValueError for a web whose chains lie not in one plane.
    """
    found: dict[str, tuple[Part, Flat]] = {}
    for name, shape, copies, rubber in _shapes(hand, mount_poses(hand)):
        if name in found:
            found[name][0].copies.update(copies)
        else:
            solid = shape.extrude(used.layer).translate((0.0, 0.0, -used.layer))
            formula = _area(shape) * used.layer
            part = Part(f"{name}_layer", SILICONE, rubber, solid, copies, formula)
            found[name] = part, shape
    return list(found.values())


Shape = tuple[str, Flat, dict[str, Array], float]


def _shapes(hand: HandDescription, frames: dict[str, Array]) -> Iterator[Shape]:
    joined = [chain for chain in hand.chains if chain.web]
    if joined:
        yield _sheet(joined, frames)
    for chain in hand.chains:
        if chain.web:
            continue
        placed = cast_poses(chain)
        if chain.pitch:
            first = next(iter(placed.values())).copy()
            first[:, 3] -= [0.0, float(lateral_places(chain)[0]) / MILLI, 0.0]
            yield (
                chain.name,
                _pair(chain),
                {f"{chain.name}{LAYER}": after(frames[chain.name], first)},
                density(next(iter(chain.actuators.values()))),
            )
            continue
        for name, actuator in chain.actuators.items():
            flat = foot(actuator, chain.turn)
            copies = {f"{name}{LAYER}": after(frames[chain.name], placed[name])}
            yield kind_name(actuator, chain.turn), flat, copies, density(actuator)


def foot(actuator: Actuator, turn: int = 0) -> Flat:
    """Outline of an actuator in the plane of its passive layer [mm]."""
    line = Line(actuator)
    around = outline(line, line.half_width, -BASE_OVERLAP, line.length, np.zeros(0))
    low, high = around.points.min(axis=0), around.points.max(axis=0)
    kept = manifold3d.CrossSection.square(tuple(high - low)).translate((0.0, float(low[1])))
    flat = manifold3d.CrossSection([around.points[::-1]]) ^ kept
    return flat.mirror((0.0, 1.0)) if turn < 0 else flat


def _pair(chain: ChainDescription) -> Flat:
    """One sheet under a pair, or under a single actuator."""
    feet = [
        foot(actuator).translate((0.0, float(y) / MILLI))
        for actuator, y in zip(chain.actuators.values(), lateral_places(chain), strict=True)
    ]
    return manifold3d.CrossSection.batch_hull(feet) if len(feet) > 1 else feet[0]


def _sheet(chains: Sequence[ChainDescription], frames: dict[str, Array]) -> Shape:
    """The common sheet of chains that a web joins, in the plane of the first one."""
    first = frames[chains[0].name]
    pieces, sides = [], []
    for chain in chains:
        shift = first[:, :3].T @ (frames[chain.name][:, 3] - first[:, 3])
        parallel = np.allclose(frames[chain.name][:, :3], first[:, :3])
        beside = np.abs(shift[[0, 2]]).max() <= SAME_PLACE
        if not (parallel and beside) or chain.strut:
            got = "a strut" if chain.strut else "another place" if parallel else "another direction"
            raise ValueError(
                f"web of {chain.name}: expected parallel chains without struts, side by side in "
                f"one plane with {chains[0].name}, got {chain.name} with {got}"
            )
        pieces.append(_pair(chain).translate((0.0, float(shift[1]))))
        sides.append(float(shift[1]))
    reach = min(chain.web.length for chain in chains if chain.web) / MILLI
    web = manifold3d.CrossSection.square((reach, max(sides) - min(sides)))
    shape = manifold3d.CrossSection.batch_boolean(
        [*pieces, web.translate((0.0, min(sides)))], manifold3d.OpType.Add
    )
    name = "+".join(chain.name for chain in chains)
    base = next(iter(cast_poses(chains[0]).values())).copy()
    base[1, 3] = 0.0
    rubber = density(next(iter(chains[0].actuators.values())))
    return name, shape, {f"{name}{LAYER}": after(first, base)}, rubber


def _area(shape: manifold3d.CrossSection) -> float:
    """Area [mm2] of an outline by the shoelace formula."""
    total = 0.0
    for polygon in shape.to_polygons():
        x, y = np.asarray(polygon, float).T
        total += float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2.0
    return total
