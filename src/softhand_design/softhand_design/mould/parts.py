"""Shell and core of an actuator's mould (thesis 3.2.1, Fig. 3.3).

Both meet in the plane z = 0 of the passive layer. The core stands on a plate and leaves the chamber
free; the shell holds the outside with the grooves of the thread and its nubs. Around the cavity
follow a land on which both touch, a step that undulates along the rim, and the rim for the clips.
At the base (x = 0) the mould is open; at the other end the shell has a foot to stand on.
"""

from __future__ import annotations

from dataclasses import dataclass

import manifold3d
import numpy as np

from softhand_design.mould.parameters import MouldParameters
from softhand_design.mould.plan import Array, Line, Outline, nose_length, outline
from softhand_design.mould.surface import Dome, Relief, closed, dome, lid_points
from softhand_model.hand.actuator import Actuator

FLAT = 0.1  # half the flat part of a roof, at least [mm]
LEAST_FILLET = 0.2  # [mm]
LAND = 2.0  # width of the sealing land [mm]
RAMP = 1.0  # over which the step rises [mm]
RAMP_RINGS = 4
FOOT = 6.0  # thickness of the foot [mm]
SLENDER = 4.0  # largest height of the standing mould over the depth of its foot [-]
SUNK = 1.0  # depth of the core in its plate [mm], which joins both
BEYOND = 2.0  # of the sides past the base [mm], cut off in the end
LARGEST_ARC_ANGLE = 90.0  # [deg]
RIM_CLEARANCE = 1.0  # least space between parts of a rim that bends towards itself [mm]
NUB_HALF = 0.4  # half length of a nub [mm]


@dataclass(frozen=True)
class Mould:
    """A mould of two parts.

    line, parameters: what it was made from. chambers: start and end [mm] of each air chamber along
    the actuator. fillet [mm]: radius for which there was room. shell, core: both parts [mm], as
    they lie when the mould is closed.
    """

    line: Line
    parameters: MouldParameters
    chambers: tuple[tuple[float, float], ...]
    fillet: float
    shell: manifold3d.Manifold
    core: manifold3d.Manifold


def kind_name(actuator: Actuator, turn: int) -> str:
    """The name of an actuator's kind; an arc that turns towards -y has a mirrored mould."""
    return f"{actuator.name}_mirrored" if turn < 0 else actuator.name


def sided(solid: manifold3d.Manifold, turn: int) -> manifold3d.Manifold:
    """The solid, mirrored for an arc that turns towards -y."""
    return solid.mirror((0.0, 1.0, 0.0)) if turn < 0 else solid


def build_mould(
    actuator: Actuator, parameters: MouldParameters | None = None, split: float | None = None
) -> Mould:
    """The mould of an actuator, its chamber split at s = split [mm] if that is given.

    Raises ValueError for an actuator that leaves no room for a chamber, its edges or the rim.
    """
    line, used = Line(actuator), parameters or MouldParameters()
    chambers, fillet = _room(line, used, split)
    outside = _outside(line, used)
    grow = [used.scale] * 3
    shell, core = _shell(line, used, outside), _core(line, used, outside, chambers, fillet)
    return Mould(line, used, chambers, fillet, shell.scale(grow), core.scale(grow))


def build_cast(actuator: Actuator) -> tuple[manifold3d.Manifold, manifold3d.Manifold]:
    """The cured rubber [mm] of an actuator's mould as it lies there, first with its chamber filled,
    then as it is.

    Raises ValueError as `build_mould` does.
    """
    line, used = Line(actuator), MouldParameters()
    chambers, fillet = _room(line, used, None)
    outside = _outside(line, used)
    inner = _inner(line, used, outside)
    whole = closed(list(inner.rings), lid_points(inner.rings[0]), inner.lid)
    filled = whole.trim_by_plane((1.0, 0.0, 0.0), 0.0)
    return filled, filled - _core(line, used, outside, chambers, fillet)


def check_room(actuator: Actuator) -> None:
    """Raise ValueError as `build_mould` does, without building anything."""
    _room(Line(actuator), MouldParameters(), None)


