"""Where the object of a trial lies and how heavy it is, drawn from the trial's seed."""

from __future__ import annotations

import numpy as np

OFFSET = 0.010  # largest shift of the object in x and in y [m]
MASS_SPREAD = 0.20  # largest change of the object's mass, as a share of it


def draw_placement(
    seed: int, offset: float = OFFSET, mass_spread: float = MASS_SPREAD
) -> tuple[tuple[float, float], float]:
    """Shift of the object (x, y) [m] and factor on its mass [-], uniform, for a seed.

    Seeds do not share numbers, and the draw does not depend on how many trials there are.

    Args:
        seed: of the trial.
        offset: largest shift in x and in y [m].
        mass_spread: largest change of the mass, as a share of it [-].

    >>> (x, y), mass_scale = draw_placement(3)
    >>> abs(x) <= 0.010 and abs(y) <= 0.010 and 0.8 <= mass_scale <= 1.2
    True
    """
    draw = np.random.default_rng(seed).uniform(-1.0, 1.0, 3)
    x, y = (offset * draw[:2]).tolist()
    return (x, y), float(1.0 + mass_spread * draw[2])
