"""Shape adaptability of a hold as numbers (thesis 8.1): contacts, area, redundancy, force closure.

A grasp is force-closed if forces within the cones of friction balance any wrench on the object,
however hard the contacts have to press for it (frictional form closure): no statement about the
strength of the hand. Torques are divided by a length of the object, so that all of a wrench is in
newtons.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from softhand_common.numerics.arrays import Array

CONE_EDGES = 16  # of the pyramid within a cone of friction, at most 2 % too small
PATCH_ARM = 3.0 * np.pi / 16.0  # torque over friction force and radius of a round patch (Hertz)
LEAST_DIRECTION = 0.05  # singular value of directions that count as independent [-]
LEAST_MARGIN = 1e-6  # of what is force-closed; solver's tolerance [-]


@dataclass(frozen=True)
class TouchPoint:
    """A contact point of the hand on the object.

    Attributes:
        part: name of the chain of links, or of the palm plate.
        link: name of the link in it; empty for the plate.
        position: (3,) [m].
        normal: (3,) unit vector into the object.
        friction: coefficient [-].
        patch: radius [m] of the skin's patch; 0 for a hard point, which resists no twist.
    """

    part: str
    link: str
    position: tuple[float, float, float]
    normal: tuple[float, float, float]
    friction: float
    patch: float = 0.0


@dataclass(frozen=True)
class Adaptability:
    """Figures of how well the contacts of a hold secure the object.

    Attributes:
        points: number of contact points; how many a link has depends on the engine.
        links: number of links that touch; the palm plate is one.
        parts: number of fingers, thumb, palm and plate that touch; in RBO Hand 2 each actuator is a
            part, and the palm has two.
        area: area of the skin's patches, without the plate [m2]; overlapping patches count twice.
        redundancy: sum over the links of the dimension of the wrenches that each can exert, less
            the dimension of all these wrenches together [-]: the dimension of the internal forces.
        margin: the least force that the hold resists along any axis, or torque about any axis over
            the length, with normal forces of 1 N in total [-]; 0 without force closure.
    """

    points: int
    links: int
    parts: int
    area: float
    redundancy: int
    margin: float

    @property
    def force_closed(self) -> bool:
        """Whether the contacts can balance any wrench."""
        return self.margin > 0.0


def adaptability(
    touches: Iterable[TouchPoint], centre: Sequence[float] | Array, length: float
) -> Adaptability:
    """Shape adaptability from the contact points of a hold.

    Args:
        touches: the contact points of the hand.
        centre: point (3,) [m] about which torques are taken.
        length: length by which torques are divided [m], such as half the diagonal of the object.

    Raises:
        ValueError: a length that is not positive.

    >>> facing = [("thumb", (0.02, 0, 0), (-1, 0, 0)), ("index", (-0.02, 0, 0), (1, 0, 0))]
    >>> pinch = [TouchPoint(part, "tip", *place, 0.6, 0.003) for part, *place in facing]
    >>> found = adaptability(pinch, (0, 0, 0), 0.02)
    >>> found.links, found.redundancy, found.force_closed, round(found.margin, 3)
    (2, 2, True, 0.053)
    """
    if not length > 0.0:
        raise ValueError(f"length: expected a positive number [m], got {length}")
    touches = list(touches)
    by_link: dict[tuple[str, str], list[TouchPoint]] = {}
    for touch in touches:
        by_link.setdefault((touch.part, touch.link), []).append(touch)
    components = [
        np.concatenate([_components(touch, centre, length) for touch in same], axis=1)
        for same in by_link.values()
    ]
    return Adaptability(
        points=len(touches),
        links=len(by_link),
        parts=len({touch.part for touch in touches}),
        area=float(sum(np.pi * touch.patch**2 for touch in touches)),
        redundancy=sum(map(_rank, components)) - _rank(np.concatenate(components, axis=1))
        if touches
        else 0,
        margin=closure_margin(edge_wrenches(touches, centre, length)),
    )


def edge_wrenches(
    touches: Sequence[TouchPoint], centre: Sequence[float] | Array, length: float
) -> Array:
    """Wrenches (6, k) of contact forces with a normal part of 1 N along the edges of the cones of
    friction, with as much twist of the patch either way as friction allows: force [N], and torque
    about the centre over the length [N].
    """
    angles = 2.0 * np.pi * np.arange(CONE_EDGES) / CONE_EDGES
    found = [np.zeros((6, 0))]
    for touch in touches:
        normal, *tangents = _axes(touch)
        sideways = np.outer(tangents[0], np.cos(angles)) + np.outer(tangents[1], np.sin(angles))
        forces = normal[:, None] + touch.friction * sideways
        arm = np.array(touch.position) - centre
        torques = np.cross(arm, forces, axisb=0).T
        twist = PATCH_ARM * touch.friction * touch.patch * normal[:, None]
        signs = (1.0, -1.0) if touch.patch else (0.0,)
        found += [np.concatenate([forces, (torques + s * twist) / length]) for s in signs]
    return np.concatenate(found, axis=1)


def closure_margin(wrenches: Array) -> float:
    """The margin of `Adaptability` of wrenches (6, k), each for 1 N of normal force [-]."""
    axes = np.eye(6)
    margin = np.inf
    for direction in (*axes, *-axes):
        margin = min(margin, resisted(wrenches, direction))
        if margin <= LEAST_MARGIN:
            return 0.0
    return float(margin)


def resisted(wrenches: Array, direction: Array) -> float:
    """Largest multiple [-] of a direction (6,) that a weighted sum of wrenches (6, k) reaches, with
    weights of 0 or more that add up to at most 1: a linear program.
    """
    from scipy.optimize import linprog  # here, as it takes long to load

    count = wrenches.shape[1]
    if not count:
        return 0.0
    found = linprog(
        np.append(np.zeros(count), -1.0),
        A_ub=np.append(np.ones(count), 0.0)[None],
        b_ub=[1.0],
        A_eq=np.column_stack([wrenches, -direction]),
        b_eq=np.zeros(6),
    )
    return float(found.x[-1])


def _axes(touch: TouchPoint) -> Array:
    """Unit normal and two tangents (3, 3) of a contact point, in rows."""
    normal = np.array(touch.normal, float) / np.linalg.norm(touch.normal)
    first = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    first /= np.linalg.norm(first)
    return np.array([normal, first, np.cross(normal, first)])


def _components(touch: TouchPoint, centre: Sequence[float] | Array, length: float) -> Array:
    """Wrenches (6, 3 or 4) of a unit force along each axis, and of a twist if there is a patch."""
    axes = _axes(touch)
    arm = (np.array(touch.position) - centre) / length
    found = np.concatenate([axes.T, np.cross(arm, axes).T])
    twist = np.append(np.zeros(3), axes[0])[:, None]
    return np.concatenate([found, twist], axis=1) if touch.patch else found


def _rank(components: Array) -> int:
    return int(np.linalg.matrix_rank(components, tol=LEAST_DIRECTION))
