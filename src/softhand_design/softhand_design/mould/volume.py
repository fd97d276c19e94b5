"""Differences between the volumes of rubber in a mould and in the model: contribution of each
feature, from formulas."""

from __future__ import annotations

import numpy as np

from softhand_design.mould.parameters import MouldParameters
from softhand_design.mould.parts import NUB_HALF, Mould, groove_places
from softhand_design.mould.plan import Along, Array, Line, nose_length
from softhand_design.mould.surface import SECTION_STATIONS

POINTS = 400


def corrections(mould: Mould) -> dict[str, float]:
    """What each feature adds to the volume of top and side walls [mm3], by its name."""
    line, used, chambers = mould.line, mould.parameters, mould.chambers
    slope = float(np.tan(np.radians(used.draft)))
    whole = (0.0, line.length)
    filled = _integral(_room(line), *whole) - sum(_integral(_room(line), *c) for c in chambers)
    hull = _less(line.height, line.half_width, used.edge, slope, whole, (line.length,))
    rooms = [_less(line.roof, line.half_room, mould.fillet, slope, c, c) for c in chambers]
    found = {"plugs": filled} | {key: sum(room[key] for room in rooms) - hull[key] for key in hull}
    found["grooves"] = -_grooves(line, used, slope)
    found["nubs"] = _nubs(line, used, slope)
    return found


def _less(
    height: Along,
    half_width: Along,
    fillet: float,
    slope: float,
    ends: tuple[float, float],
    closed: tuple[float, ...],
) -> dict[str, float]:
    """What a dome lacks [mm3] of the box of its height and width: by the draft of its sides, by its
    round edges, and by the noses at those ends that are closed.
    """
    edge = _fillet_area(fillet, slope)
    found = {
        "draft": _integral(lambda s: slope * height(s) ** 2, *ends),
        "fillets": 2.0 * edge * (ends[1] - ends[0]),
        "round ends": 0.0,
    }
    for end in closed:
        at = np.array(end)
        h, b = float(height(at)), float(half_width(at))
        nose = nose_length(b)
        round_edge = _half_turn(b, nose)
        found["round ends"] += 2.0 * b * nose * (1.0 - np.pi / 4.0) * h
        # along the nose the wall turns, so that slant and round edge follow its longer way
        found["draft"] += slope * h**2 / 2.0 * (round_edge - 2.0 * nose)
        found["fillets"] += edge * (round_edge - 2.0 * nose)
    return found


def _half_turn(half_width: float, nose: float) -> float:
    """Length [mm] of the outline around a nose."""
    angle = np.linspace(0.0, np.pi / 2.0, POINTS)
    steps = np.diff([nose * np.sin(angle), half_width * np.cos(angle)])
    return 2.0 * float(np.sum(np.hypot(*steps)))


def _fillet_area(fillet: float, slope: float) -> float:
    """Area [mm2] that a round edge takes from the corner of wall and level back."""
    angle = np.pi / 2.0 + np.arctan(slope)
    return fillet**2 * float(1.0 / np.tan(angle / 2.0) - (np.pi - angle) / 2.0)


def _room(line: Line) -> Along:
    return lambda s: 2.0 * line.half_room(s) * line.roof(s)


def _grooves(line: Line, used: MouldParameters, slope: float) -> float:
    """Their mean width is thread and one flank; they run up both walls and across the back."""
    s = groove_places(line, used)
    height, half = line.height(s), line.half_width(s)
    tangent = used.edge / np.tan((np.pi / 2.0 + np.arctan(slope)) / 2.0)
    bow = used.edge * (np.pi / 2.0 - np.arctan(slope)) - 2.0 * tangent
    around = 2.0 * height * np.hypot(1.0, slope) + 2.0 * (half - height * slope) + 2.0 * bow
    deep = used.groove_depth
    return float(np.sum(around)) * deep * (used.thread + deep / 2.0)


def _nubs(line: Line, used: MouldParameters, slope: float) -> float:
    """Pyramids of a third of their boxes, two in every second row between the grooves."""
    s = groove_places(line, used)[:-1] + used.groove_pitch / 2.0
    flat = 2.0 * (line.half_width(s) - line.height(s) * slope - used.edge)
    base = flat * (SECTION_STATIONS[3] - SECTION_STATIONS[1]) * 2.0 * NUB_HALF
    return float(np.sum(2.0 * base * used.groove_depth / 3.0))


def _integral(area: Along, start: float, stop: float) -> float:
    nodes, weights = np.polynomial.legendre.leggauss(64)
    half = (stop - start) / 2.0
    x: Array = start + half * (nodes + 1.0)
    return float(np.sum(half * weights * area(x)))
