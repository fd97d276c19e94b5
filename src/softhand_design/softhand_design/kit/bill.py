"""The bill of materials of a hand: rubber, plastic, thread, mesh, tube and tape of its parts."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from io import StringIO

import numpy as np

from softhand_design.kit.kit import Kit
from softhand_design.kit.part import SILICONE
from softhand_design.kit.scaffold import base_section
from softhand_design.mould.parameters import MouldParameters
from softhand_design.mould.parts import groove_places, kind_name
from softhand_design.mould.plan import MILLI, Line
from softhand_model.hand.actuator import Actuator

HELICES = 2  # "the double helix" (3.2.2)


@dataclass(frozen=True)
class Item:
    """A line of the bill of materials.

    volume_cm3, mass_g, length_m, area_cm2: of one piece; None for what does not apply, such as the
    area of a thread. in_hand: whether the part stays in the hand; trays do not.
    """

    part: str
    file: str
    count: int
    material: str
    volume_cm3: float | None = None
    mass_g: float | None = None
    length_m: float | None = None
    area_cm2: float | None = None
    in_hand: bool = True


def thread_length(actuator: Actuator, layer: float) -> float:
    """Length [m] of both helices around an actuator with a passive layer [mm] whose threads lie in
    every groove of its mould: each the integral of sqrt(1 + (around/pitch)**2) along the grooves,
    around the rectangle of height and width.
    """
    line, used = Line(actuator), MouldParameters()
    places = groove_places(line, used)
    s = np.linspace(places[0], places[-1], 200)
    around = 2.0 * (line.height(s) + layer + line.width(s))
    turn = np.hypot(1.0, around / used.groove_pitch)
    return HELICES * MILLI * float(np.trapezoid(turn, s))


def bill_of(kit: Kit) -> list[Item]:
    """All lines of a hand's bill."""
    return [*_parts(kit), *_threads(kit), *_tapes(kit), *_tools(kit)]


def _parts(kit: Kit) -> Iterator[Item]:
    for part in kit.in_hand:
        volume = part.read.volume() / 1e3
        mass = volume * part.density / 1e3
        file = f"{part.name}.stl"
        yield Item(part.name, file, len(part.copies), part.material, volume, mass)
        if part.name in kit.mesh_areas:
            area = kit.mesh_areas[part.name] / 100.0
            file = f"{part.name}_mesh.svg"
            yield Item(f"mesh of {part.name}", file, len(part.copies), "PET screen", area_cm2=area)


def _kinds(kit: Kit) -> dict[str, tuple[Actuator, int]]:
    """Kinds of actuator by name, and how many of each."""
    found: dict[str, tuple[Actuator, int]] = {}
    for chain in kit.hand.chains:
        for actuator in chain.actuators.values():
            kind = kind_name(actuator, chain.turn)
            found[kind] = actuator, found.get(kind, (actuator, 0))[1] + 1
    return found


def _threads(kit: Kit) -> Iterator[Item]:
    bore = np.pi / 4.0 * (kit.used.tube_bore * MILLI) ** 2
    for kind, (actuator, count) in _kinds(kit).items():
        length = thread_length(actuator, kit.used.layer)
        yield Item(f"helices of {kind}", "", count, "PET thread", length_m=length)
        if actuator.supply_volume:
            length = actuator.supply_volume / bore
            kept = f"silicone tube, {kit.used.tube_bore:g} mm bore"
            yield Item(f"tube of {kind}", "", count, kept, length_m=length)


def _tapes(kit: Kit) -> Iterator[Item]:
    for chain in kit.hand.chains:
        low, high = base_section(chain, 0.0)
        area = float(np.prod(high - low)) / 100.0
        yield Item(f"tape at the base of {chain.name}", "", 1, "loop tape", area_cm2=area)


def _tools(kit: Kit) -> Iterator[Item]:
    for part in kit.trays.values():
        volume = part.read.volume() / 1e3
        mass, file = volume * part.density / 1e3, f"{part.name}.stl"
        yield Item(part.name, file, 1, part.material, volume, mass, in_hand=False)
    for kind in _kinds(kit):
        yield Item(f"mould of {kind}", "", 1, "softhand hand mould", in_hand=False)


def bill_csv(items: list[Item]) -> str:
    """The bill as CSV, a column for each field of `Item`."""
    out = StringIO()
    writer = csv.DictWriter(out, [entry.name for entry in fields(Item)], lineterminator="\n")
    writer.writeheader()
    for item in items:
        row = asdict(item)
        writer.writerow(
            {
                key: f"{value:.4g}" if isinstance(value, float) else value
                for key, value in row.items()
            }
        )
    return out.getvalue()


def bill_text(kit: Kit, items: list[Item]) -> str:
    """The bill for the terminal, with sums of what is cast and printed in the hand."""
    head = ("part", "count", "cm3", "g", "m", "cm2", "material")
    rows = [_row(*head)]
    for item in items:
        sizes = (item.volume_cm3, item.mass_g, item.length_m, item.area_cm2)
        shown = ["" if value is None else f"{value:.3g}" for value in sizes]
        name = item.part if item.in_hand else f"({item.part})"
        rows.append(_row(name, str(item.count), *shown, item.material))
    cast = [item for item in items if item.material == SILICONE]
    rubber = sum(item.count * (item.volume_cm3 or 0.0) for item in cast)
    mass = sum(item.count * (item.mass_g or 0.0) for item in items if item.in_hand)
    rows += [
        f"rubber in the hand: {rubber:.1f} cm3; cast and printed parts: {mass:.1f} g, of "
        f"{kit.hand.mass * 1e3:g} g that the hand's file states",
        "each: volume, mass, length, area are of one; in brackets: tools; masses without thread, "
        "mesh, tape, tube and adhesive",
    ]
    return "\n".join(rows)


def _row(*words: str) -> str:
    name, count, volume, mass, length, area, material = words
    return f"{name:<42}{count:>5}{volume:>8}{mass:>8}{length:>7}{area:>7}  {material}".rstrip()
