"""Elements of MuJoCo's model format (MJCF) from plain numbers."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree as xml

import numpy as np
from numpy.typing import ArrayLike

from pneuflex_sim.hand.collision import SKIN_TWIST
from softhand_common.numerics.arrays import Array

Element = xml.Element

BITS = 0x7FFFFFFF  # of MuJoCo's masks, whose numbers have a sign


def add(parent: Element, tag: str, **attributes: object) -> Element:
    """Add a child with attributes; numbers become text that reads back bit for bit."""
    child = xml.SubElement(parent, tag)
    put(child, **attributes)
    return child


def put(element: Element, **attributes: object) -> None:
    """Set attributes of an element."""
    for key, value in attributes.items():
        element.set(key, _text(value))


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str | int):
        return str(value)
    return " ".join(repr(float(number)) for number in np.ravel(value))


def wxyz(quaternion: ArrayLike) -> Array:
    """A quaternion x, y, z, w in MuJoCo's order w, x, y, z."""
    return np.roll(quaternion, 1)


def xyzw(quaternion: ArrayLike) -> Array:
    """A quaternion in MuJoCo's order w, x, y, z as x, y, z, w."""
    return np.roll(quaternion, -1)


def touching(geom: Element, friction: float, group: int, others: int) -> None:
    """Set the sliding friction of a geom with the hand (whose contact patch also resists twisting),
    the collision group of the geom, and the groups with which it collides.
    """
    put(
        geom,
        condim=4,
        friction=(friction, SKIN_TWIST * friction, 0.0),
        contype=group,
        conaffinity=others & BITS,
    )


def hull(body: Element, assets: Element, name: str, corners: Array, margin: float) -> Element:
    """Convex hull of corners (k, 3) [m], dilated by a margin [m]."""
    add(assets, "mesh", name=name, vertex=corners, inertia="convex")
    return add(body, "geom", name=name, type="mesh", mesh=name, margin=margin)
