"""A hand with object and surroundings in the browser: few triangles, a mesh a channel."""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray

from pneuflex_sim.hand.kinematics import HandShape
from pneuflex_sim.pictures.render import COLORS, OBJECT, TABLE, HandState, surroundings
from pneuflex_sim.pictures.skin import COARSE, RUBBER, HandSkin
from pneuflex_sim.pictures.surfaces import object_mesh, pressure_color
from pneuflex_sim.scene.mesh import Mesh, creased, merged
from softhand_play.shots import Shot, Stage

Array = NDArray[np.float64]
Triangles = NDArray[np.uint32]
Color = tuple[int, int, int]

FORCE = (40, 160, 60)
SHAFT, HEAD, HEAD_LENGTH = 0.0015, 0.004, 0.008  # of an arrow [m]
DIGITS = 4  # of metres and quaternions that are sent: of what stands still, nothing is
TRANSLUCENT = 0.45  # opacity
COLOR_STEPS = 32  # a colour is sent when it changes by one of them


class HandView:
    """The meshes of one stage below a name in the scene tree.

    tint: one colour for all rubber, which is then translucent and stands alone, in place of that
    of the pressure.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        stage: Stage,
        name: str = "/hand",
        tint: Color | None = None,
    ) -> None:
        self.stage, self._scene, self._name, self._tint = stage, server.scene, name, tint
        self._atomic = server.atomic
        self._skin = HandSkin(HandShape(stage.layout), COARSE)
        self._groups = _groups(stage, self._skin)
        self._limits = stage.layout.description.max_pressures()
        self._root = self._scene.add_frame(name, show_axes=False)
        self._wrist = self._scene.add_frame(f"{name}/wrist", show_axes=False)
        self._colors = {group: self._color(group, 0.0 * self._limits) for group in self._groups}
        parts = {name: mesh for name, (_, mesh) in self._skin.parts(stage.layout.rest).items()}
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
            FORCE,
            shaft_radius=SHAFT,
            head_radius=HEAD,
            head_length=HEAD_LENGTH,
            visible=False,
        )

    def _surround(self) -> None:
        """Table, wall and object."""
        for part, (half, place, turn) in surroundings(self.stage.scene).items():
            self._scene.add_box(
                f"{self._name}/{part}",
                dimensions=2.0 * np.array(half),
                color=_rgb(TABLE),
                position=place,
                wxyz=wxyz(np.array(turn)),
                cast_shadow=False,
                receive_shadow=False,
            )
        if self.stage.object is not None:
            mesh = creased(object_mesh(self.stage.object))
            self._object = self._mesh("object", mesh, _rgb(OBJECT))

    def _mesh(self, name: str, mesh: Mesh, color: Color) -> viser.MeshHandle:
        return self._scene.add_mesh_simple(
            f"{self._name}/{name}",
            mesh.vertices,
            faces(mesh),
            color=color,
            opacity=None if self._tint is None else TRANSLUCENT,
            side="double",
            cast_shadow=False,  # costs more than all else
            receive_shadow=False,
        )

    def show(self, shot: Shot) -> None:
        """Show an instant."""
        self.move(shot.state, shot.pressures)
        self._show_arrows(shot.arrows)

    def move(self, state: HandState, pressures: Array) -> None:
        """Show a state, coloured by gauge pressures (channels,) [Pa]."""
        parts = self._skin.vertices(state.joints)
        with self._atomic():
            self._wrist.position = np.round(state.wrist_position, DIGITS)
            self._wrist.wxyz = wxyz(np.round(state.wrist_orientation, DIGITS))
            for group, names in self._groups.items():
                vertices = np.vstack([parts[name] for name in names])
                self._show_group(group, vertices, pressures)
            pose = state.object_position, state.object_orientation
            if self._object is not None and pose[0] is not None and pose[1] is not None:
                self._object.position = np.round(pose[0], DIGITS)
                self._object.wxyz = wxyz(np.round(pose[1], DIGITS))

    def _show_group(self, group: str, vertices: Array, pressures: Array) -> None:
        color, handle = self._color(group, pressures), self._parts[group]
        handle.vertices = np.round(vertices, DIGITS).astype(np.float32)
        if self._colors[group] != color:
            self._colors[group] = handle.color = color

    def _color(self, group: str, pressures: Array) -> Color:
        if self._tint is not None:
            return self._tint
        if group in COLORS:
            return _rgb(COLORS[group])
        channel = self.stage.channels.index(group.removeprefix("channel_"))
        share = float(pressures[channel] / self._limits[channel])
        return _rgb(pressure_color(round(share * COLOR_STEPS) / COLOR_STEPS))

    def _show_arrows(self, arrows: Array) -> None:
        self._arrows.visible = len(arrows) > 0
        if len(arrows):
            self._arrows.points = np.round(arrows, 3).astype(np.float32)

    def remove(self) -> None:
        """Take everything away."""
        self._root.remove()


def _groups(stage: Stage, skin: HandSkin) -> dict[str, list[str]]:
    """Names of the parts that make one mesh: the actuators of a channel, and what is of a
    material.
    """
    found: dict[str, list[str]] = {}
    description = stage.layout.description
    for name, (material, _) in skin.parts(np.asarray(stage.layout.rest)).items():
        group = material
        if material == RUBBER:
            group = f"channel_{stage.channels[description.channel_of(name)]}"
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
