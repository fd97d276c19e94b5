"""Choke foil of a box of valves (section 4.3, Fig. 4.5) as a drawing for a cutting plotter.

A foil of PET, 0.1 mm thick, lies between the valves and their socket; what flows through a port
passes the holes pierced there. The thesis states foil, holes and what they are for; the places of
the ports are only in its picture, so all lengths of the layout are ours.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from xml.etree import ElementTree

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_model.gas import orifice_flow
from softhand_model.pneumatics.parameters import Pneumatics

CUTTABLE_HOLE = 1.0  # diameter from which a plotter cuts a hole; below, a needle pierces it [mm]
HOLES_APART = 3.0  # least distance of two holes' centres over their diameter
CROSS_ARM = 0.5  # half the length of the cross at a pierced port [mm]
FOIL_TEXT_SIZE, FOIL_LINE = 2.5, 0.1  # [mm]
LITRE_MASS = 1.293e-3  # of a standard litre of air, 0 degC and 101.325 kPa [kg]
SVG_SPACE = "http://www.w3.org/2000/svg"
FOIL_LAYERS = {"cut": "red", "pierce": "blue", "marks": "gray"}


def _size(default: float, text: str) -> float:
    found: float = field(default=default, metadata={"text": text, "unit": "mm"})
    return found


@dataclass(frozen=True)
class FoilParameters:
    """Holes and layout of a foil; lengths in mm. Numbers and diameters of holes are those of the
    thesis.

    Raises ValueError, naming field, expected and got, for what cannot be pierced or cut.
    """

    channels: int = field(default=8, metadata={"text": "valves in a row", "unit": "-"})
    inlet_holes: int = field(default=1, metadata={"text": "in each supply port", "unit": "-"})
    inlet_diameter: float = _size(0.2, "of such a hole")
    outlet_holes: int = field(default=1, metadata={"text": "in each exhaust port", "unit": "-"})
    outlet_diameter: float = _size(0.6, "of such a hole")
    port: float = _size(5.0, "diameter of the ports under the foil")
    port_distance: float = _size(10.0, "of a supply port from its exhaust port")
    pitch: float = _size(10.5, "of the valves")
    margin: float = _size(6.0, "of foil around the ports")

    def __post_init__(self) -> None:
        for entry in fields(self):
            given = getattr(self, entry.name)
            if not (np.isfinite(given) and given > 0):
                raise ValueError(f"{entry.name}: expected a number above 0, got {given}")
        for name in ("pitch", "port_distance"):
            if getattr(self, name) <= self.port:
                expected = f"more than the port's diameter, {self.port:g} mm"
                raise ValueError(f"{name}: expected {expected}, got {getattr(self, name):g}")
        for side in ("inlet", "outlet"):
            self._check_holes(side)

    def _check_holes(self, side: str) -> None:
        count, diameter = getattr(self, f"{side}_holes"), getattr(self, f"{side}_diameter")
        if diameter >= self.port:
            expected = f"less than the port's diameter, {self.port:g} mm"
            raise ValueError(f"{side}_diameter: expected {expected}, got {diameter:g}")
        most = _most_holes(self.port, diameter)
        if count > most:
            raise ValueError(
                f"{side}_holes: expected at most {most} holes of {diameter:g} mm in a port of "
                f"{self.port:g} mm, got {count}"
            )


def _most_holes(port: float, diameter: float) -> int:
    """How many holes of a diameter [mm] have room on a ring half-way out in a port [mm]; at least
    one, in its middle.
    """
    ring = port / 4.0
    if diameter * HOLES_APART > 2.0 * ring or ring + diameter / 2.0 > port / 2.0:
        return 1
    return int(np.pi / np.arcsin(diameter * HOLES_APART / (2.0 * ring)) + 1e-9)


def hole_places(count: int, port: float) -> Array:
    """Centres (count, 2) [mm] of the holes in a port of a diameter [mm], from its middle: one hole
    lies in the middle, more lie on a ring half-way out.

    >>> hole_places(2, 4.0).round(3).tolist()
    [[1.0, 0.0], [-1.0, 0.0]]
    """
    if count == 1:
        return np.zeros((1, 2))
    angles = 2.0 * np.pi * np.arange(count) / count
    return port / 4.0 * np.column_stack([np.cos(angles), np.sin(angles)])


def nominal_flow(holes: int, diameter: float, box: Pneumatics) -> float:
    """Flow [standard litres per minute] of a number of holes of a diameter [mm] from the supply of
    a box to ambient, with the mean discharge coefficient of its pierced foil.
    """
    area = holes * np.pi / 4.0 * (1e-3 * diameter) ** 2
    area *= float(np.mean(box.choke.discharge_coefficient))
    supply = box.supply.pressure + box.ambient_pressure
    flow = float(orifice_flow(supply, box.ambient_pressure, area, box.temperature))
    return 60.0 * flow / LITRE_MASS


def foil_drawing(given: FoilParameters) -> str:
    """The foil as SVG in mm, with a layer to `cut` (outline, holes of 1 mm or more), one to
    `pierce` (smaller holes) and one of `marks` (ports, a cross where to pierce, numbers).
    """
    width = (given.channels - 1) * given.pitch + given.port + 2.0 * given.margin
    height = given.port_distance + given.port + 2.0 * given.margin
    box = {"viewBox": f"0 0 {width:g} {height:g}", "width": f"{width:g}mm"}
    drawing = ElementTree.Element("svg", {"xmlns": SVG_SPACE, **box, "height": f"{height:g}mm"})
    layers = {
        name: ElementTree.SubElement(
            drawing,
            "g",
            {"id": name, "fill": "none", "stroke": colour, "stroke-width": f"{FOIL_LINE}"},
        )
        for name, colour in FOIL_LAYERS.items()
    }
    outline = {"x": "0", "y": "0", "width": f"{width:g}", "height": f"{height:g}"}
    ElementTree.SubElement(layers["cut"], "rect", outline)
    first = given.margin + given.port / 2.0
    for number in range(given.channels):
        x = first + number * given.pitch
        for side, y in (("inlet", first), ("outlet", first + given.port_distance)):
            _add_port(layers, (x, y), given, side)
        _add_text(layers["marks"], (x, height - given.margin / 3.0), str(number + 1))
    ElementTree.indent(drawing)
    return ElementTree.tostring(drawing, encoding="unicode") + "\n"


def _add_port(
    layers: dict[str, ElementTree.Element],
    middle: tuple[float, float],
    given: FoilParameters,
    side: str,
) -> None:
    diameter, count = getattr(given, f"{side}_diameter"), getattr(given, f"{side}_holes")
    _add_circle(layers["marks"], middle, given.port, f"{side}-port")
    layer = "cut" if diameter >= CUTTABLE_HOLE else "pierce"
    for place in hole_places(count, given.port) + middle:
        _add_circle(layers[layer], (place[0], place[1]), diameter, side)
        if layer == "pierce":
            x, y = place - CROSS_ARM
            way = 2.0 * CROSS_ARM
            cross = f"M{x:g} {place[1]:g}h{way:g}M{place[0]:g} {y:g}v{way:g}"
            ElementTree.SubElement(layers["marks"], "path", {"d": cross})


def _add_circle(
    layer: ElementTree.Element, middle: tuple[float, float], diameter: float, name: str
) -> None:
    place = {"cx": f"{middle[0]:.4f}", "cy": f"{middle[1]:.4f}", "r": f"{diameter / 2:.4f}"}
    ElementTree.SubElement(layer, "circle", {**place, "class": name})


def _add_text(layer: ElementTree.Element, place: tuple[float, float], text: str) -> None:
    look = {
        "font-size": f"{FOIL_TEXT_SIZE}",
        "text-anchor": "middle",
        "stroke": "none",
        "fill": "gray",
    }
    at = {"x": f"{place[0]:g}", "y": f"{place[1]:g}"}
    ElementTree.SubElement(layer, "text", {**at, **look}).text = text
