"""The kit of a hand: its parts with their copies in the hand, trays, and cuts of mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softhand_design.kit.palm_sheet import bend, flat, volume
from softhand_design.kit.parameters import KitParameters
from softhand_design.kit.part import POLYAMIDE, SILICONE, Part
from softhand_design.kit.rubber import casts, layers
from softhand_design.kit.saddle import build_saddles
from softhand_design.kit.scaffold import Scaffold, build_scaffold, plate_of
from softhand_design.kit.trays import mesh_cut, tray
from softhand_design.mould.plan import MILLI
from softhand_model.hand.actuator import nominal_rubber
from softhand_model.hand.hand import WRIST, HandDescription, Strut

IN_PLACE = np.eye(3, 4)


@dataclass(frozen=True)
class Kit:
    """All parts of a hand, lengths in mm.

    casts: castings of the actuators. layers: passive layers. structure: scaffold and saddles.
    sheet: the palm's sheet, None without one. trays: by the names of the parts that are cast in
    them. cuts, mesh_areas: outlines of mesh as SVG, and their areas [mm2], by name. lift: how far
    the sheet was lifted from its place in the hand's file.
    """

    hand: HandDescription
    used: KitParameters
    casts: list[Part]
    layers: list[Part]
    structure: list[Part]
    sheet: Part | None
    trays: dict[str, Part]
    cuts: dict[str, str]
    mesh_areas: dict[str, float]
    scaffold: Scaffold
    lift: float

    @property
    def in_hand(self) -> list[Part]:
        """All parts that the hand consists of."""
        return [*self.casts, *self.layers, *self.structure, *([self.sheet] if self.sheet else [])]


def build_kit(hand: HandDescription, used: KitParameters | None = None) -> Kit:
    """The parts of a hand beside the moulds of its actuators.

    Raises ValueError, naming field, expected and got, for a hand whose parts find no room.
    """
    used = used or KitParameters()
    plate_of(hand)
    _refuse_continued(hand)
    rubber = casts(hand)
    flats = layers(hand, used)
    soft = [*rubber, *(part for part, _ in flats)]
    named = {name: room for part in soft for name, room in part.room().items()}
    rooms = list(named.values())
    clear = [room for part in soft for room in part.room(used.gap).values()]
    bent = bend(hand.sheet, rooms) if hand.sheet else None
    scaffold = build_scaffold(hand, rooms, clear, bent, used)
    plastic = next((chain.strut.density for chain in hand.chains if chain.strut), Strut.density)
    name = f"{hand.name}_scaffold"
    structure = [Part(name, POLYAMIDE, plastic, scaffold.solid, {"scaffold": IN_PLACE})]
    for chain, solid in build_saddles(hand, named, used).items():
        title = f"saddle of {chain}"
        structure.append(
            Part(f"{hand.name}_{chain}_saddle", POLYAMIDE, plastic, solid, {title: IN_PLACE})
        )
    shapes = {part.name: (shape, used.layer) for part, shape in flats}
    sheet = None
    if hand.sheet and bent:
        sheet = Part(
            f"{hand.name}_sheet",
            SILICONE,
            nominal_rubber()[1],
            bent.solid,
            {"sheet": IN_PLACE},
            volume(hand.sheet),
        )
        shapes[sheet.name] = flat(hand.sheet), hand.sheet.thickness / MILLI
    return Kit(
        hand,
        used,
        rubber,
        [part for part, _ in flats],
        structure,
        sheet,
        {
            key: Part(f"{key}_tray", POLYAMIDE, plastic, tray(shape, depth, used))
            for key, (shape, depth) in shapes.items()
        },
        {key: mesh_cut(shape) for key, (shape, _) in shapes.items()},
        {key: shape.area() for key, (shape, _) in shapes.items()},
        scaffold,
        bent.lift if bent else 0.0,
    )


def _refuse_continued(hand: HandDescription) -> None:
    """Refuse a chain that is the second half of one casting."""
    for chain in hand.chains:
        straight = not (chain.mount.parent == WRIST or hand.chain(chain.mount.parent).turn)
        if straight and not np.any([*chain.mount.position, *chain.mount.rpy]):
            raise ValueError(
                f"mount of {chain.name}: expected actuators that are whole castings, got one that "
                f"continues {chain.mount.parent}: describe both as one actuator in the hand's file"
            )
