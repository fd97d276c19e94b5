"""A hand, its wrist, its object and its table as a MuJoCo model (MJCF), from the same layout as the
bodies in PyBullet.

Links, masses, springs, damping and collision hulls are those of `pneuflex_sim.hand.layout`; links
have the rotary inertia of their boxes, without what PyBullet needs on top. A joint of equal
stiffness about all axes is a ball joint, whose spring follows the pressure (`mujoco_simulation`);
any other is three hinges. Hulls are eroded by COLLISION_MARGIN and inflated again by MuJoCo's
margin. Collision groups and friction of pairs are as in PyBullet.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from xml.etree import ElementTree as xml

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pneuflex_sim.hand.collision import (
    COLLISION_MARGIN,
    ENVIRONMENT_GROUP,
    PALM_GROUP,
    collides_with,
    collision_groups,
    collision_hulls,
)
from pneuflex_sim.hand.kinematics import HandShape
from pneuflex_sim.hand.layout import DAMPING_TIME, Body, HandLayout
from pneuflex_sim.hand.palm_pad import PalmPad, pad_vertices
from pneuflex_sim.hand.wrist import WristParameters
from pneuflex_sim.scene.friction import RUBBER_MATERIAL, FrictionTable, load_friction
from pneuflex_sim.scene.objects import ObjectDescription
from pneuflex_sim.scene.scenes import SceneDescription
from pneuflex_sim.simulation import SimulationConfig
from softhand_common.numerics.rotations import compose, from_rpy, rotate
from softhand_model.effects.load import STANDARD_GRAVITY

Array = NDArray[np.float64]

TABLE, OBJECT, WRIST, PAD = "table", "object", "wrist", "palm_plate"
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
CARRIER_MASS = 1e-3  # [kg] of the body at which the arm carries the hand's weight
PAD_DENSITY = 1070.0  # [kg/m3] of the palm sheet
BITS = 0x7FFFFFFF  # of MuJoCo's masks, whose numbers have a sign


@dataclass(frozen=True)
class Settings:
    """What a user of MuJoCo chooses: integrator, friction cone, and ratio of frictional to normal
    impedance, without which what is held creeps out of the hand. All else is MuJoCo's default.
    """

    integrator: str = "discrete"
    cone: str = "elliptic"
    impedance_ratio: float = 10.0


def model_text(
    layout: HandLayout,
    scene: SceneDescription,
    described: ObjectDescription | None,
    config: SimulationConfig,
    settings: Settings,
) -> str:
    """The MJCF document of a hand in a scene with an endless table or none, with a cylinder or no
    object; joints are called `<link>` (ball) or `<link>_x`, `_y`, `_z`.

    Raises ValueError for another object.
    """
    root, friction = xml.Element("mujoco", model=layout.description.name), load_friction()
    _add(root, "compiler", angle="radian")
    _options(root, config.step, settings)
    assets, world = _add(root, "asset"), _add(root, "worldbody")
    if scene.table is not None:
        _table(world, friction.pair(scene.table.material, RUBBER_MATERIAL))
    if described is not None:
        _object(world, described, friction.pair(described.material, RUBBER_MATERIAL), config)
    hand = _wrist(world, root, scene, config.wrist)
    if not scene.rigid_wrist:
        _carrier(hand, layout)
    for body in layout.bodies:
        _chain(hand, assets, layout, body, friction)
    if layout.description.sheet is not None:
        pad = PalmPad(layout.description.sheet)
        _pad(hand, assets, pad, scene.rigid_wrist, friction.pair(RUBBER_MATERIAL, RUBBER_MATERIAL))
    if described is not None and scene.table is not None:
        pair = _add(_add(root, "contact"), "pair", geom1=OBJECT, geom2=TABLE)
        sliding = friction.pair(scene.table.material, described.material)
        _set(pair, friction=(sliding, sliding, 0.005, 1e-4, 1e-4))
    return xml.tostring(root, encoding="unicode")


def _add(parent: xml.Element, tag: str, **attributes: object) -> xml.Element:
    child = xml.SubElement(parent, tag)
    _set(child, **attributes)
    return child


def _set(element: xml.Element, **attributes: object) -> None:
    for key, value in attributes.items():
        element.set(key, _text(value))


def _text(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str | int):
        return str(value)
    return " ".join(repr(float(number)) for number in np.ravel(value))


def _wxyz(quaternion: ArrayLike) -> Array:
    return np.roll(quaternion, 1)


def _options(root: xml.Element, step: float, settings: Settings) -> None:
    option = _add(root, "option", timestep=step, gravity=(0.0, 0.0, -STANDARD_GRAVITY))
    _set(option, integrator=settings.integrator, cone=settings.cone)
    _set(option, impratio=settings.impedance_ratio)


def _table(world: xml.Element, friction: float) -> None:
    """A plane; by its priority, its friction with rubber counts."""
    table = _add(world, "geom", name=TABLE, type="plane", size=(1.0, 1.0, 0.1), priority=1)
    _touch(table, friction, ENVIRONMENT_GROUP, ENVIRONMENT_GROUP)


def _touch(geom: xml.Element, friction: float, group: int, others: int) -> None:
    """Friction, and which groups it touches; the rest is MuJoCo's default."""
    _set(geom, friction=(friction, 0.005, 1e-4), contype=group, conaffinity=others & BITS)


