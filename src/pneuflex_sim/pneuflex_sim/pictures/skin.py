"""Smooth surface of a hand by linear blend skinning: the outline at rest, carried by the links.

A point of the surface moves to the weighted mean of the places to which the nearby links would
carry it (thesis 5.1.4). At rest this is exact. Where links turn against each other, blending
flattens the sections by about the cosine of half the angle: by 5 % where a finger of five segments
is bent by 180 deg.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pneuflex_sim.hand.kinematics import HandShape
from pneuflex_sim.scene.mesh import Mesh, box, mesh_of, tube, tube_triangles
from softhand_common.numerics.arrays import Array
from softhand_common.numerics.rotations import from_rpy
from softhand_model.chain.outline import ChainOutline, cross_section
from softhand_model.hand.hand import WRIST
from softhand_model.hand.palm_sheet import PalmSheet

Frames = tuple[Array, Array]  # origins (b, 3) [m] and rotation matrices (b, 3, 3)

TIP_ROUNDING = 0.4  # radius at the tip, as a share of height or width there
SKIN_ARCH_POINTS = 25
RUBBER_MATERIAL, SCAFFOLD_MATERIAL, SHEET_MATERIAL = "rubber", "scaffold", "sheet"  # materials


@dataclass(frozen=True)
class Fineness:
    """Resolution of a skin: rings per segment, rings around the tip, and points of
    `cross_section`.
    """

    rings: int
    tip_rings: int
    corner_points: int
    back_points: int


FINE_SKIN, COARSE_SKIN = Fineness(6, 5, 3, 11), Fineness(2, 2, 2, 5)


@dataclass(frozen=True)
class BoundSkin:
    """A surface bound to bones: weights (v, b), places (v, b, 3) [m] of the vertices in the bones'
    frames at rest, and triangles.
    """

    weights: Array
    places: Array
    indices: NDArray[np.int32]

    def vertices(self, frames: Frames) -> Array:
        """Places of the vertices (v, 3) [m] for the frames of all bones."""
        origin, rotation = frames
        moved = origin + np.einsum("bij,vbj->vbi", rotation, self.places)
        return np.asarray(np.einsum("vb,vbi->vi", self.weights, moved))

    def mesh(self, frames: Frames) -> Mesh:
        """The surface [m] for origins (b, 3) [m] and rotations (b, 3, 3) of the bones, which are
        the rigid parts of a finger.
        """
        return mesh_of(self.vertices(frames), self.indices)


def bind(rings: Array, along: Array, frames: Frames) -> BoundSkin:
    """Bind rings (r, k, 3) [m] to bones at rest; ring i lies at along[i] (r,), counted in bones."""
    origin, rotation = frames
    count, points = rings.shape[:2]
    vertices = np.vstack([rings.reshape(-1, 3), rings[0].mean(axis=0), rings[-1].mean(axis=0)])
    place = np.concatenate([np.repeat(along, points), along[[0, -1]]])
    local = np.einsum("bji,vbj->vbi", rotation, vertices[:, None] - origin)
    return BoundSkin(blend_weights(place, len(origin)), local, tube_triangles(count, points))


def blend_weights(place: Array, bones: int) -> Array:
    """Weights (v, bones) [-] of bones at 0, 1, ... on points at places (v,): quadratic B-splines,
    clamped so that both ends belong to their bones alone.

    With straight lines for weights a bent finger looks wavy: its line would touch that of the
    links in their middles and pass through the joints.

    >>> blend_weights(np.array([3.0]), 7).round(3).tolist()[0]
    [0.0, 0.0, 0.125, 0.75, 0.125, 0.0, 0.0]
    """
    from scipy.interpolate import BSpline  # here, as it takes long to load

    last, degree = bones - 1.0, min(2, bones - 1)
    inner = np.arange(1.5, last - 1.0) if degree == 2 else np.array([])
    knots = np.concatenate([np.zeros(degree + 1), inner, np.full(degree + 1, last)])
    inside = np.clip(place, 0.0, last)
    return np.asarray(BSpline.design_matrix(inside, knots, degree).toarray())


class HandSkin:
    """Surfaces of all parts of one hand, in the frame of the wrist."""

    def __init__(self, shape: HandShape, fineness: Fineness = FINE_SKIN) -> None:
        self.shape = shape
        self._rubber: dict[str, tuple[str, BoundSkin]] = {}
        self._struts: dict[str, BoundSkin] = {}
        rest = np.asarray(shape.layout.rest)
        links = shape.frames(rest)
        for chain in shape.layout.description.chains:
            outline = ChainOutline(chain, shape.layout.segments)
            bones = bone_frames(shape, chain.name, rest, links)
            for k, actuator in enumerate(chain.actuators):
                skin = bind(*rest_rings(outline, k, bones, fineness), bones)
                self._rubber[actuator] = (chain.name, skin)
            if chain.strut is not None:
                bones = strut_frames(shape, chain.name, rest, links)
                size = (chain.strut.thickness, chain.strut.width, chain.strut.length)
                self._struts[chain.name] = bind(*_strut_rings(size, bones, fineness), bones)
        self._fixed = _fixed_parts(shape)

    def actuator(self, name: str, q: Array) -> Mesh:
        """Surface of an actuator for the joint orientations `q` (n, 4)."""
        chain, skin = self._rubber[name]
        return skin.mesh(bone_frames(self.shape, chain, q, self.shape.frames(q)))

    def parts(self, q: Array) -> dict[str, tuple[str, Mesh]]:
        """Material and surface of every part by name: actuators, struts, plate and palm sheet."""
        links = self.shape.frames(q)
        rubber = {
            name: (RUBBER_MATERIAL, skin.mesh(bone_frames(self.shape, chain, q, links)))
            for name, (chain, skin) in self._rubber.items()
        }
        struts = {
            f"{name}_strut": (
                SCAFFOLD_MATERIAL,
                skin.mesh(strut_frames(self.shape, name, q, links)),
            )
            for name, skin in self._struts.items()
        }
        return rubber | struts | self._fixed

    def vertices(self, q: Array) -> dict[str, Array]:
        """Vertices (v, 3) [m] of every part, by name; takes a fifth of the time of `parts`."""
        links = self.shape.frames(q)
        rubber = {
            name: skin.vertices(bone_frames(self.shape, chain, q, links))
            for name, (chain, skin) in self._rubber.items()
        }
        struts = {
            f"{name}_strut": skin.vertices(strut_frames(self.shape, name, q, links))
            for name, skin in self._struts.items()
        }
        return rubber | struts | {name: mesh.vertices for name, (_, mesh) in self._fixed.items()}


def bone_frames(shape: HandShape, name: str, q: Array, links: tuple[Array, ...]) -> Frames:
    """Frames of a chain's bones (see `outline`) for the joint orientations `q` (n, 4); `links` is
    what `HandShape.frames` returns for them.
    """
    chain, joints = shape.layout.description.chain(name), shape.layout.chain_joints[name]
    first = joints.start + (chain.strut is not None)
    position, frame, _ = links
    before = frame[first] @ Rotation.from_quat(q[first]).as_matrix().T
    if chain.strut is None and chain.mount.parent != WRIST:
        before = before @ Rotation.from_quat(chain.mount.quaternion).as_matrix()
    own = slice(first, joints.stop)
    return (
        np.concatenate([position[first : first + 1], position[own]]),
        np.concatenate([before[None], frame[own]]),
    )


def strut_frames(shape: HandShape, name: str, q: Array, links: tuple[Array, ...]) -> Frames:
    """Frames of the mount and of the link of a chain's strut, both at the joint in the middle of
    the strut; `q` and `links` as in `bone_frames`.
    """
    joint = shape.layout.chain_joints[name].start
    position, frame, _ = links
    mount = frame[joint] @ Rotation.from_quat(q[joint]).as_matrix().T
    return np.repeat(position[joint][None], 2, axis=0), np.stack([mount, frame[joint]])


def rest_rings(
    outline: ChainOutline, actuator: int, bones: Frames, fineness: Fineness = FINE_SKIN
) -> tuple[Array, Array]:
    """Rings (r, k, 3) [m] of an actuator at rest from base to rounded tip, and where they lie (r,),
    counted in segments.
    """
    unit, rings = cross_section(fineness.corner_points, fineness.back_points), []
    rounding = TIP_ROUNDING * outline.extents(outline.length)[actuator].min()
    angle = np.linspace(0.0, 0.5 * np.pi, fineness.tip_rings + 1)
    body = np.linspace(0.0, outline.length, fineness.rings * outline.segments + 1)
    body = body[body < outline.length - 1.01 * rounding]
    places = np.append(body, outline.length - rounding * (1.0 - np.sin(angle)))
    insets = np.append(np.zeros(len(body)), rounding * (1.0 - np.cos(angle)))
    for place, lost in zip(places, insets, strict=True):
        flat = outline.outlines(place, unit)[actuator]
        height, width = outline.extents(place)[actuator]
        middle = np.array([-0.5 * height, outline.places[actuator]])
        flat = middle + (flat - middle) * (1.0 - 2.0 * lost / np.array([height, width]))
        bone = int(np.clip(place / outline.edge + 0.5, 0, outline.segments))
        point, axes = outline.section(bone, place)
        local = point + np.column_stack([flat, np.zeros(len(flat))]) @ axes.T
        rings.append(bones[0][bone] + local @ bones[1][bone].T)
    return np.array(rings), places / outline.edge


def _strut_rings(
    size: tuple[float, float, float], bones: Frames, fineness: Fineness
) -> tuple[Array, Array]:
    """Rings of a straight strut of thickness, width and length [m], and where they lie, from 0 to
    1.
    """
    along = np.linspace(0.0, 1.0, fineness.rings + 1)
    flat = cross_section(fineness.corner_points, fineness.back_points) * size[:2]
    rings = [
        np.column_stack([flat, np.full(len(flat), (share - 0.5) * size[2])]) for share in along
    ]
    return bones[0][0] + np.array(rings) @ bones[1][0].T, along


def _fixed_parts(shape: HandShape) -> dict[str, tuple[str, Mesh]]:
    """Plate and palm sheet; the sheet without load."""
    description, parts = shape.layout.description, {}
    if description.plate is not None:
        plate = description.plate
        parts["plate"] = (SCAFFOLD_MATERIAL, box(plate.size, np.array(plate.position)))
    if description.sheet is not None:
        parts["sheet"] = (SHEET_MATERIAL, sheet_mesh(description.sheet))
    return parts


def sheet_mesh(sheet: PalmSheet) -> Mesh:
    """Surface of a palm sheet in the frame of the wrist; its outer side is the one that touches."""
    arch, heading = (
        sheet.profile(SKIN_ARCH_POINTS),
        np.linspace(-0.5, 0.5, SKIN_ARCH_POINTS) * sheet.angle,
    )
    inner = arch - sheet.thickness * np.stack([np.cos(heading), np.sin(heading)], axis=1)
    half = 0.5 * sheet.width
    corners = ((arch, -half), (arch, half), (inner, half), (inner, -half))
    rings = [
        np.column_stack([line[:, 0], np.full(len(line), y), line[:, 1]]) for line, y in corners
    ]
    rotation = Rotation.from_quat(from_rpy(sheet.rpy)).as_matrix()
    return tube(np.stack(rings, axis=1)).moved(np.array(sheet.position), rotation)
