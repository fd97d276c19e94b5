"""Cutting a chain into rigid segments with one joint in the middle of each (section 5.1.1)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_common.numerics.rotations import about_x
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.hand import ChainDescription, Strut
from softhand_model.hand.joint_stiffness import THESIS, SpringModel

LATERAL_AXIS, BEND_AXIS, TWIST_AXIS = range(3)  # axes x, y, z of a joint
KEPT_MASSES = 64  # actuators whose links' masses are kept: a fit changes their moduli alone


@dataclass(frozen=True)
class SegmentChain:
    """Rigid links with a spring joint each; row i belongs to joint i and to the link beyond it.

    Link frames have z along the link, y along the bending axis and +x to the bending side; their
    origin is the joint, on the neutral layer. A strut, if there is one, is joint 0. With n joints:

    offset (n, 3) [m]: joint in the frame of the link before it (joint 0: in the chain's base frame)
    rest (n, 4): orientation against the link before at zero pressure, quaternion
    axes (n, 4): frame in which the joint bends about y and twists about z, seen from the link: the
        middle of an arc's segment; identity for straight actuators
    stiffness (n, 3) [N m/rad]: about x, y, z of the link frame
    stretching (n,) [1/rad]: of the top by the joint's bend, 0 where the spring in bending is linear
        (`joint_stiffness.SpringModel`)
    body_size (n, 3), body_center (n, 3) [m]: box of height, width and length in the link frame
    mass (n,) [kg]; tip_offset (3,) [m]: tip in the last link's frame

    The half segment at the base moves with the mount and is not part of the chain.
    """

    names: tuple[str, ...]
    offset: Array
    rest: Array
    axes: Array
    stiffness: Array
    stretching: Array
    body_size: Array
    body_center: Array
    mass: Array
    tip_offset: Array

    def require_straight(self) -> None:
        """Raise ValueError for a chain that is not straight at rest."""
        if np.any(self.offset[:, :2]) or np.any(self.rest[:, :3]) or np.any(self.tip_offset[:2]):
            raise ValueError("chain: expected one that is straight at rest, got an arc")


def link_inertia(size: Array, mass: Array) -> Array:
    """Principal moments of inertia (n, 3) [kg m2], about their centres, of links as boxes with
    sizes (n, 3) [m] and masses (n,) [kg].
    """
    x, y, z = size.T
    return np.stack([y**2 + z**2, x**2 + z**2, x**2 + y**2], axis=1) * mass[:, None] / 12


def cut_chain(
    description: ChainDescription, segments: int, springs: SpringModel = THESIS
) -> SegmentChain:
    """Cut a chain into `segments` segments per actuator, plus one joint for its strut if it has
    one.
    """
    parts = list(description.actuators.values())
    if description.turn:
        chain = _arc(description, parts, segments, springs)
    else:
        chain = _straight(description, parts, segments, springs)
    return chain if description.strut is None else _on_strut(chain, description, description.strut)


def _springs(
    description: ChainDescription, segments: int, springs: SpringModel
) -> tuple[Array, Array]:
    """Stiffness (n, 3) [N m/rad] of actuators that bend as one, and their mean stretching (n,)
    [1/rad], weighed by their stiffness in bending.
    """
    parts = description.actuators.values()
    stiffness = np.array([springs.stiffness(part, segments) for part in parts])
    stretching = np.array([springs.stretching(part, segments) for part in parts])
    total = stiffness.sum(axis=0)
    stretching = np.sum(stiffness[:, :, 1] * stretching, axis=0) / total[:, 1]
    along = np.array([springs.side_by_side(part, segments) for part in parts])
    total[:, 0] += _about_middle(along, lateral_places(description)[:, None])
    return total, stretching


def _about_middle(weight: Array, place: Array) -> Array:
    """Second moment (n,) of weights (m, n) at places (m, 1) [m] about their mean; 0 for none."""
    total = weight.sum(axis=0)
    middle = np.sum(weight * place, axis=0) / np.where(total > 0.0, total, 1.0)
    return np.asarray(np.sum(weight * (place - middle) ** 2, axis=0))


def _straight(
    description: ChainDescription, parts: list[Actuator], segments: int, springs: SpringModel
) -> SegmentChain:
    edge = parts[0].length / segments
    length = np.full(segments, edge)
    length[-1] = edge / 2.0
    offset = np.zeros((segments, 3))
    offset[:, 2] = edge
    offset[0, 2] = edge / 2.0
    middle = (np.arange(segments) + 0.5) * edge + length / 2.0
    height = np.max([part.height(middle) for part in parts], axis=0)
    width = description.pitch + np.mean([part.width(middle) for part in parts], axis=0)
    stiffness, stretching = _springs(description, segments, springs)
    return SegmentChain(
        _names(description, segments),
        offset,
        _identity(segments),
        _identity(segments),
        _webbed(description, edge, stiffness),
        stretching,
        np.stack([height, width, length], axis=1),
        np.stack([-height / 2.0, 0.0 * height, length / 2.0], axis=1),
        np.sum([_link_masses(part, segments) for part in parts], axis=0),
        np.array([0.0, 0.0, edge / 2.0]),
    )


def _webbed(description: ChainDescription, edge: float, stiffness: Array) -> Array:
    """Stiffness (n, 3) with that of the neighbours about x and z where mesh joins the chain to them
    (see `hand.Web`); `edge` [m] is the length of a segment.
    """
    if description.web is not None:
        joined = (np.arange(len(stiffness)) + 0.5) * edge < description.web.length
        stiffness[joined] *= [description.web.chains, 1.0, description.web.chains]
    return stiffness


def _arc(
    description: ChainDescription, parts: list[Actuator], segments: int, springs: SpringModel
) -> SegmentChain:
    """One arc, or two as a chain along their middle; a link points along the chord ahead.

    Springs act about the axes of the link, half a segment's angle off those of the section.
    """
    angle, radius = arc_angle(parts) / segments, mean_radius(parts)
    side = description.turn
    chord, half_chord = 2.0 * radius * np.sin(angle / 2.0), 2.0 * radius * np.sin(angle / 4.0)
    towards = np.array([0.0, side * np.sin(angle / 4.0), np.cos(angle / 4.0)])
    offset = np.tile([0.0, 0.0, chord], (segments, 1))
    offset[0] = half_chord * towards
    stiffness, stretching = _springs(description, segments, springs)
    length = np.full(segments, chord)
    length[-1] = half_chord
    height = np.full(segments, max(float(part.height(0.0)) for part in parts))
    width = np.full(segments, _breadth(parts))
    return SegmentChain(
        _names(description, segments),
        offset,
        np.tile(about_x(-side * angle), (segments, 1)),
        np.tile(about_x(side * angle / 2.0), (segments, 1)),
        stiffness,
        stretching,
        np.stack([height, width, length], axis=1),
        np.stack([-height / 2.0, 0.0 * height, length / 2.0], axis=1),
        np.sum([_link_masses(part, segments) for part in parts], axis=0),
        half_chord * towards * np.array([1.0, -1.0, 1.0]),
    )


def _on_strut(chain: SegmentChain, description: ChainDescription, strut: Strut) -> SegmentChain:
    """The chain behind a joint in its strut's middle, whose link carries segment 0's base half."""
    base = chain.offset[0]
    half = np.array([0.0, 0.0, strut.length / 2.0])
    offset = np.vstack([half, half + base, chain.offset[1:]])
    size = np.array([chain.body_size[0, 0], chain.body_size[0, 1], np.linalg.norm(base)])
    center = half + base / 2.0 - [size[0] / 2.0, 0.0, 0.0]
    mass = strut.mass / 2.0 + _base_half_mass(description, len(chain.mass))
    return SegmentChain(
        (f"{description.name}_strut", *chain.names),
        offset,
        np.vstack([_identity(1), chain.rest]),
        np.vstack([_identity(1), chain.axes]),
        np.vstack([strut.stiffness(), chain.stiffness]),
        np.append(0.0, chain.stretching),
        np.vstack([size, chain.body_size]),
        np.vstack([center, chain.body_center]),
        np.concatenate([[mass], chain.mass]),
        chain.tip_offset,
    )


def _base_half_mass(description: ChainDescription, segments: int) -> float:
    return sum(
        part.mass_between(0.0, part.length / segments / 2.0)
        for part in description.actuators.values()
    )


def _link_masses(actuator: Actuator, segments: int) -> Array:
    """Mass (n,) [kg] of the rubber between each joint and the next, the last one to the tip."""
    return _kept_masses(replace(actuator, shear_modulus=1.0), segments)


@lru_cache(maxsize=KEPT_MASSES)
def _kept_masses(actuator: Actuator, segments: int) -> Array:
    """`_link_masses`, on which the modulus has no influence; not to be changed in place."""
    edges = np.append((np.arange(segments) + 0.5) * actuator.length / segments, actuator.length)
    return np.array([actuator.mass_between(*pair) for pair in pairwise(edges)])


def arc_angle(parts: list[Actuator]) -> float:
    """Angle [rad] of parallel arcs, which is the same for all."""
    return parts[0].arc_angle or 0.0


def mean_radius(parts: list[Actuator]) -> float:
    """Mean radius of curvature [m] of actuators that lie side by side as arcs, all weighted
    alike.
    """
    return float(np.mean([part.arc_radius or 0.0 for part in parts]))


def lateral_places(description: ChainDescription) -> Array:
    """Position (actuators,) [m] of the middle of each actuator along y in the sections of the
    chain.
    """
    parts = list(description.actuators.values())
    if description.turn:
        radii = np.array([part.arc_radius or 0.0 for part in parts])
        return np.asarray(-description.turn * (radii - radii.mean()))
    return np.asarray(description.pitch * (np.arange(len(parts)) - (len(parts) - 1) / 2.0))


def _breadth(parts: list[Actuator]) -> float:
    """Width [m] over all arcs side by side."""
    gap = (parts[-1].arc_radius or 0.0) - (parts[0].arc_radius or 0.0)
    return gap + sum(float(part.width(0.0)) for part in parts) / len(parts)


def _names(description: ChainDescription, segments: int) -> tuple[str, ...]:
    return tuple(f"{description.name}_{index}" for index in range(segments))


def _identity(count: int) -> Array:
    return np.tile([0.0, 0.0, 0.0, 1.0], (count, 1))
