"""A chain followed from its base to its tip, given the wrench that it exerts on the base."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softhand_model.joint_springs import JointSprings
from softhand_model.segments import SegmentChain
from softhand_model.vector_fields import (
    cross,
    cross_matrix,
    exponentials,
    identity,
    product,
    rotations,
    transposed,
    turned,
    turned_back,
)

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Links:
    """Links of a straight chain with n joints: along (n + 1,) [m] from base to joint, from joint to
    joint and to the tip; mass (n,) [kg] and centre (n, 3) [m] of each in its own frame.
    """

    along: Array
    mass: Array
    center: Array


def straight_links(chain: SegmentChain) -> Links:
    """The links of a chain; raises ValueError for one that is not straight at rest."""
    if np.any(chain.offset[:, :2]) or np.any(chain.rest[:, :3]) or np.any(chain.tip_offset[:2]):
        raise ValueError("chain: expected one that is straight at rest, got an arc")
    along = np.append(chain.offset[:, 2], chain.tip_offset[2])
    return Links(along, chain.mass, chain.body_center)


class Front:
    """What the chain has come to at one of its points.

    turn (3, 3, n), place (3, n) [m]: of the frame; force [N], moment [N m] (3, n): of all that lies
    beyond, the moment about the base's origin.
    """

    def __init__(self, wrench: Array) -> None:
        points = wrench.shape[1]
        self.force, self.moment = wrench[:3], wrench[3:]
        self.turn, self.place = identity(points), np.zeros((3, points))

    def follow(self, links: Links, springs: JointSprings, gravity: Array | None) -> Front:
        """Go on to the tip, under gravity (3, n) [m/s2] or none."""
        for joint, mass in enumerate(links.mass):
            self._advance(links.along[joint])
            self._bend(springs, joint)
            if gravity is not None:
                self._unload(mass * gravity, links.center[joint])
        self._advance(links.along[-1])
        return self

    def _advance(self, length: float) -> Array:
        """Go on along the link; what has been gone (3, n) [m]."""
        reach = length * self.turn[:, 2]
        self.place = self.place + reach
        return reach

    def _bend(self, springs: JointSprings, joint: int) -> None:
        """Pass a joint, whose spring carries what lies beyond."""
        moment = self.moment - cross(self.place, self.force)
        if springs.isotropic:  # it turns about the moment, in any frame
            rotation = springs.rotation(joint, moment)
            self.turn = _about_y(product(rotations(rotation), self.turn), *springs.turn(joint))
            return
        rest = _about_y(self.turn, *springs.turn(joint))
        rotation = springs.rotation(joint, turned_back(rest, moment))
        self.turn = product(rest, rotations(rotation))

    def _unload(self, weight: Array, center: Array) -> Array:
        """Leave a link behind: its weight (3, n) [N] at a centre (3,) [m]; the arm (3, n) [m]."""
        arm = turned(self.turn, center[:, None])
        self.moment = self.moment - cross(self.place + arm, weight)
        self.force = self.force - weight
        return arm


class SlopedFront(Front):
    """A front with its derivatives by the six components of the wrench at the base.

    spin (3, 6, n) [rad], shift (3, 6, n) [m], by_moment (3, 6, n) [N m]: changes of orientation,
    place and moment; the force changes as the one at the base does.
    """

    def __init__(self, wrench: Array) -> None:
        super().__init__(wrench)
        points = wrench.shape[1]
        self.spin, self.shift = np.zeros((3, 6, points)), np.zeros((3, 6, points))
        self.by_moment = np.zeros((3, 6, points))
        self.by_moment[:, 3:] = np.eye(3)[:, :, None]

    def _advance(self, length: float) -> Array:
        reach = super()._advance(length)
        self.shift = self.shift + cross(self.spin, reach[:, None])
        return reach

    def _bend(self, springs: JointSprings, joint: int) -> None:
        moment = self.moment - cross(self.place, self.force)
        change = self.by_moment - cross(self.shift, self.force[:, None])
        change[:, :3] -= cross_matrix(self.place)
        change -= cross(self.spin, moment[:, None])
        rest = _about_y(self.turn, *springs.turn(joint))
        local = turned_back(rest, moment)
        rotation = springs.rotation(joint, local)
        exponential, jacobian = exponentials(rotation)
        self.turn = product(rest, exponential)
        inward = product(jacobian, springs.compliance(joint, rotation, local))
        outward = product(product(rest, inward), transposed(rest))
        self.spin = self.spin + turned(outward, change)

    def _unload(self, weight: Array, center: Array) -> Array:
        arm = super()._unload(weight, center)
        moved = self.shift + cross(self.spin, arm[:, None])
        self.by_moment = self.by_moment - cross(moved, weight[:, None])
        return arm


def _about_y(turn: Array, sine: Array, cosine: Array) -> Array:
    """Rotations (3, 3, n) followed by a turn about their y of this sine and cosine (n,)."""
    x, z = turn[:, 0], turn[:, 2]
    result = np.empty_like(turn)
    result[:, 0] = cosine * x - sine * z
    result[:, 1] = turn[:, 1]
    result[:, 2] = sine * x + cosine * z
    return result
