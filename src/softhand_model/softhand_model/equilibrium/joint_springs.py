"""Springs in the joints of a chain, for users and for the compiled search."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

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
    """Joint springs at n points, linear about the rest orientation, a rotation by `rest` about y.

    stiffness, rest (joints, n) [N m/rad], [rad]; sideways (joints, 2) [-]: stiffness about x and z
    over that in bending, 1 if absent; stretching (joints,) [1/rad]: of rubber in bending
    (`joint_stiffness`), 0 for linear springs; coupling (n,) [-]: off-diagonal of bending about x
    and twist about z over the stiffness; factor: on the stiffness about y; points (n,): what the
    factor gets of the points.
    The energy of a joint is that of its rotation vector against the rest, e*K*e/2 where the springs
    are linear.
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
        """Whether all springs are the same about all axes."""
        more = (self.coupling, self.factor, self.sideways, self.stretching)
        return all(entry is None for entry in more)

    def arrays(self) -> SpringArrays:
        """The springs for compiled kernels.

        A factor is tabulated on both sides of the rest, where it may jump: what it does on either
        side is taken as smooth.
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


def off_rest() -> Array:
    """Bends (2, TABLE_NODES) [rad] from rest, below and above it, of the tables of factors."""
    distance = np.linspace(0.0, TABLE_REACH, TABLE_NODES)
    distance[0] = AT_REST
    return np.stack([-distance, distance])


def _or(given: Array | None, neutral: Array) -> Array:
    return neutral if given is None else plain(given)


def plain(array: Array) -> Array:
    """The array for compiled kernels: contiguous and writable."""
    return np.require(array, float, ["C", "W"])


def springs_of(chain: SegmentChain, rest: Array, modulus: Array | float = 1.0) -> JointSprings:
    """The springs of a chain at rest angles (joints, n) [rad], of a rubber whose shear modulus is
    `modulus` (n,) [-] over the chain's.
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
