"""Pictures of states by PyBullet's software renderer, in a new world each, or where it is not
installed by `pneuflex_sim.pictures.painter`; needs no display.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from pneuflex_sim.bullet import is_installed, pybullet
from pneuflex_sim.hand.kinematics import HandShape
from pneuflex_sim.hand.layout import build_layout
from pneuflex_sim.pictures.object_surface import object_mesh
from pneuflex_sim.pictures.painter import paint
from pneuflex_sim.pictures.skin import RUBBER_MATERIAL, SCAFFOLD_MATERIAL, SHEET_MATERIAL, HandSkin
from pneuflex_sim.scene.mesh import Mesh, box
from pneuflex_sim.scene.objects import ObjectDescription, load_object
from pneuflex_sim.scene.scenes import SceneDescription, load_scene
from softhand_common.numerics.arrays import Array
from softhand_model.hand.hand import HandDescription, load_hand
from softhand_model.model_file import load_model

Color = tuple[float, float, float, float]  # red, green, blue, opacity

TABLE_HALF, WALL_HALF = (0.6, 0.6, 0.05), (0.15, 0.6, 0.01)  # half extents as drawn [m]

MATERIAL_COLORS = {
    RUBBER_MATERIAL: (0.93, 0.55, 0.25, 1),
    SCAFFOLD_MATERIAL: (0.35, 0.38, 0.45, 1),
    SHEET_MATERIAL: (0.95, 0.78, 0.55, 1),
}
OBJECT_COLOR, TABLE_COLOR = (0.25, 0.5, 0.75, 1), (0.86, 0.86, 0.83, 1)


@dataclass(frozen=True)
class HandState:
    """State shown in a picture: joint orientations (n, 4), and poses of wrist and object in the
    world.
    """

    joints: Array
    wrist_position: Array
    wrist_orientation: Array
    object_position: Array | None = None
    object_orientation: Array | None = None


@dataclass(frozen=True)
class Camera:
    """Camera of a picture: target point [m], distance [m], yaw and pitch [deg], vertical view angle
    [deg], direction towards the light.
    """

    target: tuple[float, float, float] = (0.0, 0.0, 0.08)
    distance: float = 0.55
    yaw: float = 35.0
    pitch: float = -18.0
    view_angle: float = 40.0
    light: tuple[float, float, float] = (0.6, -0.8, 1.6)


class Renderer:
    """Draws one hand (and object, and scene) in given states.

    `colors` overrides the colour of the material for parts by their names in `HandSkin.parts`.
    """

    def __init__(
        self,
        hand: str | HandDescription,
        object_name: str | None = None,
        scene: str | SceneDescription = "table",
        segments: int = 5,
        colors: Mapping[str, Color] | None = None,
    ) -> None:
        description = load_hand(hand) if isinstance(hand, str) else hand
        self.layout = build_layout(description, segments, load_model(None))
        self.skin = HandSkin(HandShape(self.layout))
        self.object = load_object(object_name) if object_name else None
        self.scene = scene if isinstance(scene, SceneDescription) else load_scene(scene)
        self.colors = dict(colors or {})

    def frame(
        self, state: HandState, size: tuple[int, int] = (640, 480), camera: Camera | None = None
    ) -> NDArray[np.uint8]:
        """Picture (height, width, 3) of a state; `size` is (width, height) [pixels], `camera` None
        is `Camera()`.
        """
        if not is_installed():
            return self._paint(state, camera or Camera(), size)
        client = pybullet.connect(pybullet.DIRECT)
        try:
            self._draw(state, client)
            return photograph(camera or Camera(), size, client)
        finally:
            pybullet.disconnect(client)

    def _paint(self, state: HandState, camera: Camera, size: tuple[int, int]) -> NDArray[np.uint8]:
        boxes = surroundings(self.scene).values()
        behind = [
            (_placed(box(2.0 * np.array(half), np.zeros(3)), place, turn), TABLE_COLOR)
            for half, place, turn in boxes
        ]
        wrist = state.wrist_position, state.wrist_orientation
        before = [
            (_placed(mesh, *wrist), self.colors.get(name, MATERIAL_COLORS[material]))
            for name, (material, mesh) in self.skin.parts(state.joints).items()
        ]
        place, turn = state.object_position, state.object_orientation
        if self.object is not None and place is not None and turn is not None:
            before.append((_placed(object_mesh(self.object), place, turn), OBJECT_COLOR))
        return paint(behind, before, camera, size)

    def _draw(self, state: HandState, client: int) -> None:
        for shown in surroundings(self.scene).values():
            draw_box(*shown, TABLE_COLOR, client)
        wrist = state.wrist_position.tolist(), state.wrist_orientation.tolist()
        for name, (material, mesh) in self.skin.parts(state.joints).items():
            draw_mesh(mesh, *wrist, self.colors.get(name, MATERIAL_COLORS[material]), client)
        place, turn = state.object_position, state.object_orientation
        if self.object is not None and place is not None and turn is not None:
            draw_object(self.object, place.tolist(), turn.tolist(), client)


def _placed(mesh: Mesh, position: ArrayLike, orientation: ArrayLike) -> Array:
    """Corners (t, 3, 3) [m] in the world of a mesh at a pose."""
    turned = mesh.moved(np.asarray(position), Rotation.from_quat(orientation).as_matrix())
    return turned.corners


def draw_mesh(
    mesh: Mesh, position: list[float], orientation: list[float], color: tuple, client: int
) -> None:
    """Draw a mesh at a position (3,) [m] and quaternion (4,)."""
    visual = pybullet.createVisualShape(
        pybullet.GEOM_MESH,
        vertices=mesh.vertices.tolist(),
        indices=mesh.indices.tolist(),
        normals=mesh.normals.tolist(),
        rgbaColor=color,
        physicsClientId=client,
    )
    pybullet.createMultiBody(0, -1, visual, position, orientation, physicsClientId=client)


def draw_box(half: tuple, position: tuple, orientation: tuple, color: tuple, client: int) -> None:
    """Draw a box of half extents (3,) [m] at a position (3,) [m] and quaternion (4,)."""
    visual = pybullet.createVisualShape(
        pybullet.GEOM_BOX, halfExtents=half, rgbaColor=color, physicsClientId=client
    )
    pybullet.createMultiBody(0, -1, visual, position, orientation, physicsClientId=client)


def surroundings(scene: SceneDescription) -> dict[str, tuple[tuple, tuple, tuple]]:
    """The boxes that show table and wall, by name: half extents (3,) [m], middle (3,) [m] and
    quaternion (4,).
    """
    found = {}
    if scene.table is not None:
        middle = 0.0 if scene.table.edge is None else scene.table.edge + TABLE_HALF[0]
        found["table"] = (TABLE_HALF, (middle, 0, -TABLE_HALF[2]), (0, 0, 0, 1))
    if scene.wall is not None:
        slope = Rotation.from_euler("y", -scene.wall.inclination, degrees=True)
        middle = slope.apply((WALL_HALF[0], 0, -WALL_HALF[2])) + (scene.wall.distance, 0, 0)
        found["wall"] = (WALL_HALF, tuple(middle), tuple(slope.as_quat()))
    return found


def draw_object(
    description: ObjectDescription, position: list[float], orientation: list[float], client: int
) -> None:
    """Draw an object at a position (3,) [m] and quaternion (4,); a sheet as if it were flat."""
    surface = description.geometry.surface
    if surface is not None:
        draw_mesh(surface, position, orientation, OBJECT_COLOR, client)
        return
    half = description.half_extents
    if description.shape in ("box", "sheet"):
        draw_box(half, tuple(position), tuple(orientation), OBJECT_COLOR, client)
        return
    kind = {"radius": half[0], "shapeType": pybullet.GEOM_SPHERE}
    if description.shape == "cylinder":
        kind = {"radius": half[0], "length": 2 * half[2], "shapeType": pybullet.GEOM_CYLINDER}
    visual = pybullet.createVisualShape(rgbaColor=OBJECT_COLOR, physicsClientId=client, **kind)
    pybullet.createMultiBody(0, -1, visual, position, orientation, physicsClientId=client)


def photograph(camera: Camera, size: tuple[int, int], client: int) -> NDArray[np.uint8]:
    """Picture (height, width, 3) of all that has been drawn; `size` is (width, height) [pixels]."""
    width, height = size
    view = pybullet.computeViewMatrixFromYawPitchRoll(
        camera.target, camera.distance, camera.yaw, camera.pitch, 0, 2
    )
    projection = pybullet.computeProjectionMatrixFOV(camera.view_angle, width / height, 0.02, 5.0)
    image = pybullet.getCameraImage(
        width,
        height,
        view,
        projection,
        lightDirection=camera.light,
        shadow=1,
        lightAmbientCoeff=0.55,
        lightDiffuseCoeff=0.5,
        lightSpecularCoeff=0.1,
        renderer=pybullet.ER_TINY_RENDERER,
        physicsClientId=client,
    )
    return np.reshape(image[2], (height, width, 4))[:, :, :3].astype(np.uint8)
