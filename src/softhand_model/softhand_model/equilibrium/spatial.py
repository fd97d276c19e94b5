"""Equilibrium in space of a straight chain that is held at its base and at its tip.

The rotation of a joint follows from the wrench at the base and from the joints before it, so the
six components of that wrench are the only unknowns, whatever the number of joints; the pose of the
tip gives the six equations. Points (samples, trial values) lie last in every array. Everything is
in the frame of the chain's base: z along it, x to the bending side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softhand_common.numerics.arrays import Array, Flags, Indices
from softhand_model.chain.segments import SegmentChain
from softhand_model.equilibrium.chain_march import straight_links
from softhand_model.equilibrium.joint_springs import JointSprings, plain
from softhand_model.equilibrium.shooting import HeldPoints, settle, turn_tips

__all__ = ["BaseLoad", "HeldChain", "Hold"]

POINTS_AT_ONCE = 1000  # points, so that memory stays bounded


@dataclass(frozen=True)
class Hold:
    """Where the tip is held, at n points.

    position (3, n) [m], orientation (3, 3, n): of the tip. gravity (3, n) [m/s2]; None: no gravity.
    """

    springs: JointSprings
    position: Array
    orientation: Array
    gravity: Array | None = None

    def take(self, chosen: Indices) -> Hold:
        """The hold at some of the points."""
        return Hold(
            self.springs.take(chosen),
            self.position[:, chosen],
            self.orientation[:, :, chosen],
            None if self.gravity is None else self.gravity[:, chosen],
        )


@dataclass(frozen=True)
class BaseLoad:
    """Wrench (6, n) of a chain on its base at n points: force [N] and torque [N m] about the base's
    origin.

    settled (n,): whether the equilibrium was found; where it was not, the load is that of a softer
    clamp, if one was found with it. beyond (6, n): the wrench less a moment that would merely turn
    the tip as it is held; chord (n, 6, 6): its change with the pose of the tip. Both are over the
    stiffness of the joints in series, so that they hold for softer and stiffer chains alike.
    """

    wrench: Array
    settled: Flags
    beyond: Array
    chord: Array

    @classmethod
    def unknown(cls, points: int) -> BaseLoad:
        """Loads of points that are not computed yet."""
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
        """Set the loads of a selection of the points."""
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
    """A straight chain of the simulator, held at both ends (`shooting`).

    Raises ValueError for a chain that is not straight at rest.
    """

    def __init__(self, chain: SegmentChain) -> None:
        self._links = straight_links(chain)
        self._length = float(np.sum(self._links.along))
        force = 1.0 / float(np.sum(1.0 / chain.stiffness[:, 1])) / self._length
        self._unit = np.repeat([force, force * self._length], 3)

    def base_load(
        self, hold: Hold, like: BaseLoad | None = None, sought: Flags | None = None
    ) -> BaseLoad:
        """Load of the chain on its base in equilibrium, at every point.

        like: loads of similar holds, one for each point, from which the search begins; None: no
        loads are known. sought (points,): points that are searched; all others keep the load of
        `like`, not settled. A search in vain takes a hundred times as long as one that succeeds.
        """
        points = hold.position.shape[1]
        found, places = BaseLoad.unknown(points), np.arange(points)
        if like is not None and sought is not None:
            places, lost = np.flatnonzero(sought), np.flatnonzero(~sought)
            found.put(lost, like.take(lost))
            found.settled[lost] = False
        for first in range(0, len(places), POINTS_AT_ONCE):
            part = places[first : first + POINTS_AT_ONCE]
            found.put(part, self._base_load(hold.take(part), like and like.take(part)))
        return found

    def _base_load(self, hold: Hold, like: BaseLoad | None) -> BaseLoad:
        held, stiffness = self._held(hold), 1.0 / np.sum(1.0 / hold.springs.stiffness, axis=0)
        turning = np.empty((len(stiffness), 6))
        turn_tips(held, turning)
        wrench, settled = turning.copy(), np.zeros(len(stiffness), bool)
        chord = np.zeros((len(stiffness), 6, 6))
        if like is not None:
            wrench += (like.beyond * stiffness).T
            chord = like.chord * stiffness[:, None, None]
        settle(held, like is not None, turning, wrench, settled, chord)
        return BaseLoad(
            (wrench * self._unit).T,
            settled,
            (wrench - turning).T / stiffness,
            chord / stiffness[:, None, None],
        )

    def _held(self, hold: Hold) -> HeldPoints:
        """The arrays for compiled code."""
        springs = hold.springs.arrays()
        least = np.minimum(springs.sideways.min(axis=1), 1.0)[:, None] * springs.stiffness
        gravity = np.empty((3, 0)) if hold.gravity is None else plain(hold.gravity)
        return HeldPoints(
            self._links,
            springs,
            plain(hold.position),
            plain(hold.orientation),
            gravity,
            np.sum(1.0 / least, axis=0),
            self._length,
            self._unit,
        )
