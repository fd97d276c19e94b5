"""Checks whether the parts of a hand can be printed, cast and assembled, measured on their
files."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from softhand_design.kit.frames import mount_poses
from softhand_design.kit.kit import Kit
from softhand_design.kit.part import Part
from softhand_design.kit.solids import Solid, overlap
from softhand_design.mould.checks import OVERLAP, Check
from softhand_design.mould.measure import OUTSIDE, hits_of
from softhand_design.mould.plan import MILLI, Array

BY_RAYS, BY_FORMULA = 2.0, 0.5  # how far a volume may be off [%]
LENGTH_OFF = 0.05  # of a measured length [mm]
GAP_SEARCH = 5.0  # gaps are searched up to here [mm]
TOUCHING_GAP = 0.03  # what is nearer touches [mm]
LEAST_SPARED = 0.9  # of the adhesive's space is there at least [-]
ABOVE_FLOOR = 0.2  # where the walls of a tray are measured [mm]


def check_kit(kit: Kit) -> list[Check]:
    """All checks of a kit."""
    found: list[Check] = []
    for part in [*kit.in_hand, *kit.trays.values()]:
        found += _solid(part)
    return [*found, *_trays(kit), *_fits(kit), *_assembled(kit)]


def _solid(part: Part) -> Iterator[Check]:
    mesh = part.mesh
    closed = mesh.is_watertight and mesh.is_winding_consistent
    yield Check(f"{part.name}: closed and oriented", float(closed), "", 1.0)
    yield Check(f"{part.name}: bodies", float(mesh.body_count), "", 1.0, 1.0)
    yield Check(f"{part.name}: volume", float(mesh.volume) / 1e3, "cm3", 1e-3)
    off = 100.0 * (part.volume_by_rays / float(mesh.volume) - 1.0)
    yield Check(f"{part.name}: volume by rays, off by", off, "%", -BY_RAYS, BY_RAYS)
    if part.formula is not None:
        off = 100.0 * (float(mesh.volume) / part.formula - 1.0)
        yield Check(f"{part.name}: off the formula", off, "%", -BY_FORMULA, BY_FORMULA)


def _trays(kit: Kit) -> Iterator[Check]:
    """The layer, laid on the floor of its tray: its thickness is the recess's depth, and around it
    there is the margin.
    """
    for part in kit.layers:
        found = kit.trays[part.name].read
        laid = part.read.translate((0.0, 0.0, kit.used.tray + kit.used.layer))
        depth = found.bounding_box()[5] - laid.bounding_box()[2]
        yield _length(f"{part.name}: depth of its tray", depth, kit.used.layer)
        walls = found.trim_by_plane((0.0, 0.0, 1.0), kit.used.tray + ABOVE_FLOOR)
        gap = float(walls.min_gap(laid, GAP_SEARCH))
        yield _length(f"{part.name}: space in its tray", gap, kit.used.margin)


def _length(name: str, value: float, wanted: float) -> Check:
    return Check(name, value, "mm", wanted - LENGTH_OFF, wanted + LENGTH_OFF)


def _fits(kit: Kit) -> Iterator[Check]:
    frames, solid = mount_poses(kit.hand), kit.structure[0].read
    struts = [(chain.name, chain.strut) for chain in kit.hand.chains if chain.strut]
    for name, strut in struts:
        free = kit.scaffold.free_lengths[name]
        start = frames[name] @ [OUTSIDE, 0.0, free / 2.0, 1.0]
        stop = frames[name] @ [-OUTSIDE, 0.0, free / 2.0, 1.0]
        x = OUTSIDE - hits_of(solid, start, stop).reshape(-1, 2)
        near = x[np.abs(x.mean(axis=1) + kit.scaffold.struts_moved).argmin()]
        thick = float(near[0] - near[1])
        yield _length(f"strut of {name}: thickness", thick, strut.thickness / MILLI)
    placed = {name: room for part in kit.casts for name, room in part.room().items()}
    for part in kit.structure[1:]:
        chain = kit.hand.chain(next(iter(part.copies)).removeprefix("saddle of "))
        held = kit.hand.chain(chain.mount.parent).actuators
        gap = min(part.read.min_gap(placed[name], GAP_SEARCH) for name in held)
        least = LEAST_SPARED * kit.used.glue
        yield Check(f"{part.name}: space for adhesive", gap, "mm", least, GAP_SEARCH - TOUCHING_GAP)


def _assembled(kit: Kit) -> Iterator[Check]:
    rooms = {name: room for part in kit.in_hand for name, room in part.room().items()}
    shared = {(a, b): overlap(rooms[a], rooms[b]) for a, b in combinations(rooms, 2)}
    (a, b), most = max(shared.items(), key=lambda item: item[1], default=(("", ""), 0.0))
    where = f" ({a}, {b})" if most > OVERLAP else ""
    yield Check(f"assembled: largest overlap of two parts{where}", most, "mm3", None, OVERLAP)
    gaps = gaps_between(rooms)
    touching = {name for pair, gap in gaps.items() if gap < TOUCHING_GAP for name in pair}
    loose = len(set(rooms) - touching) if len(rooms) > 1 else 0
    yield Check("assembled: parts that touch no other", float(loose), "", 0.0, 0.0)
    apart = min((gap for gap in gaps.values() if gap >= TOUCHING_GAP), default=GAP_SEARCH)
    yield Check("assembled: least gap where parts do not touch", apart, "mm")


def gaps_between(rooms: dict[str, Solid]) -> dict[tuple[str, str], float]:
    """Gaps [mm] below 5 mm between solids, by their names."""
    found = {}
    for a, b in combinations(rooms, 2):
        low, high = _boxes(rooms[a], rooms[b])
        if (low < high + GAP_SEARCH).all():
            gap = float(rooms[a].min_gap(rooms[b], GAP_SEARCH))
            if gap < GAP_SEARCH:
                found[a, b] = gap
    return found


def _boxes(one: Solid, other: Solid) -> tuple[Array, Array]:
    first, second = (np.reshape(solid.bounding_box(), (2, 3)) for solid in (one, other))
    return np.maximum(first[0], second[0]), np.minimum(first[1], second[1])
