"""Measuring finished parts: rays, the rubber between closed parts, walls, draft, undercut."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from io import BytesIO

import manifold3d
import numpy as np
import trimesh
from numpy.typing import NDArray

from softhand_design.mould.parts import LAND, NUB_HALF, RAMP, Mould, groove_places
from softhand_design.mould.plan import Array, nose_length, outline
from softhand_design.mould.surface import solid_of

OUTSIDE = 1e3  # beyond all moulds [mm]
MEASURED_STEP = 1e-3  # gaps below are rounding of the file, not form [mm]
TILT = np.radians(1.0)  # of the pull in any direction, at which a part still has to come off
SIDES = 8
AROUND = 2.5  # beside the cavity [mm] that is searched for undercut
LAND_FROM_GROOVE = 0.75  # from a groove's middle to where a wall is measured [mm]
LAND_FROM_NUB = 0.5
SPINE = 1.5  # from the ends of a chamber, more than their slant, to those of its middle line [mm]
END = 3.0  # from the rounded ends of the chamber [mm]
HEIGHTS = 5  # at which the ends of the chambers are measured
STEEP = np.sin(np.radians(6.0))  # what is steeper counts as a wall, no facet of a round edge is


def stl_of(part: manifold3d.Manifold) -> bytes:
    """The part as a binary STL file [mm], without triangles whose corners its numbers join."""
    mesh = part.to_mesh64()
    rounded = np.asarray(mesh.vert_properties)[:, :3].astype(np.float32)
    vertices, place = np.unique(rounded, axis=0, return_inverse=True)
    faces = place.reshape(-1)[np.asarray(mesh.tri_verts)]
    distinct = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    found = trimesh.Trimesh(vertices, faces[distinct], process=False)
    return trimesh.exchange.stl.export_stl(found)


def read_stl(content: bytes) -> trimesh.Trimesh:
    """The mesh [mm] in a binary STL file, vertices at one place joined."""
    return trimesh.load_mesh(BytesIO(content), file_type="stl")


@dataclass(frozen=True)
class Finished:
    """A mould as read from its files: meshes [mm] of both parts, and the same as solids."""

    mould: Mould
    shell_mesh: trimesh.Trimesh
    core_mesh: trimesh.Trimesh
    shell: manifold3d.Manifold
    core: manifold3d.Manifold
    cast: manifold3d.Manifold

    @cached_property
    def straight(self) -> manifold3d.Manifold:
        """The cast in the coordinates s, y and z [mm] of the cured rubber, in which arcs are
        straight.
        """
        line, scale = self.mould.line, self.mould.parameters.scale

        def straight(points: Array) -> Array:
            flat = np.asarray(points) / scale
            return np.column_stack([line.track(flat[:, :2]), flat[:, 2]])

        return self.cast.warp_batch(straight)


def finished(mould: Mould, files: dict[str, bytes]) -> Finished:
    """Read the files `shell` and `core` again, and fill the cavity between them.

    Raises ValueError for files that are not closed.
    """
    meshes = {name: read_stl(content) for name, content in files.items()}
    shell, core = (
        solid_of(meshes[name].vertices, meshes[name].faces) for name in ("shell", "core")
    )
    cast = _cavity(mould, shell, core)
    return Finished(mould, meshes["shell"], meshes["core"], shell, core, cast)


def _cavity(
    mould: Mould, shell: manifold3d.Manifold, core: manifold3d.Manifold
) -> manifold3d.Manifold:
    """The rubber between the closed parts, filled to the brim."""
    _, low_y, _, high_x, high_y, high_z = shell.bounding_box()
    box = manifold3d.Manifold.cube((high_x, high_y - low_y, high_z)).translate((0.0, low_y, 0.0))
    middle = mould.parameters.plug * mould.parameters.scale / 2.0
    point = np.append(mould.line.place(middle, 0.0), float(mould.line.height(np.zeros(1))[0]) / 2.0)
    for part in (box - (shell + core)).decompose():
        if len(hits_of(part, point, point + [0.0, 0.0, OUTSIDE])) % 2:
            return part
    raise ValueError("mould: expected an air chamber at the base of the actuator, got solid rubber")


def hits_of(solid: manifold3d.Manifold, start: Array, stop: Array) -> Array:
    """Distances [mm] along a ray from start at which it meets a surface."""
    length = float(np.sqrt(np.sum((stop - start) ** 2)))
    hits = solid.ray_cast(start.tolist(), stop.tolist())
    return np.array([hit.distance for hit in hits]) * length


def plan_rays(solid: manifold3d.Manifold, count: int, seed: int = 0) -> Array:
    """How often each of `count` rays, parallel to the direction of pull and at random places,
    enters the part (count,).
    """
    low, high = np.reshape(solid.bounding_box(), (2, 3))
    points = np.random.default_rng(seed).uniform(low[:2], high[:2], (count, 2))
    hits = [_vertical(solid, x, y) for x, y in points]
    return np.array([min(len(found), 1 + np.sum(_gaps(found) > 0.0)) for found in hits])


def _gaps(hits: Array) -> Array:
    """Free lengths [mm] between where a ray leaves a part and enters it again."""
    gaps = hits[2:-1:2] - hits[1:-2:2]
    return np.where(gaps > MEASURED_STEP, gaps, 0.0)


def _vertical(solid: manifold3d.Manifold, x: float, y: float) -> Array:
    return hits_of(solid, np.array([x, y, -OUTSIDE]), np.array([x, y, OUTSIDE])) - OUTSIDE


def tilted_rays(solid: manifold3d.Manifold, mould: Mould, count: int, seed: int = 1) -> Array:
    """The deepest gap (count,) [mm] behind an overhang on each of `count` rays that are tilted by a
    degree against the direction of pull, over the cavity and a little around it; 0 for a ray that
    enters the part once.
    """
    random, line = np.random.default_rng(seed), mould.line
    s = random.uniform(1.0, line.length + AROUND, count)
    half = line.half_width(s) + AROUND
    places = line.place(s, random.uniform(-half, half)) * mould.parameters.scale
    heights = random.uniform(0.0, float(line.height(np.zeros(1))[0]), count)
    angle = 2.0 * np.pi * random.integers(0, SIDES, count) / SIDES
    lean = np.tan(TILT) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    reach, found = 10.0 + 2.0 * solid.bounding_box()[5], np.zeros(count)
    for i, (place, height, tilt) in enumerate(zip(places, heights, lean, strict=True)):
        way = np.append(tilt, 1.0)
        point = np.append(place, height)
        found[i] = _gaps(hits_of(solid, point - reach * way, point + reach * way)).max(initial=0.0)
    return found


def free_stations(mould: Mould, count: int, random: np.random.Generator) -> Array:
    """Places s [mm] along the chambers at random, between grooves and nubs."""
    line, used = mould.line, mould.parameters
    grooves = groove_places(line, used)
    nubs = grooves[:-1] + used.groove_pitch / 2.0
    room = []
    for start, stop in mould.chambers:
        noses = [nose_length(float(line.half_room(np.array(end)))) for end in (start, stop)]
        last = min(
            stop - noses[1], line.length - nose_length(float(line.half_width(np.array(stop))))
        )
        room.append(np.linspace(start + noses[0] + END, last - END, 4001))
    s = np.concatenate(room)
    apart = np.abs(s[:, None] - grooves).min(axis=1) > LAND_FROM_GROOVE
    apart &= np.abs(s[:, None] - nubs).min(axis=1) > LAND_FROM_NUB
    return random.choice(s[apart], count)


def walls(found: Finished, count: int, seed: int = 2) -> tuple[Array, Array]:
    """Measured and wanted thickness (count,) [mm] at random points of top and side walls, in the
    cross section: the top along z, the sides across their slant.
    """
    mould, solid = found.mould, found.straight
    line, used, random = mould.line, mould.parameters, np.random.default_rng(seed)
    slope, slant = np.tan(np.radians(used.draft)), np.cos(np.radians(used.draft))
    s = free_stations(mould, count, random)
    share = random.uniform(0.0, 1.0, count)
    measured, wanted = np.zeros(count), np.zeros(count)
    for i in range(count):
        here = s[i : i + 1]
        roof = float(line.roof(here)[0])
        if i % 2:
            half = float(line.half_room(here)[0]) - roof * slope - 1.1 * mould.fillet
            y = (2.0 * share[i] - 1.0) * max(half, 0.0)
            hits = _vertical(solid, s[i], y)
            measured[i], wanted[i] = hits[-1] - hits[-2], float(line.wall(here)[0])
        else:
            z = 0.3 + share[i] * (roof - 1.2 * mould.fillet - 0.3)
            across = _across(solid, s[i], z)
            pair = across[:2] if i % 4 else across[2:4]
            measured[i] = (pair[1] - pair[0]) * slant
            wanted[i] = float(line.side_wall(here)[0])
    return measured, wanted


def _across(solid: manifold3d.Manifold, s: float, z: float) -> Array:
    return hits_of(solid, np.array([s, -OUTSIDE, z]), np.array([s, OUTSIDE, z])) - OUTSIDE


def top_across_slope(found: Finished) -> Array:
    """Thickness (n,) [mm] of the top wall on the middle line, perpendicular to its slope, beside
    every groove over the chambers' flat roofs.
    """
    mould, solid = found.mould, found.straight
    s = groove_places(mould.line, mould.parameters) + mould.parameters.groove_pitch / 4.0
    slant = mould.line.roof(s) * np.tan(np.radians(mould.parameters.draft))
    inset = 1.2 * mould.fillet + 0.2 + slant
    over = [(s > start + inset) & (s < stop - inset) for start, stop in mould.chambers]
    stations = s[np.any(over, axis=0)]
    near = [[_vertical(solid, x + d, 0.0)[-2:] for d in (-0.1, 0.0, 0.1)] for x in stations]
    top = np.array(near).reshape(-1, 3, 2)
    slope = (top[:, 2, 0] - top[:, 0, 0]) / 0.2
    return (top[:, 1, 1] - top[:, 1, 0]) / np.hypot(1.0, slope)


def _end_heights(mould: Mould) -> Array:
    """Heights [mm] from the passive layer to where the ends of chambers or tip become round."""
    line = mould.line
    rooms = float(line.roof(np.ravel(mould.chambers)).min()) - 1.2 * mould.fillet
    tip = float(line.height(np.array(line.length))) - 1.2 * mould.parameters.edge
    return np.linspace(0.1, 0.9, HEIGHTS) * min(rooms, tip)


def end_walls(found: Finished) -> tuple[Array, Array]:
    """Measured and wanted thickness of rubber (heights, chambers + 1) [mm] before, between and
    behind the chambers along the middle line; measured values are NaN at a height where walls are
    missing.
    """
    mould, solid = found.mould, found.straight
    count = len(mould.chambers) + 1
    slanted = np.array([1.0, *[2.0] * (count - 2), 0.0])  # at the tip the outside leans as well
    heights = _end_heights(mould)
    wanted = mould.parameters.plug + np.outer(
        heights * np.tan(np.radians(mould.parameters.draft)), slanted
    )
    measured = np.full_like(wanted, np.nan)
    for row, z in zip(measured, heights, strict=True):
        hits = hits_of(solid, np.array([-OUTSIDE, 0.0, z]), np.array([OUTSIDE, 0.0, z]))
        if len(hits) == 2 * count:
            row[:] = hits[1::2] - hits[::2]
    return measured, wanted


def around_ends(found: Finished) -> tuple[Array, Array]:
    """Measured and wanted thickness of rubber (n,) [mm] in the plane, from points of the chambers'
    rounded ends to the nearest point of the outside or of another chamber. Wanted are the side wall
    without the grooves, or a plug, which in an arc is shorter towards the centre.
    """
    mould, scale = found.mould, found.mould.parameters.scale
    line, used = mould.line, mould.parameters
    least, due = [], []
    for z in _end_heights(mould) * scale:
        curves = [np.asarray(curve) / scale for curve in found.cast.slice(z).to_polygons()]
        outer = max(curves, key=lambda curve: float(np.ptp(curve[:, 0])))
        for room in curves:
            s, y = line.track(room).T
            reach = END + nose_length(float(np.ptp(y)) / 2.0)
            near = (s < s.min() + reach) | (s > s.max() - reach)
            if room is not outer:
                others = [_distance(room[near], curve) for curve in curves if curve is not room]
                least.append(np.min(others, axis=0))
                plug = used.plug * (1.0 - y[near] / (line.radius or np.inf))
                due.append(np.minimum(plug, line.side_wall(s[near]) - used.groove_depth))
    none = [np.full(1, np.nan)]
    return np.concatenate(least or none), np.concatenate(due or none)


def _distance(points: Array, curve: Array) -> Array:
    """Distance (n,) [mm] of points (n, 2) from a closed curve."""
    edge = np.roll(curve, -1, axis=0) - curve
    off = points[:, None] - curve
    share = np.sum(off * edge, axis=-1) / np.maximum(np.sum(edge**2, axis=-1), 1e-12)
    return np.linalg.norm(off - np.clip(share, 0.0, 1.0)[..., None] * edge, axis=-1).min(axis=1)


def groove_depths(found: Finished) -> Array:
    """Depth [mm] of the grooves in the side walls and on the back, against the lands on both
    sides.
    """
    mould, solid = found.mould, found.straight
    half = mould.parameters.groove_pitch / 4.0

    def outside(s: float) -> Array:
        hits = _across(solid, s, float(mould.line.height(np.array(s))) / 3.0)
        return np.array([(hits[-1] - hits[0]) / 2.0, _vertical(solid, s, 0.0)[-1]])

    places = groove_places(mould.line, mould.parameters)
    return np.array(
        [(outside(s - half) + outside(s + half)) / 2.0 - outside(s) for s in places[1:-1]]
    )


def nub_heights(found: Finished) -> Array:
    """Height [mm] of the nubs on both edges of the back: how far corners of the cast stand out over
    those of the model.
    """
    line, used = found.mould.line, found.mould.parameters
    s, y, z = np.asarray(found.straight.to_mesh64().vert_properties)[:, :3].T
    over = z - line.height(s)
    return np.array(
        [
            over[(np.abs(s - place) < NUB_HALF) & (side * y > 0.0)].max(initial=-np.inf)
            for place in groove_places(line, used)[:-1] + used.groove_pitch / 2.0
            for side in (-1.0, 1.0)
        ]
    )


def foot_share(found: Finished) -> float:
    """Share [-] of the mould's cross section, as wide and high as the shell, on which it stands."""
    _, low_y, low_z, high_x, high_y, high_z = found.shell.bounding_box()
    end = found.shell.trim_by_plane((1.0, 0.0, 0.0), high_x - 1.0).volume()
    return end / (high_y - low_y) / (high_z - low_z)


