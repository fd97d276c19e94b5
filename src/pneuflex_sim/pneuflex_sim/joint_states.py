"""Orientations and velocities of all joints of a hand, taken from PyBullet into two arrays."""

from __future__ import annotations

import struct

import numpy as np
import pybullet
from numpy.typing import NDArray

Array = NDArray[np.float64]

IDENTITY = (0.0, 0.0, 0.0, 1.0)


class JointStates:
    """Orientations q (n, 4) and velocities v (n, 3) [rad/s] of the spherical joints of some bodies,
    each with `counts` joints and no others. The arrays stay the same ones.
    """

    def __init__(self, bodies: list[int], counts: list[int], client: int) -> None:
        self._bodies = [
            (body, list(range(count))) for body, count in zip(bodies, counts, strict=True)
        ]
        self._client, n = client, sum(counts)
        self.q, self.v = np.tile(IDENTITY, (n, 1)), np.zeros((n, 3))
        self._orientations, self._velocities = (
            struct.Struct(f"{4 * n}d"),
            struct.Struct(f"{3 * n}d"),
        )

    def read(self) -> None:
        """Fill the arrays; with lists, struct and no keywords: each costs time in every step."""
        client, orientations, velocities = self._client, [], []
        for body, joints in self._bodies:
            for q, v, _, _ in pybullet.getJointStatesMultiDof(body, joints, client):
                orientations += q
                velocities += v
        self._orientations.pack_into(self.q, 0, *orientations)
        self._velocities.pack_into(self.v, 0, *velocities)

    def push(self, torque: Array) -> None:
        """Apply torques (n, 3) [N m] to the joints in the next step, in their child frames."""
        torques, first = torque.tolist(), 0
        for body, joints in self._bodies:
            last = first + len(joints)
            pybullet.setJointMotorControlMultiDofArray(
                body,
                joints,
                pybullet.TORQUE_CONTROL,
                forces=torques[first:last],
                physicsClientId=self._client,
            )
            first = last
