"""Pictures of a hand's parts as they lie together, from the files of its kit."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from pneuflex_sim.bullet import is_installed, pybullet
from pneuflex_sim.pictures.painter import paint
from pneuflex_sim.pictures.render import Camera, draw_mesh, photograph
from pneuflex_sim.scene.mesh import Mesh, creased, mesh_of
from softhand_design.kit.kit import Kit

MILLI = 1e-3
PART_COLORS = {"actuators": "#e8894a", "passive layers": "#7a3b1d", "scaffold": "#59606f"}
PART_COLORS |= {"saddles": "#2f7d4f", "sheet": "#f3d2a0"}
ASSEMBLY_LOOKS = (  # title, yaw and pitch of the camera [deg], whether the sheet is shown
    ("from the palm", 90.0, 0.0, True),
    ("aslant, without a sheet", 60.0, -12.0, False),
    ("from the back", -60.0, -12.0, True),
    ("from the thumb's side", 180.0, 0.0, True),
)
PICTURE_SIZE = (740, 820)  # [pixels]
CAMERA_FAR, ASSEMBLY_MARGIN = 2.0, 1.12  # distance [m] of the camera; room around the hand


def draw_assembled(kit: Kit) -> Figure:
    """A hand's parts in its wrist frame, from four sides, in colours by kind."""
    shown = _meshes(kit)
    corners = np.concatenate([mesh.vertices for _, mesh in shown])
    low, high = corners.min(axis=0), corners.max(axis=0)
    wide, tall = float(np.hypot(*(high - low)[:2])), float(high[2] - low[2])
    span = ASSEMBLY_MARGIN * max(tall, wide * PICTURE_SIZE[1] / PICTURE_SIZE[0])
    angle = 2.0 * np.degrees(np.arctan(span / 2.0 / CAMERA_FAR))
    figure = Figure(figsize=(14.0, 5.0), dpi=110, layout="constrained")
    for axes, (title, yaw, pitch, with_sheet) in zip(
        figure.subplots(1, len(ASSEMBLY_LOOKS)), ASSEMBLY_LOOKS, strict=True
    ):
        light = (2.0 * np.sin(np.radians(yaw)), -2.0 * np.cos(np.radians(yaw)), 1.5)
        camera = Camera(tuple((low + high) / 2.0), CAMERA_FAR, yaw, pitch, float(angle), light)
        seen = [part for part in shown if with_sheet or part[0] != "sheet"]
        axes.imshow(_picture(seen, camera))
        axes.set_axis_off()
        axes.set_title(title, fontsize=10)
    present = {kind for kind, _ in shown}
    patches = [
        Patch(color=color, label=kind) for kind, color in PART_COLORS.items() if kind in present
    ]
    figure.legend(handles=patches, loc="outside lower center", ncols=len(patches))
    size = " x ".join(f"{value / MILLI:.0f}" for value in high - low)
    figure.suptitle(f"{kit.hand.name}: parts as printed and cast, {size} mm")
    return figure


def _meshes(kit: Kit) -> list[tuple[str, Mesh]]:
    """Kind and mesh [m] of every part's copies."""
    kinds = {part.name: "actuators" for part in kit.casts}
    kinds |= {part.name: "passive layers" for part in kit.layers}
    kinds |= {part.name: "saddles" for part in kit.structure}
    kinds[kit.structure[0].name] = "scaffold"
    found = []
    for part in kit.in_hand:
        for solid in part.placed().values():
            mesh = solid.to_mesh64()
            vertices = np.asarray(mesh.vert_properties)[:, :3] * MILLI
            faces = np.asarray(mesh.tri_verts).astype(np.int32).ravel()
            found.append((kinds.get(part.name, "sheet"), mesh_of(vertices, faces)))
    return found


def _picture(shown: list[tuple[str, Mesh]], camera: Camera) -> NDArray[np.uint8]:
    colors = {kind: (*to_rgb(color), 1.0) for kind, color in PART_COLORS.items()}
    if not is_installed():
        return paint(
            [], [(mesh.corners, colors[kind]) for kind, mesh in shown], camera, PICTURE_SIZE
        )
    client = pybullet.connect(pybullet.DIRECT)
    try:
        for kind, mesh in shown:
            draw_mesh(creased(mesh), [0.0] * 3, [0.0, 0.0, 0.0, 1.0], colors[kind], client)
        return photograph(camera, PICTURE_SIZE, client)
    finally:
        pybullet.disconnect(client)
