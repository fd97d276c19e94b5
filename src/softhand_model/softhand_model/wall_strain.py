"""Strain through the thickness of the wall of a bent actuator (section 3.4.5).

Depths and curvatures are relative to the height h: depth = d/h [-] counts from the outer face of
the undeformed wall, bend = kappa*h [-].
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softhand_model.section import NEWTON_STEPS

Array = NDArray[np.float64]


def deformed_depth(depth: ArrayLike, bend: ArrayLike) -> Array:
    """Depth d'/h [-] at which rubber from the depth d/h ends up when the actuator bends.

    The differential equation 3.44 keeps the volume; its integral is the cubic
    u**2/2 + bend*u**3/3 = v**2/2 + bend/3 with u = 1 - d'/h and v = 1 - d/h, solved here by Newton
    from u = 1. ERRATUM: the text sets the boundary lambda1 = (1 + kappa*h)/lambda2 with
    lambda2 = 1; at the outer face lambda1 = 1 + kappa*h, lambda2 = 1/lambda1 and lambda3 = 1.
    """
    depth, bend = np.broadcast_arrays(np.asarray(depth, float), np.asarray(bend, float))
    kept = (1.0 - depth) ** 2 / 2.0 + bend / 3.0
    u = np.ones_like(kept)
    for _ in range(NEWTON_STEPS):
        u = u - (u**2 / 2.0 + bend * u**3 / 3.0 - kept) / (u + bend * u**2)
    return 1.0 - u


def wall_stretches(depth: ArrayLike, bend: ArrayLike) -> tuple[Array, Array, Array]:
    """Stretches along, across (radial) and around the wall [-] at a depth (eq. 3.38-3.40)."""
    u = 1.0 - deformed_depth(depth, bend)
    along = 1.0 + np.asarray(bend, float) * u
    around = u / (1.0 - np.asarray(depth, float))
    return along, 1.0 / (along * around), around


def wall_strain_invariant(depth: ArrayLike, bend: ArrayLike) -> Array:
    """J1 = sum of the squared stretches - 3 [-] at a depth of the wall (Fig. 3.10).

    >>> wall_strain_invariant([0.0, 0.3, 0.5], 2.0).round(3).tolist()
    [7.111, 6.689, 7.386]
    """
    return np.sum(np.square(wall_stretches(depth, bend)), axis=0) - 3.0