def draft_angles(found: Finished) -> tuple[Array, Array]:
    """Angle [deg] between the direction of pull and every triangle of the cavity's walls, positive
    where the part comes off, and the areas [mm2] of the triangles; grooves, round edges and the
    brim are left out. Both are empty if nothing is as steep as a wall.
    """
    line, used = found.mould.line, found.mould.parameters
    mesh = found.cast.to_mesh64()
    corners = np.asarray(mesh.vert_properties)[:, :3][np.asarray(mesh.tri_verts)]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normal, axis=1) / 2.0
    fine = area > 1e-6
    corners, area, up = corners[fine], area[fine], normal[fine, 2] / (2.0 * area[fine])
    middle = corners.mean(axis=1) / used.scale
    inner = _faces_chamber(found.mould, middle, normal[fine, :2])
    s = line.track(middle[:, :2])[:, 0]
    wall = (np.abs(up) < STEEP) & (corners[..., 0].min(axis=1) > 1e-3)
    away = np.abs(s[:, None] - groove_places(line, used)).min(axis=1)
    wall &= inner | (away > LAND_FROM_GROOVE)
    angle = np.degrees(np.arcsin(np.where(inner, -up, up)))
    return angle[wall], area[wall]


def _faces_chamber(mould: Mould, points: Array, normals: Array) -> NDArray[np.bool_]:
    """Whether points (n, 3) [mm] of the cast's surface, with outward normals (n, 2), belong to a
    chamber: they lie inside the middle of the side walls, and the normals point to the middle of
    the nearest chamber.
    """
    line = mould.line
    track = line.track(points[:, :2])
    side = line.half_room(track[:, 0]) + line.side_wall(track[:, 0]) / 2.0
    side -= points[:, 2] * np.tan(np.radians(mould.parameters.draft))
    spines = [np.clip(track[:, 0], start + SPINE, stop - SPINE) for start, stop in mould.chambers]
    away = np.array([track[:, 0] - spine for spine in spines])
    nearest = np.abs(away).argmin(axis=0)
    spine = np.array(spines)[nearest, np.arange(len(points))]
    outwards = points[:, :2] - line.place(spine, 0.0)
    return (np.sum(outwards * normals, axis=1) < 0.0) & (np.abs(track[:, 1]) < side)


def interface_gaps(found: Finished, count: int, seed: int = 3) -> tuple[Array, Array]:
    """Vertical gap (count,) [mm] between the closed parts, at random places on land, step and rim,
    and the height (count,) [mm] of the core there.
    """
    mould = found.mould
    line, used = mould.line, mould.parameters
    around = outline(line, line.half_width, 0.0, line.length, np.zeros(0))
    base = nose_length(float(line.half_width(np.zeros(1))[0]))
    beside = around.s > base + LAND  # the cavity is open at its base
    random = np.random.default_rng(seed)
    gaps: list[float] = []
    heights: list[float] = []
    while len(gaps) < count:
        far = random.choice([LAND + RAMP, 0.95 * used.reach])
        x, y = random.choice(around.moved(random.uniform(0.1, far))[beside]) * used.scale
        above, below = _vertical(found.shell, x, y), _vertical(found.core, x, y)
        gaps.append(above[0] - below[-1])
        heights.append(below[-1])
    return np.array(gaps), np.array(heights)
