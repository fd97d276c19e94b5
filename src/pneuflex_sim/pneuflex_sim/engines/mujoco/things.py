"""Object and scene in MuJoCo: their geoms, and the friction of each pair.

The hand touches with rubber, so what it touches brings the coefficient of their pair (by MuJoCo's
priority of geoms). Object and scene touch in pairs of geoms of their own.
"""

from __future__ import annotations

import numpy as np

from pneuflex_sim.engines.contract import Surroundings
from pneuflex_sim.engines.mujoco.mjcf import Element, add, hull, put, touching, wxyz
from pneuflex_sim.hand.collision import ENVIRONMENT_GROUP
from pneuflex_sim.scene.contacts import OBJECT
from pneuflex_sim.scene.friction import RUBBER_MATERIAL
from pneuflex_sim.scene.object_body import SHEET_SIDES, Sheet
from pneuflex_sim.scene.objects import ObjectDescription
from pneuflex_sim.scene.scenes import TABLE_SIZE, Table, Wall
from softhand_model.chain.hulls import COLLISION_MARGIN

OF_TABLE, OF_WALL = "table", "wall"  # names of geoms
PLANE_SIZE = (1.0, 1.0, 0.1)  # drawn; it has no end


def add_scene(world: Element, around: Surroundings) -> None:
    """Table and wall."""
    scene = around.scene
    if scene.table is not None:
        _touched_by_hand(_table(world, scene.table), around, scene.table.material)
    if scene.wall is not None:
        _touched_by_hand(_wall(world, scene.wall), around, scene.wall.material)


def _touched_by_hand(geom: Element, around: Surroundings, material: str) -> None:
    """The hand's geoms look for it; it looks for nothing itself."""
    put(geom, priority=1)
    touching(geom, around.friction.pair(material, RUBBER_MATERIAL), ENVIRONMENT_GROUP, 0)


def _table(world: Element, table: Table) -> Element:
    if table.edge is None:
        return add(world, "geom", name=OF_TABLE, type="plane", size=PLANE_SIZE)
    size = np.array(TABLE_SIZE)
    place = (table.edge + size[0] / 2, 0.0, -size[2] / 2)
    return add(world, "geom", name=OF_TABLE, type="box", size=size / 2, pos=place)


def _wall(world: Element, wall: Wall) -> Element:
    place = (wall.distance, 0.0, 0.0)
    return add(
        world, "geom", name=OF_WALL, type="plane", size=PLANE_SIZE, pos=place, zaxis=wall.normal
    )


def add_object(world: Element, assets: Element, contact: Element, around: Surroundings) -> None:
    """The object as a free body with a mass of its own, and its pairs with the scene.

    Raises ValueError for an object that MuJoCo does not simulate here.
    """
    described = around.object
    if described is None:
        return
    body = add(world, "body", name=OBJECT)
    add(body, "freejoint", name=OBJECT)
    if described.shape == "sheet":
        geoms = _strips(body, Sheet(described.dimensions), described.mass)
    else:
        geoms = _rigid(body, assets, described)
    for geom in geoms:
        _touched_by_hand(geom, around, described.material)
        _pairs_with_scene(contact, geom, around, described)


def _rigid(body: Element, assets: Element, described: ObjectDescription) -> list[Element]:
    solid = described.geometry.solid
    moments, axes = solid.principal()
    inertial = add(body, "inertial", pos=(0.0, 0.0, 0.0), quat=wxyz(axes))
    put(inertial, mass=described.mass, diaginertia=described.mass * moments)
    if described.geometry.pieces:
        return [
            hull(body, assets, f"{OBJECT}_{k}", piece, COLLISION_MARGIN)
            for k, piece in enumerate(described.geometry.pieces)
        ]
    half = described.half_extents
    size = {"box": half, "cylinder": (half[0], half[2]), "sphere": half[:1]}[described.shape]
    return [add(body, "geom", name=f"{OBJECT}_0", type=described.shape, size=size)]


def _strips(base: Element, sheet: Sheet, mass: float) -> list[Element]:
    """Strips on hinges that resist by their friction; a chain of them on either side."""
    share, count = mass / sheet.strips, sheet.strips // 2
    geoms = [_strip(base, 0, sheet, share)]
    for side in SHEET_SIDES:
        parent = base
        for k in range(count):
            place = (side * sheet.pitch * (0.5 if k == 0 else 1.0), 0.0, 0.0)
            number = len(geoms)
            parent = add(parent, "body", name=f"{OBJECT}_{number}", pos=place)
            joint = add(parent, "joint", name=f"{OBJECT}_{number}", axis=(0.0, 1.0, 0.0))
            put(joint, frictionloss=sheet.friction)
            geoms.append(_strip(parent, side, sheet, share))
    for number, geom in enumerate(geoms):
        put(geom, name=f"{OBJECT}_{number}")
    return geoms


def _strip(body: Element, side: int, sheet: Sheet, mass: float) -> Element:
    middle = (0.5 * side * sheet.pitch, 0.0, 0.0)
    add(body, "inertial", pos=middle, mass=mass, diaginertia=mass * sheet.strip_moments)
    return add(body, "geom", type="box", size=sheet.size / 2, pos=middle)


def _pairs_with_scene(
    contact: Element, geom: Element, around: Surroundings, described: ObjectDescription
) -> None:
    """Contacts of a geom of the object with table and wall, which brake what rolls on them."""
    scene, margin = around.scene, float(geom.get("margin", "0"))
    for name, part in ((OF_TABLE, scene.table), (OF_WALL, scene.wall)):
        if part is None:
            continue
        pair = add(contact, "pair", geom1=geom.get("name"), geom2=name, margin=margin)
        sliding, rolling = (
            around.friction.pair(part.material, described.material),
            part.rolling_resistance,
        )
        put(pair, friction=(sliding, sliding, 0.0, rolling, rolling))
        put(pair, condim=6 if rolling else 3)