def _room(
    line: Line, used: MouldParameters, split: float | None
) -> tuple[tuple[tuple[float, float], ...], float]:
    """Chambers and fillet [mm] that an actuator leaves room for."""
    chambers = _chambers(line, used, split)
    fillet = _room_for_fillet(line, used, chambers)
    _refuse_far_arcs(line, used)
    return chambers, fillet


def groove_places(line: Line, parameters: MouldParameters) -> Array:
    """Places s [mm] of the grooves of the thread."""
    last = line.length - nose_length(float(line.half_width(np.array(line.length)))) - 1.0
    return np.arange(parameters.plug, last, parameters.groove_pitch)


def _chambers(
    line: Line, used: MouldParameters, split: float | None
) -> tuple[tuple[float, float], ...]:
    ends = [used.plug, line.length - used.plug]
    if split is not None:
        ends[1:1] = [split - used.plug / 2.0, split + used.plug / 2.0]
    found = tuple(zip(ends[::2], ends[1::2], strict=True))
    for start, stop in found:
        low = float(line.half_room(np.linspace(start, stop, 33)).min())
        if stop - start < 2.5 * min(low, 5.0) or low <= 0.0:
            raise ValueError(
                f"plug: expected chambers longer than wide between plugs of {used.plug:g} mm, got "
                f"one from {start:g} to {stop:g} mm of the {line.length:g} mm of {line.name}; take "
                "a smaller --plug"
            )
    return found


def _room_for_fillet(
    line: Line, used: MouldParameters, chambers: tuple[tuple[float, float], ...]
) -> float:
    """The fillet [mm] of the chamber: smaller where a low or narrow one leaves no room."""
    slope = np.tan(np.radians(used.draft))
    s = np.concatenate([np.linspace(*ends, 65) for ends in chambers])
    tangent = 1.0 / np.tan((np.pi / 2.0 + np.radians(used.draft)) / 2.0)  # over the radius
    flat = line.half_room(s) - line.roof(s) * slope - FLAT
    most = float(min((flat / tangent).min(), line.roof(s).min() / 1.2))
    if most < LEAST_FILLET:
        raise ValueError(
            f"width: expected a chamber of {line.name} with room for edges rounded by "
            f"{LEAST_FILLET:g} mm between its slanted walls, got room for {most:.2g} mm; make it "
            "wider or higher"
        )
    return min(used.fillet, most)


def _refuse_far_arcs(line: Line, used: MouldParameters) -> None:
    if line.radius is None:
        return
    inner = line.radius - float(line.half_width(np.linspace(0.0, line.length, 33)).max())
    if inner < used.reach + RIM_CLEARANCE:
        raise ValueError(
            f"rim: expected at most {inner - RIM_CLEARANCE - used.shell:.3g} mm inside the arc of "
            f"{line.name}, got {used.rim:g}"
        )
    angle = float(np.degrees(line.length / line.radius))
    if angle > LARGEST_ARC_ANGLE + 0.1:
        raise ValueError(
            f"arc_angle: expected at most {LARGEST_ARC_ANGLE:g} deg, got {angle:.4g}: of a longer "
            f"arc the tip of {line.name} would rise where the mould stands to be filled, and trap "
            "air"
        )


def _outside(line: Line, used: MouldParameters) -> Outline:
    """Outline of the actuator, past its base, with the stations that grooves and nubs need."""
    width = float(line.half_width(np.array(0.0)))
    places = groove_places(line, used)
    half = used.thread / 2.0
    flank = half + used.groove_depth / 2.0
    nubs = places[:-1] + used.groove_pitch / 2.0
    shifts = [(places, d) for d in (-flank, -half, half, flank)]
    shifts += [(nubs, d) for d in (-NUB_HALF, 0.0, NUB_HALF)]
    extra = np.concatenate([centre + shift for centre, shift in shifts] + [np.zeros(1)])
    return outline(line, line.half_width, -nose_length(width) - BEYOND, line.length, extra)


