"""Springs that effects stiffen, soften or couple, without touching the springs: their rest moves.

A simulation keeps a diagonal stiffness K; where effects make it C*K with a matrix C (3, 3) a joint,
a rest from which K pulls with C*K*e is put in place of the one from which the joint is e away.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

LATERAL, BEND, TWIST = range(3)  # axes x, y, z of a joint


def moved_rest(rest: Array, actual: Array, factor: Array, coupling: Array) -> Array:
    """Rotation vectors (n, 3) [rad] of a rest from which unchanged springs pull as changed ones do.

    rest, actual (n, 3) [rad]: of the free and the actual joint. factor (n, 3) [-] on the stiffness
    about each axis; coupling (n, 2) [-]: of lateral bending and twist, over the stiffness about x
    and about z. Of springs that are not linear or not alike about all axes it is right for small
    angles.

    >>> moved_rest(np.zeros((1, 3)), np.full((1, 3), 0.1), np.full((1, 3), 0.5), np.zeros((1, 2)))
    array([[0.05, 0.05, 0.05]])
    """
    if not coupling.any():
        # the axes of bend and error are the same as long as nothing turns sideways
        return actual + factor * (rest - actual)
    turned = Rotation.from_rotvec(actual)
    away = (Rotation.from_rotvec(rest).inv() * turned).as_rotvec()
    pull = factor * away
    pull[:, LATERAL] += coupling[:, 0] * away[:, TWIST]
    pull[:, TWIST] += coupling[:, 1] * away[:, LATERAL]
    return np.asarray((turned * Rotation.from_rotvec(pull).inv()).as_rotvec(), float)
