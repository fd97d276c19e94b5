"""Drawing of a mould: both parts open, sections with dimensions [mm], and the plan."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import manifold3d
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.pictures.render import Camera, draw_mesh, photograph
from pneuflex_sim.scene.mesh import creased, mesh_of
from softhand_common.numerics.arrays import Array
from softhand_design.mould.parts import Mould
from softhand_design.mould.report import CheckedMould

MILLI = 1e-3
COLORS = {"shell": "#8fa3bf", "core": "#6c7686", "rubber": "#f0a35a"}
PIXELS = (900, 620)
FINE = 4.0  # edges of a part that is straightened [mm]
SECTION_PLACES = (0.15, 0.55, 0.9)  # of the length, where cross sections are drawn


def draw_mould(made: CheckedMould) -> Figure:
    """The drawing of a mould."""
    figure = Figure(figsize=(14.0, 10.0), dpi=120)
    grid = figure.add_gridspec(3, 6, height_ratios=(1.6, 0.9, 1.1), hspace=0.15, wspace=0.1)
    for place, name in ((grid[0, :3], "core"), (grid[0, 3:], "shell")):
        axes = figure.add_subplot(place)
        axes.imshow(photograph_part(made.part(name), name))
        axes.set_axis_off()
        axes.set_title(f"{name}, seen into the cavity" if name == "shell" else name)
    straight = _straightened(made)
    _long_section(figure.add_subplot(grid[1, :]), made.mould, straight)
    for i, share in enumerate(SECTION_PLACES):
        where = grid[2, 2 * i : 2 * i + 2] if i < 2 else grid[2, 4:]
        _cross_section(figure.add_subplot(where), made.mould, straight, share)
    figure.subplots_adjust(0.02, 0.02, 0.98, 0.92)
    verdict = "all checks passed" if not made.failed else f"{len(made.failed)} checks FAIL"
    figure.suptitle(
        f"Mould of {made.name}: {verdict}; rubber {made.volumes.measured / 1e3:.2f} cm3, "
        f"chamber {made.volumes.chamber / 1e3:.2f} cm3; lengths in mm"
    )
    return figure


def photograph_part(part: manifold3d.Manifold, name: str) -> NDArray[np.uint8]:
    """A picture (height, width, 3) of one part; the shell is turned so that its cavity is
    visible.
    """
    turned = part.rotate((180.0, 0.0, 0.0)) if name == "shell" else part
    low, high = np.reshape(turned.bounding_box(), (2, 3)) * MILLI
    mesh = turned.to_mesh64()
    vertices = np.asarray(mesh.vert_properties)[:, :3] * MILLI
    surface = mesh_of(vertices, np.asarray(mesh.tri_verts).astype(np.int32).ravel())
    middle = tuple((low + high) / 2.0)
    far = 1.15 * float(np.linalg.norm(high - low))
    camera = Camera(middle, far, 25.0, -48.0, 35.0, (0.5, -0.6, 1.4))
    color = tuple(int(COLORS[name][i : i + 2], 16) / 255.0 for i in (1, 3, 5))
    client = pybullet.connect(pybullet.DIRECT)
    try:
        draw_mesh(creased(surface), [0.0] * 3, [0.0, 0.0, 0.0, 1.0], (*color, 1.0), client)
        return photograph(camera, PIXELS, client)
    finally:
        pybullet.disconnect(client)


def _straightened(made: CheckedMould) -> dict[str, manifold3d.Manifold]:
    """The parts and the rubber with s, y, z for coordinates."""
    line = made.mould.line
    solids = {"shell": made.found.shell, "core": made.found.core, "rubber": made.found.cast}
    if line.radius is None:
        return solids

    def track(points: Array) -> Array:
        flat = np.asarray(points)
        return np.column_stack([line.track(flat[:, :2]), flat[:, 2]])

    return {name: part.refine_to_length(FINE).warp_batch(track) for name, part in solids.items()}


def _fill(axes: Axes, section: manifold3d.CrossSection, color: str, swap: bool) -> None:
    """Fill the polygons of a section, holes left open; coordinates exchanged or not."""
    for polygon in section.to_polygons():
        points = np.asarray(polygon)
        area = np.sum(points[:, 0] * np.roll(points[:, 1], -1))
        area -= np.sum(points[:, 1] * np.roll(points[:, 0], -1))
        shown = points[:, ::-1] if swap else points
        face = color if area > 0.0 else "white"
        axes.fill(shown[:, 0], shown[:, 1], facecolor=face, edgecolor="#333333", linewidth=0.5)


def _sections(
    axes: Axes, parts: dict[str, manifold3d.Manifold], turn: Any, height: float, swap: bool
) -> None:
    for name in ("shell", "core", "rubber"):
        _fill(axes, parts[name].rotate(turn).slice(height), COLORS[name], swap)
    axes.set_aspect("equal")
    axes.set_axis_off()


def _long_section(axes: Axes, mould: Mould, parts: dict[str, manifold3d.Manifold]) -> None:
    line, used = mould.line, mould.parameters
    _sections(axes, parts, (-90.0, 0.0, 0.0), 0.0, False)
    axes.set_title("section along the line (filled at the left, stands on the right)")
    ends = mould.chambers
    marks = [0.0, *(end for pair in ends for end in pair), line.length]
    for start, stop in pairwise(marks):
        _dimension(axes, (start, -used.plate - 3.0), (stop, -used.plate - 3.0), stop - start)
    below = -used.plate - 8.0
    _dimension(axes, (0.0, below), (line.length, below), line.length)
    for s in (0.0, line.length):
        height = float(line.height(np.array(s)))
        beside = s - 3.0 if s == 0.0 else s + used.reach + 3.0
        _dimension(axes, (beside, 0.0), (beside, height), height)
    axes.set_ylim(below - 5.0, mould.shell.bounding_box()[5] + 3.0)


def _cross_section(
    axes: Axes, mould: Mould, parts: dict[str, manifold3d.Manifold], share: float
) -> None:
    line, used = mould.line, mould.parameters
    s = np.array(_between_grooves(mould, share * line.length))
    _sections(axes, parts, (0.0, 90.0, 0.0), -float(s), True)
    half, height, wall = (float(f(s)) for f in (line.half_width, line.height, line.wall))
    axes.set_title(f"at {float(s):.1f}")
    low = -used.plate - 3.0
    _dimension(axes, (-half, low), (half, low), 2.0 * half)
    _dimension(axes, (-half - used.reach - 3.0, 0.0), (-half - used.reach - 3.0, height), height)
    room = float(line.half_room(s))
    for text, point, place in (
        (f"wall {wall:.2f}", (0.0, height - wall / 2.0), (half + 4.0, height + 1.0)),
        (f"side {half - room:.2f}", ((half + room) / 2.0, 1.5), (half + 4.0, height * 0.55)),
        (f"draft {used.draft:g} deg", (half - 0.3, height * 0.45), (half + 4.0, height * 0.8)),
    ):
        axes.annotate(text, point, place, fontsize=8, arrowprops={"arrowstyle": "-", "lw": 0.6})
    axes.set_ylim(low - 4.0, height + used.shell + 3.0)
    axes.set_xlim(-half - used.reach - 8.0, half + used.reach + 14.0)


def _between_grooves(mould: Mould, s: float) -> float:
    used = mould.parameters
    count = np.floor((s - used.plug) / used.groove_pitch)
    return float(used.plug + (count + 0.3) * used.groove_pitch)


def _dimension(axes: Axes, start: tuple, stop: tuple, length: float) -> None:
    """A line with arrows at both ends and its length beside it."""
    across = abs(stop[0] - start[0]) > abs(stop[1] - start[1])
    ends = {"arrowstyle": "<->", "lw": 0.6, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", start, stop, arrowprops=ends)
    middle = ((start[0] + stop[0]) / 2.0, (start[1] + stop[1]) / 2.0)
    shift = (0, -8) if across else (-10 if start[0] < 0.0 else 10, 0)
    axes.annotate(
        f"{length:.4g}",
        middle,
        shift,
        textcoords="offset points",
        ha="center",
        va="center",
        fontsize=8,
        rotation=0 if across else 90,
    )