def _relief(line: Line, used: MouldParameters, s: Array) -> Relief:
    places = groove_places(line, used)
    half = used.thread / 2.0
    away = np.abs(s[:, None] - places).min(axis=1, initial=np.inf)
    share = np.clip(1.0 - (away - half) / (used.groove_depth / 2.0), 0.0, 1.0)
    nubs = places[:-1] + used.groove_pitch / 2.0
    near = np.abs(s[:, None] - nubs).min(axis=1, initial=np.inf)
    nub = used.groove_depth * np.clip(1.0 - near / NUB_HALF, 0.0, 1.0)
    return Relief(used.groove_depth * share, nub)


def _interface(used: MouldParameters, outside: Outline, clearance: float) -> list[Array]:
    """Rings from the cavity's edge to that of the rim; the step lifted by a clearance [mm]."""
    path = outside.moved(LAND + RAMP)
    steps = np.linalg.norm(np.diff(path, axis=0, append=path[:1]), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)[:-1]])
    wave = np.sin(2.0 * np.pi * (along - along[len(along) // 2]) / used.step_period)
    ramp = np.linspace(0.0, 1.0, RAMP_RINGS + 1)
    risen = np.append(ramp**2 * (3.0 - 2.0 * ramp), 1.0)
    distances = np.append(LAND + RAMP * ramp, used.reach)
    return [
        np.column_stack([outside.moved(far), share * (used.step * wave + clearance)])
        for far, share in zip(distances, risen, strict=True)
    ]


def _inner(line: Line, used: MouldParameters, outside: Outline) -> Dome:
    """The outside of the rubber, with grooves and nubs."""
    relief = _relief(line, used, outside.s)
    draft = np.radians(used.draft)
    return dome(line, outside, line.height, draft, used.edge, 0.0, 0.0, relief)


def _shell(line: Line, used: MouldParameters, outside: Outline) -> manifold3d.Manifold:
    draft = np.radians(used.draft)
    inner = _inner(line, used, outside)
    outer = dome(
        line,
        outside,
        lambda s: line.height(s) + used.shell,
        abs(draft),
        used.edge + used.shell / 2.0,
        used.plate,
        used.shell,
    )
    edge = np.column_stack([outside.moved(used.reach), np.full(len(outside.s), used.plate)])
    rings = [*inner.reversed_rings, *_interface(used, outside, used.clearance), edge, *outer.rings]
    whole = closed(rings, inner.lid, outer.lid).trim_by_plane((1.0, 0.0, 0.0), 0.0)
    return whole + _foot(line, used, edge)


def _foot(line: Line, used: MouldParameters, edge: Array) -> manifold3d.Manifold:
    """A bar across the tip, flat at the mould's far end, on which it stands while it is filled."""
    low, high = edge[edge[:, 0] > 0.0].min(axis=0), edge.max(axis=0)
    bottom = used.plate / 2.0
    top = max(float(line.height(np.zeros(1))[0]) + used.shell, high[0] / SLENDER)
    lean = (top - bottom) * np.tan(np.radians(abs(used.draft)))
    corners = [
        (x, y, z)
        for z, inset in ((bottom, 0.0), (top, lean))
        for x in (high[0] - FOOT + min(inset, FOOT / 2.0), high[0])
        for y in (low[1] + inset, high[1] - inset)
    ]
    return manifold3d.Manifold.hull_points(np.array(corners))


def _core(
    line: Line,
    used: MouldParameters,
    outside: Outline,
    chambers: tuple[tuple[float, float], ...],
    fillet: float,
) -> manifold3d.Manifold:
    flat = np.column_stack([outside.points, np.zeros(len(outside.s))])
    edge = np.column_stack([outside.moved(used.reach), np.full(len(outside.s), -used.plate)])
    rings = [flat, *_interface(used, outside, 0.0), edge]
    plate = closed(rings, lid_points(flat), lid_points(edge))
    found = plate.trim_by_plane((1.0, 0.0, 0.0), 0.0)
    for start, stop in chambers:
        around = outline(line, line.half_room, start, stop, np.zeros(0))
        room = dome(line, around, line.roof, np.radians(used.draft), fillet, -SUNK)
        found += closed(list(room.rings), lid_points(room.rings[0]), room.lid)
    return found