def _object(
    world: xml.Element, described: ObjectDescription, friction: float, config: SimulationConfig
) -> None:
    if described.shape != "cylinder":
        raise ValueError(f"object: expected a cylinder, got a {described.shape}")
    place = np.array([0.0, 0.0, described.rest_height])
    place[: len(config.object_offset)] += config.object_offset
    orientation = _wxyz(from_rpy(described.rpy))
    body = _add(world, "body", name=OBJECT, pos=place, quat=orientation)
    _add(body, "freejoint", name=OBJECT)
    half, mass = described.half_extents, described.mass * config.object_mass_scale
    size = (half[0], half[2])
    geom = _add(body, "geom", name=OBJECT, type="cylinder", size=size, mass=mass, priority=1)
    _touch(geom, friction, ENVIRONMENT_GROUP, ENVIRONMENT_GROUP)


def _wrist(
    world: xml.Element, root: xml.Element, scene: SceneDescription, wrist: WristParameters
) -> xml.Element:
    """The wrist on three slides along the axes of the world and a ball joint, with servos as stiff,
    damped and strong as the simulator's arm (each axis by itself); without weight.
    """
    orientation = from_rpy(scene.wrist_rpy)
    body = _add(world, "body", name=WRIST, pos=scene.wrist_position, quat=_wxyz(orientation))
    if scene.rigid_wrist:
        return body
    _set(body, gravcomp=1)
    actuator = _add(root, "actuator")
    back = orientation * [-1.0, -1.0, -1.0, 1.0]
    for name, axis in AXES.items():
        joint = f"{WRIST}_{name}"
        _add(body, "joint", name=joint, type="slide", axis=rotate(back, axis))
        _servo(actuator, joint, (1.0,), wrist.stiffness, wrist.mass, wrist.force_limit)
    _add(body, "joint", name=WRIST, type="ball")
    for axis in AXES.values():
        gear = (*axis, 0.0, 0.0, 0.0)
        stiffness = wrist.rotational_stiffness
        _servo(actuator, WRIST, gear, stiffness, wrist.inertia, wrist.torque_limit)
    inertia = (wrist.inertia,) * 3
    _add(body, "inertial", pos=(0.0, 0.0, 0.0), mass=wrist.mass, diaginertia=inertia)
    return body


def _servo(
    actuator: xml.Element,
    joint: str,
    gear: tuple[float, ...],
    stiffness: float,
    inertia: float,
    limit: float,
) -> None:
    """A critically damped servo of limited force."""
    damping = 2.0 * math.sqrt(stiffness * inertia)
    servo = _add(actuator, "position", joint=joint, gear=gear, kp=stiffness, kv=damping)
    _set(servo, forcerange=(-limit, limit))


