"""Draws a hand, its object and surroundings in the browser, with one coarse mesh per channel."""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray

from pneuflex_sim.hand.kinematics import HandShape
from pneuflex_sim.pictures.object_surface import object_mesh
from pneuflex_sim.pictures.render import (
    MATERIAL_COLORS,
    OBJECT_COLOR,
    TABLE_COLOR,
    HandState,
    surroundings,
)
from pneuflex_sim.pictures.skin import COARSE_SKIN, RUBBER_MATERIAL, HandSkin
from pneuflex_sim.pictures.surfaces import pressure_color
from pneuflex_sim.scene.mesh import Mesh, creased, merged
from softhand_common.numerics.arrays import Array
from softhand_play.frames import Frame, StaticScene

Triangles = NDArray[np.uint32]
Color = tuple[int, int, int]

ARROW_COLOR = (40, 160, 60)
SHAFT_RADIUS, HEAD_RADIUS, HEAD_LENGTH = 0.0015, 0.004, 0.008  # of an arrow [m]
SENT_DIGITS = 4  # decimals of sent positions [m] and quaternions: a hand at rest sends nothing
TINT_OPACITY = 0.45  # opacity
COLOR_STEPS = 32  # a colour is sent when the pressure changes by this part of its range


class HandView:
    """The meshes of one hand and its static scene.

    Args:
        server: viser's server, which draws the meshes.
        static_scene: hand, object and surroundings.
        name: name of the meshes' node in the scene tree.
        tint: None, or one colour in place of those that show pressures; the hand is then
            translucent and drawn without object and surroundings.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        static_scene: StaticScene,
        name: str = "/hand",
        tint: Color | None = None,
    ) -> None:
        self.static_scene, self._scene, self._name, self._tint = (
            static_scene,
            server.scene,
            name,
            tint,
        )
        self._atomic = server.atomic
        self._skin = HandSkin(HandShape(static_scene.layout), COARSE_SKIN)
        self._groups = _groups(static_scene, self._skin)
        self._limits = static_scene.layout.description.max_pressures()
        self._root = self._scene.add_frame(name, show_axes=False)
        self._wrist = self._scene.add_frame(f"{name}/wrist", show_axes=False)
        self._colors = {group: self._color(group, 0.0 * self._limits) for group in self._groups}
        parts = {
            name: mesh for name, (_, mesh) in self._skin.parts(static_scene.layout.rest).items()
        }
        self._parts = {
            group: self._mesh(
                f"wrist/{group}", merged([parts[part] for part in names]), self._colors[group]
            )
            for group, names in self._groups.items()
        }
        self._object: viser.MeshHandle | None = None
        if tint is None:
            self._surround()
        self._arrows = self._scene.add_arrows(
            f"{name}/forces",
            np.zeros((1, 2, 3)),
            ARROW_COLOR,
            shaft_radius=SHAFT_RADIUS,
            head_radius=HEAD_RADIUS,
            head_length=HEAD_LENGTH,
            visible=False,
        )

    def _surround(self) -> None:
        """Table, wall and object."""
        for part, (half, place, turn) in surroundings(self.static_scene.scene).items():
            self._scene.add_box(
                f"{self._name}/{part}",
                dimensions=2.0 * np.array(half),
                color=_rgb(TABLE_COLOR),
                position=place,
                wxyz=wxyz(np.array(turn)),
                cast_shadow=False,
                receive_shadow=False,
            )
        if self.static_scene.object is not None:
            mesh = creased(object_mesh(self.static_scene.object))
            self._object = self._mesh("object", mesh, _rgb(OBJECT_COLOR))

    def _mesh(self, name: str, mesh: Mesh, color: Color) -> viser.MeshHandle:
        return self._scene.add_mesh_simple(
            f"{self._name}/{name}",
            mesh.vertices,
            faces(mesh),
            color=color,
            opacity=None if self._tint is None else TINT_OPACITY,
            side="double",
            cast_shadow=False,  # shadows take longer than all the rest
            receive_shadow=False,
        )

    def show(self, frame: Frame) -> None:
        """Show a frame."""
        self.move(frame.state, frame.pressures)
        self._show_arrows(frame.arrows)

    def move(self, state: HandState, pressures: Array) -> None:
        """Show a state, coloured by gauge pressures (channels,) [Pa]."""
        parts = self._skin.vertices(state.joints)
        with self._atomic():
            self._wrist.position = np.round(state.wrist_position, SENT_DIGITS)
            self._wrist.wxyz = wxyz(np.round(state.wrist_orientation, SENT_DIGITS))
            for group, names in self._groups.items():
                vertices = np.vstack([parts[name] for name in names])
                self._show_group(group, vertices, pressures)
            pose = state.object_position, state.object_orientation
            if self._object is not None and pose[0] is not None and pose[1] is not None:
                self._object.position = np.round(pose[0], SENT_DIGITS)
                self._object.wxyz = wxyz(np.round(pose[1], SENT_DIGITS))

    def _show_group(self, group: str, vertices: Array, pressures: Array) -> None:
        color, handle = self._color(group, pressures), self._parts[group]
        handle.vertices = np.round(vertices, SENT_DIGITS).astype(np.float32)
        if self._colors[group] != color:
            self._colors[group] = handle.color = color

    def _color(self, group: str, pressures: Array) -> Color:
        if self._tint is not None:
            return self._tint
        if group in MATERIAL_COLORS:
            return _rgb(MATERIAL_COLORS[group])
        channel = self.static_scene.channels.index(group.removeprefix("channel_"))
        share = float(pressures[channel] / self._limits[channel])
        return _rgb(pressure_color(round(share * COLOR_STEPS) / COLOR_STEPS))

    def _show_arrows(self, arrows: Array) -> None:
        self._arrows.visible = len(arrows) > 0
        if len(arrows):
            self._arrows.points = np.round(arrows, 3).astype(np.float32)

    def remove(self) -> None:
        """Remove all meshes."""
        self._root.remove()


def _groups(static_scene: StaticScene, skin: HandSkin) -> dict[str, list[str]]:
    """Names of the parts of each mesh: actuators of one channel, or other parts of one material."""
    found: dict[str, list[str]] = {}
    description = static_scene.layout.description
    for name, (material, _) in skin.parts(np.asarray(static_scene.layout.rest)).items():
        group = material
        if material == RUBBER_MATERIAL:
            group = f"channel_{static_scene.channels[description.channel_of(name)]}"
        found.setdefault(group, []).append(name)
    return found


def faces(mesh: Mesh) -> Triangles:
    """Corners (t, 3) of a mesh's triangles."""
    return np.asarray(mesh.indices, np.uint32).reshape(-1, 3)


def wxyz(quaternion: Array) -> Array:
    """A quaternion (x, y, z, w) in viser's order.

    >>> wxyz(np.array([0.0, 0.0, 0.0, 1.0])).tolist()
    [1.0, 0.0, 0.0, 0.0]
    """
    return np.roll(quaternion, 1)


def _rgb(color: tuple[float, ...]) -> Color:
    red, green, blue = (round(255 * part) for part in color[:3])
    return red, green, blue
