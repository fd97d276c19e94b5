"""A hand on its wrist with object and scene as one MJCF document, from the same layout, scene and
friction as the bodies in PyBullet.

Links have the rotary inertia of their boxes, without what PyBullet needs on top. The wrist is a
free body of the arm's mass and inertia; the arm's push and the springs of the joints are set in
every step. A joint of equal stiffness about all axes is a ball joint; any other is three hinges,
about y (bending) first, then x and z. Hulls are eroded by COLLISION_MARGIN and dilated again by
MuJoCo's margins, which add up. Friction of object and scene is given by pairs of geoms.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from xml.etree import ElementTree as xml

import numpy as np

from pneuflex_sim.engines.contract import Surroundings
from pneuflex_sim.engines.mujoco.mjcf import Element, add, hull, put, touching, wxyz
from pneuflex_sim.engines.mujoco.things import add_object, add_scene
from pneuflex_sim.hand.collision import BOXES, PALM_GROUP, collides_with, collision_groups
from pneuflex_sim.hand.layout import Body
from pneuflex_sim.hand.palm_pad import PalmPad, pad_vertices
from pneuflex_sim.scene.friction import RUBBER_MATERIAL
from softhand_common.numerics.arrays import Array
from softhand_common.numerics.rotations import compose, from_rpy, rotate
from softhand_model.chain.hulls import COLLISION_MARGIN, collision_hulls
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_model.hand.joint_stiffness import DAMPING_TIME

WRIST, PALM_PAD, PLATE_OF_PALM = "wrist", "palm_plate", "plate"
HINGES = {"y": (0.0, 1.0, 0.0), "x": (1.0, 0.0, 0.0), "z": (0.0, 0.0, 1.0)}
IMPEDANCE_RATIO = 1000.0  # of friction over normal; so what is held creeps by 0.1 mm a second
PAD_DENSITY = 1070.0  # [kg/m3] of the palm sheet


def document(around: Surroundings) -> str:
    """The MJCF document; joints are called `<link>` (ball) or `<link>_y`, `_x`, `_z`, geoms
    `<link>`, `palm_plate`, `plate`, `table`, `wall`, and `object_<k>`.

    Raises ValueError for what MuJoCo does not simulate here, and for a pair of materials that the
    table of friction does not have.
    """
    root = xml.Element("mujoco", model=around.layout.description.name)
    add(root, "compiler", angle="radian")
    _options(root, around)
    assets, world = add(root, "asset"), add(root, "worldbody")
    contact = add(root, "contact")
    add_scene(world, around)
    add_object(world, assets, contact, around)
    wrist = _wrist(world, around)
    for body in around.layout.bodies:
        _chain(wrist, assets, around, body)
        _part_links(contact, around.layout.names[body.joints])
    _palm(wrist, assets, around)
    return xml.tostring(root, encoding="unicode")


def _options(root: Element, around: Surroundings) -> None:
    gravity = (0.0, 0.0, -STANDARD_GRAVITY * around.weight_scale)
    option = add(root, "option", timestep=around.step, gravity=gravity)
    put(option, integrator="discrete", cone="elliptic", impratio=IMPEDANCE_RATIO)
    add(option, "flag", autoreset="disable")


def _wrist(world: Element, around: Surroundings) -> Element:
    """A free body without weight, or one that is fixed."""
    scene, arm = around.scene, around.wrist.parameters
    orientation = wxyz(from_rpy(scene.wrist_rpy))
    body = add(world, "body", name=WRIST, pos=scene.wrist_position, quat=orientation)
    if not scene.rigid_wrist:
        put(body, gravcomp=1)
        add(body, "freejoint", name=WRIST)
        inertia = (arm.inertia,) * 3
        add(body, "inertial", pos=(0.0, 0.0, 0.0), mass=arm.mass, diaginertia=inertia)
    return body


def _chain(wrist: Element, assets: Element, around: Surroundings, body: Body) -> None:
    """One serial body of the layout, link in link."""
    layout = around.layout
    friction = around.friction.pair(RUBBER_MATERIAL, RUBBER_MATERIAL)
    parent, groups = wrist, collision_groups(layout, body)
    hulls = [
        corners
        for name in body.chains
        for corners in collision_hulls(layout.models[name].description, layout.segments)
    ]
    inertia = layout.inertia(0.0)
    for index, joint in enumerate(range(body.joints.start, body.joints.stop)):
        place, orientation = layout.offset[joint], layout.rest[joint]
        if index == 0:
            place = body.position + rotate(body.orientation, place)
            orientation = compose(body.orientation, orientation)
        name = layout.names[joint]
        parent = add(parent, "body", name=name, pos=place, quat=wxyz(orientation))
        _joint(parent, name, layout.stiffness[joint], layout.damping_time)
        center, moments = layout.center[joint], inertia[joint]
        add(parent, "inertial", pos=center, mass=layout.mass[joint], diaginertia=moments)
        if around.collision == BOXES:
            half = layout.size[joint] / 2
            geom = add(parent, "geom", name=name, type="box", size=half, pos=center)
        else:
            geom = hull(parent, assets, name, hulls[index], COLLISION_MARGIN)
        touching(geom, friction, groups[index], collides_with(groups[index], around.finger_contact))


def _part_links(contact: Element, links: Sequence[str]) -> None:
    """Links of one serial body do not collide with each other, as in PyBullet."""
    for first, second in combinations(links, 2):
        add(contact, "exclude", body1=first, body2=second)


def _joint(link: Element, name: str, stiffness: Array, damping_time: float) -> None:
    """A ball joint, or three hinges where the axes differ."""
    if np.ptp(stiffness) == 0.0:
        add(link, "joint", name=name, type="ball", **_spring(stiffness[0], damping_time))
        return
    for axis, direction in HINGES.items():
        value = stiffness["xyz".index(axis)]
        add(link, "joint", name=f"{name}_{axis}", axis=direction, **_spring(value, damping_time))


def _spring(stiffness: float, damping_time: float) -> dict[str, float]:
    return {"stiffness": stiffness, "damping": damping_time * stiffness}


def _palm(wrist: Element, assets: Element, around: Surroundings) -> None:
    """The plate, which is part of the wrist, and the sheet, which sinks along the normal of its
    crown.
    """
    hand = around.layout.description
    friction = around.friction.pair(RUBBER_MATERIAL, RUBBER_MATERIAL)
    if hand.plate is not None:
        half = 0.5 * np.array(hand.plate.size)
        plate = add(
            wrist, "geom", name=PLATE_OF_PALM, type="box", size=half, pos=hand.plate.position
        )
        touching(plate, friction, PALM_GROUP, collides_with(PALM_GROUP))
        put(plate, mass=0)
    if hand.sheet is None:
        return
    pad, sheet = PalmPad(hand.sheet), hand.sheet
    body = add(wrist, "body", name=PALM_PAD, pos=pad.spring.place, quat=wxyz(pad.orientation))
    if not around.scene.rigid_wrist:
        mass, stiffness = PAD_DENSITY * sheet.length * sheet.width * sheet.thickness, pad.spring[0]
        put(body, gravcomp=1)
        axis = (1.0, 0.0, 0.0)
        add(
            body,
            "joint",
            name=PALM_PAD,
            type="slide",
            axis=axis,
            **_spring(stiffness, DAMPING_TIME),
        )
        add(body, "inertial", pos=(0.0, 0.0, 0.0), mass=mass, diaginertia=(1e-5,) * 3)
    geom = hull(body, assets, PALM_PAD, pad_vertices(sheet, COLLISION_MARGIN), COLLISION_MARGIN)
    touching(geom, friction, PALM_GROUP, collides_with(PALM_GROUP))
