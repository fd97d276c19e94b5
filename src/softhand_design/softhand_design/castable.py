"""Castability: limits of wall, chamber and taper for all designs, and side walls."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from softhand_common.numerics.arrays import Array

LARGEST_TAPER = 0.925  # of height and width, as of P10
TAPER_ROOT = {"height": 3.0, "width": 8.0, "circumference": 3.0}
LARGEST_SIDE_WALL = 1.0 / 3.0  # of the width, as of P5
LEAST_TIP_HEIGHT = 2.0  # over the wall [-]
LEAST_CHAMBER = 1e-3  # height of the chamber [m], for which a mould has room
LEAST_WALL = 1e-3  # [m]; the helix's groove takes 0.4 mm of it
SIZE_DIGITS = 7  # of the sizes of an actuator
CHAMBER_IS_FILLED = (
    f"at which the chamber is {1e3 * LEAST_CHAMBER:g} mm high (a stiffer actuator is higher, a "
    "stiffer rubber takes less wall)"
)


def side_wall(wall: ArrayLike, width: ArrayLike, share: float = 1.0) -> Array:
    """Thickness [m] of each side wall: a share [-] of the wall [m], a third of the width [m] at
    most.
    """
    return np.minimum(share * np.asarray(wall), LARGEST_SIDE_WALL * np.asarray(width))


def rounded(value: float) -> float:
    """A size rounded to the digits that files have."""
    return float(f"{value:.{SIZE_DIGITS}g}")