def _carrier(hand: xml.Element, layout: HandLayout) -> None:
    """A force that compensates the weight of the resting hand, as the simulator's arm does."""
    place = HandShape(layout).center_of_mass(layout.rest)
    share = 1.0 + float(layout.mass.sum()) / CARRIER_MASS
    body = _add(hand, "body", name="carrier", pos=place, gravcomp=share)
    inertia = (1e-9,) * 3
    _add(body, "inertial", pos=(0.0, 0.0, 0.0), mass=CARRIER_MASS, diaginertia=inertia)


def _chain(
    hand: xml.Element, assets: xml.Element, layout: HandLayout, body: Body, friction: FrictionTable
) -> None:
    """One serial body of the layout, link in link."""
    parent, groups = hand, collision_groups(layout, body)
    hulls = [
        hull
        for name in body.chains
        for hull in collision_hulls(layout.models[name].description, layout.segments)
    ]
    for index, joint in enumerate(range(body.joints.start, body.joints.stop)):
        place, orientation = layout.offset[joint], layout.rest[joint]
        if index == 0:
            place = body.position + rotate(body.orientation, place)
            orientation = compose(body.orientation, orientation)
        name = layout.names[joint]
        parent = _add(parent, "body", name=name, pos=place, quat=_wxyz(orientation))
        _spring(parent, name, layout.stiffness[joint])
        inertia = layout.inertia(0.0)[joint]
        inertial = _add(parent, "inertial", pos=layout.center[joint], diaginertia=inertia)
        _set(inertial, mass=layout.mass[joint])
        geom = _hull(parent, assets, name, hulls[index])
        group = groups[index]
        _touch(geom, friction.pair(RUBBER_MATERIAL, RUBBER_MATERIAL), group, collides_with(group))


def _spring(link: xml.Element, name: str, stiffness: Array) -> None:
    """A ball joint, or three hinges where the axes differ."""
    if np.ptp(stiffness) == 0.0:
        _add(link, "joint", name=name, type="ball", **_springs(stiffness[0]))
        return
    for (axis, direction), value in zip(AXES.items(), stiffness, strict=True):
        _add(link, "joint", name=f"{name}_{axis}", axis=direction, **_springs(value))


def _springs(stiffness: float) -> dict[str, float]:
    return {"stiffness": stiffness, "damping": DAMPING_TIME * stiffness}


def _hull(link: xml.Element, assets: xml.Element, name: str, corners: Array) -> xml.Element:
    """Convex hull of corners (k, 3) [m], inflated by COLLISION_MARGIN."""
    _add(assets, "mesh", name=name, vertex=corners, inertia="convex")
    return _add(link, "geom", name=name, type="mesh", mesh=name, margin=COLLISION_MARGIN)


def _pad(
    hand: xml.Element, assets: xml.Element, pad: PalmPad, rigid: bool, friction: float
) -> None:
    """The palm sheet, which sinks along the normal of its crown."""
    sheet = pad.sheet
    body = _add(hand, "body", name=PAD, pos=pad.spring.place, quat=_wxyz(pad.orientation))
    if not rigid:
        mass = PAD_DENSITY * sheet.length * sheet.width * sheet.thickness
        _set(body, gravcomp=1)
        _add(
            body,
            "joint",
            name=PAD,
            type="slide",
            axis=(1.0, 0.0, 0.0),
            **_springs(pad.spring.stiffness),
        )
        _add(body, "inertial", pos=(0.0, 0.0, 0.0), mass=mass, diaginertia=(1e-5,) * 3)
    geom = _hull(body, assets, PAD, pad_vertices(sheet, COLLISION_MARGIN))
    _touch(geom, friction, PALM_GROUP, collides_with(PALM_GROUP))
