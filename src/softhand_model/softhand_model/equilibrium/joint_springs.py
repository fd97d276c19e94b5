"""Springs in the joints of a chain: as stated by users, and in the form that the compiled solver
needs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from softhand_common.numerics.arrays import Array, Indices
from softhand_model.chain.segments import SegmentChain
from softhand_model.equilibrium.joint_balance import TABLE_NODES, TABLE_REACH, SpringArrays

Factor = Callable[[Array, Array, Indices], Array]
"""Factor (n,) [-] on the stiffness in bending, given actual and free bend (n,) [rad] and which
points they belong to.
"""

AT_REST = 1e-9  # [rad]: smaller rotations are zero


@dataclass(frozen=True)
class JointSprings:
    """Joint springs at n points. The rest of a joint is a rotation by `rest` about y.

    stiffness (joints, n) [N m/rad]: in bending, about y. rest (joints, n) [rad]. points (n,): what
    `factor` gets to tell the points apart. coupling (n,) [-]: stiffness that couples bending about
    x and twist about z, over `stiffness`; None for 0. factor: function that returns a factor on the
    stiffness about y; None for 1. sideways (joints, 2) [-]: stiffness about x and z over that in
    bending; None for 1. stretching (joints,) [1/rad]: of rubber springs (`joint_stiffness`), 0 for
    linear ones; None for 0.

    The energy of a joint with linear springs is e*K*e/2, with its rotation vector e from the rest.
    """

    stiffness: Array
    rest: Array
    points: Indices
    coupling: Array | None = None
    factor: Factor | None = None
    sideways: Array | None = None
    stretching: Array | None = None

    def take(self, chosen: Indices) -> JointSprings:
        """The springs of some of the points."""
        return replace(
            self,
            stiffness=self.stiffness[:, chosen],
            rest=self.rest[:, chosen],
            points=self.points[chosen],
            coupling=None if self.coupling is None else self.coupling[chosen],
        )

    @property
    def isotropic(self) -> bool:
        """Whether the springs of each joint are equal about all axes."""
        more = (self.coupling, self.factor, self.sideways, self.stretching)
        return all(entry is None for entry in more)

    def arrays(self) -> SpringArrays:
        """The springs for compiled kernels.

        A factor is tabulated below and above the rest. It may jump at the rest, but must be smooth
        on each side.
        """
        joints, points = self.stiffness.shape
        return SpringArrays(
            self.isotropic,
            plain(self.stiffness),
            plain(self.rest),
            plain(np.sin(self.rest)),
            plain(np.cos(self.rest)),
            _or(self.sideways, np.ones((joints, 2))),
            _or(self.stretching, np.zeros(joints)),
            _or(self.coupling, np.zeros(points)),
            np.empty((0, joints, 2, TABLE_NODES))
            if self.factor is None
            else self._table(self.factor),
        )

    def _table(self, factor: Factor) -> Array:
        """Table of the factors (n, joints, 2, TABLE_NODES) [-] below and above the rest."""
        off = off_rest()
        rest = np.broadcast_to(self.rest.T[:, :, None, None], (*self.rest.T.shape, *off.shape))
        points = np.broadcast_to(self.points[:, None, None, None], rest.shape)
        bends = (rest + off).ravel()
        return np.reshape(factor(bends, rest.ravel(), points.ravel()), rest.shape).astype(float)


@cache
def off_rest() -> Array:
    """Bends (2, TABLE_NODES) [rad] below and above the rest at which factors are tabulated."""
    distance = np.linspace(0.0, TABLE_REACH, TABLE_NODES)
    distance[0] = AT_REST
    return np.stack([-distance, distance])


def _or(given: Array | None, neutral: Array) -> Array:
    return neutral if given is None else plain(given)


def plain(array: Array) -> Array:
    """The array in the form that compiled kernels need: contiguous and writable."""
    return np.require(array, float, ["C", "W"])


def springs_of(chain: SegmentChain, rest: Array, modulus: Array | float = 1.0) -> JointSprings:
    """Springs of a chain at rest angles (joints, n) [rad]. modulus (n,) [-]: factor on the shear
    modulus of the rubber.
    """
    points, bending = rest.shape[1], chain.stiffness[:, 1:2]
    sideways = chain.stiffness[:, [0, 2]] / bending
    return JointSprings(
        bending * np.broadcast_to(modulus, points),
        rest,
        np.arange(points),
        sideways=None if np.all(sideways == 1.0) else sideways,
        stretching=chain.stretching if chain.stretching.any() else None,
    )
