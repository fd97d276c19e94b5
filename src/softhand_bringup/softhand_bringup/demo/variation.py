"""How the seed changes the demo: where the object lies and how heavy it is."""

from __future__ import annotations

import numpy as np

OFFSET = 0.010  # [m] in x and in y, either way
MASS = 0.20  # part of the mass, either way


def vary(seed: int) -> tuple[tuple[float, float], float]:
    """Shift of the object (x, y) [m] and factor on its mass [-] for a seed.

    >>> (x, y), mass_scale = vary(3)
    >>> abs(x) <= 0.010 and abs(y) <= 0.010 and 0.8 <= mass_scale <= 1.2
    True
    """
    draw = np.random.default_rng(seed).uniform(-1.0, 1.0, 3)
    return (float(OFFSET * draw[0]), float(OFFSET * draw[1])), float(1.0 + MASS * draw[2])
