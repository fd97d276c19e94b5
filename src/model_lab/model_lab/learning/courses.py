"""Shape of a learned curve: where it bends, and how it changes small and large predictions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from model_lab.aliases import Array
from model_lab.learning.effect_file import FLATTENS, GROWS, SETS_IN

EVEN_KNOTS = 0.5  # share of knots that lie evenly, over that of those where a curve bends
PREDICTION_RANGES = (0.05, 0.35), (0.35, 0.65), (0.65, 1.1)  # of the largest prediction


def where_it_bends(places: Sequence[float], values: Array) -> tuple[float, ...]:
    """Knots between the same ends and in the same number, but closer where a curve through the
    values bends.

    >>> [round(x, 1) for x in where_it_bends((0, 1, 2, 3, 4), np.array([0.0, 0.0, 0.0, 1.0, 1.0]))]
    [0.0, 1.6, 2.5, 3.2, 4.0]
    """
    at = np.asarray(places, float)
    slope = np.diff(values) / np.diff(at)
    bend = np.abs(np.diff(slope)) / (0.5 * (at[2:] - at[:-2]))
    density = np.sqrt(np.interp(0.5 * (at[1:] + at[:-1]), at[1:-1], bend))
    density = density + EVEN_KNOTS * (density @ np.diff(at) / np.ptp(at) or 1.0)
    so_far = np.concatenate([[0.0], np.cumsum(density * np.diff(at))])
    even = np.linspace(0.0, so_far[-1], len(at))
    return tuple(np.interp(even, so_far, at).tolist())


def answer_of(measured: Array, before: Array, after: Array) -> str:
    """How a curve changes the predictions of a model: `flattens` (large predictions are lowered
    most), `sets_in` (small predictions are raised most), or `grows` for anything else.

    measured, before, after (samples,): measured values, and residuals without and with the curve.
    """
    plain = measured - before
    share = np.abs(plain) / (np.abs(plain).max() or 1.0)
    gains = []
    for low, high in PREDICTION_RANGES:
        mine = (share >= low) & (share < high)
        square = float(plain[mine] @ plain[mine])
        gains.append(float(plain[mine] @ (measured - after)[mine]) / square if square else 1.0)
    small, middle, large = gains
    if middle - large > abs(small - middle):
        return FLATTENS
    return SETS_IN if middle - small > abs(large - middle) else GROWS
