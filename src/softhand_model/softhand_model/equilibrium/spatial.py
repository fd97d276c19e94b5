"""Equilibrium in space of a straight chain that is held at its base and at its tip.

The rotation of a joint follows from the wrench at the base and from the joints before it, so the
six components of that wrench are the only unknowns, whatever the number of joints; the pose of the
tip gives the six equations. All points (samples, trial values) are solved at once and lie last in
every array. Everything is in the frame of the chain's base: z along it, x to the bending side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softhand_model.chain.segments import SegmentChain
from softhand_model.equilibrium.shooting import (
    Front,
    Hold,
    Search,
    TipClamp,
    by_chords,
    by_newton,
    by_tightening,
    straight_links,
)
from softhand_model.numerics.arrays import Array, Flags, Indices
from softhand_model.numerics.rotations import product, rotation_vectors, transposed

__all__ = ["BaseLoad", "HeldChain", "Hold"]


AMBIGUOUS = 0.6  # [rad]: a rotation less far than this is not taken to go the other way round
AT_ONCE = 4000  # points, so that memory stays bounded


@dataclass(frozen=True)
class BaseLoad:
    """What a chain exerts on its base at n points: wrench (6, n), force [N] and torque [N m] about
    the base's origin.

    settled (n,): whether the equilibrium was found; elsewhere the load is that of a softer clamp,
    as far as one led to an equilibrium.
    beyond (6, n): the wrench less a moment that would merely turn the tip as it is held; chord
    (n, 6, 6): its change with the pose of the tip. Both are over the stiffness of the joints in
    series, so that they hold for softer and stiffer chains alike.
    """

    wrench: Array
    settled: Flags
    beyond: Array
    chord: Array

    @classmethod
    def unknown(cls, points: int) -> BaseLoad:
        """Loads of so many points that are yet to be found."""
        return cls(
            np.empty((6, points)),
            np.empty(points, bool),
            np.empty((6, points)),
            np.empty((points, 6, 6)),
        )

    def take(self, chosen: Indices) -> BaseLoad:
        """The loads of some of the points."""
        return BaseLoad(
            self.wrench[:, chosen], self.settled[chosen], self.beyond[:, chosen], self.chord[chosen]
        )

    def put(self, chosen: Indices, loads: BaseLoad) -> None:
        """Set the loads of some of the points."""
        self.wrench[:, chosen], self.settled[chosen] = loads.wrench, loads.settled
        self.beyond[:, chosen], self.chord[chosen] = loads.beyond, loads.chord

    @property
    def force(self) -> Array:
        """Force (3, n) [N]."""
        return self.wrench[:3]

    @property
    def torque(self) -> Array:
        """Torque (3, n) [N m]."""
        return self.wrench[3:]


class HeldChain:
    """A straight chain as the simulator has it, held at both ends (`shooting.TipClamp`).

    Raises ValueError for a chain that is not straight at rest.
    """

    def __init__(self, chain: SegmentChain) -> None:
        self._clamp = TipClamp(straight_links(chain), chain.stiffness[:, 1])

    def base_load(self, hold: Hold, like: BaseLoad | None = None) -> BaseLoad:
        """What the chain exerts on its base in equilibrium, at every point.

        like: loads of similar holds, point by point, from which the search begins.
        """
        points = hold.position.shape[1]
        found = BaseLoad.unknown(points)
        # points that have no equilibrium run away before they are given up as not settled
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            for first in range(0, points, AT_ONCE):
                part = np.arange(first, min(first + AT_ONCE, points))
                found.put(part, self._base_load(hold.take(part), like and like.take(part)))
        return found

    def _base_load(self, hold: Hold, like: BaseLoad | None) -> BaseLoad:
        clamp, turning = self._clamp, self._turning(hold)
        stiffness = 1.0 / np.sum(1.0 / hold.springs.stiffness, axis=0)
        points = len(stiffness)
        search = Search(turning.copy(), np.zeros(points, bool), np.zeros((points, 6, 6)))
        if like is not None:
            search.wrench += like.beyond * stiffness
            search.chord = like.chord * stiffness[:, None, None]
            by_chords(clamp, hold, search)
        by_newton(clamp, hold, search)
        by_tightening(clamp, hold, search, turning)
        return BaseLoad(
            search.wrench * clamp.unit,
            search.settled,
            (search.wrench - turning) / stiffness,
            search.chord / stiffness[:, None, None],
        )

    def _turning(self, hold: Hold) -> Array:
        """Wrench (6, n) to begin with: a moment that turns the tip as it is held.

        Far from the free pose it may turn either way round: the one that brings the tip nearer.
        """
        free = self._tip(hold, np.zeros((6, hold.position.shape[1])))
        rotation = rotation_vectors(product(hold.orientation, transposed(free.orientation)))
        wrench = self._moment(hold, rotation)
        far = np.flatnonzero(np.sum(rotation * rotation, axis=0) > AMBIGUOUS**2)
        if len(far):
            part, angle = hold.take(far), np.sqrt(np.sum(rotation[:, far] ** 2, axis=0))
            other = self._moment(part, rotation[:, far] * (1.0 - 2.0 * np.pi / angle))
            misses = [
                np.sum((self._tip(part, way).place - part.position) ** 2, axis=0)
                for way in (wrench[:, far], other)
            ]
            wrench[:, far] = np.where(misses[1] < misses[0], other, wrench[:, far])
        return wrench

    def _tip(self, hold: Hold, wrench: Array) -> Front:
        """The tip of the weightless chain."""
        return Front(wrench * self._clamp.unit).follow(self._clamp.links, hold.springs, None)

    def _moment(self, hold: Hold, rotation: Array) -> Array:
        """Wrench (6, n) that turns the tip by a rotation vector (3, n) [rad], or less far where the
        springs are not the same about all axes.
        """
        yielding = np.sum(1.0 / hold.springs.softest, axis=0)
        moment = rotation / yielding / self._clamp.unit[3:]
        return np.concatenate([np.zeros_like(moment), moment])
