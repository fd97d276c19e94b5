"""Smoothing splines: the noise of readings is estimated from their residual."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from model_lab.aliases import Array, IntArray
from model_lab.measurements.preprocess import NORMAL_MEDIAN
from model_lab.rules import RULES

WHITE_BEND = 6.0  # variance of second differences of white noise of variance 1
SMOOTHINGS = (1e-9, 1e3, 60)
KEPT_LENGTHS = 16  # of series of readings, whose splines are kept


def short_spline_rest(place: Array, values: Array) -> tuple[float, float]:
    """(sum of squares, its degrees of freedom) that a natural smoothing spline, chosen by
    generalised cross-validation, leaves of values (n,) at places (n,) in any order; zeros for fewer
    than RULES.short_spline_samples places.
    """
    knots, index = np.unique(place, return_inverse=True)
    if len(knots) < RULES.short_spline_samples:
        return 0.0, 0.0
    level, modes = _spline_modes(knots, index)
    along = modes.T @ values
    kept = 1.0 / (1.0 + np.outer(np.geomspace(*SMOOTHINGS), level))
    freedom = len(values) - kept.sum(axis=1)
    rest = np.sum(((1.0 - kept) * along) ** 2, axis=1) + np.sum((values - modes @ along) ** 2)
    score = np.where(freedom > RULES.spline_freedom * len(values), rest / freedom**2, np.inf)
    best = int(np.argmin(score))
    return float(rest[best]), float(freedom[best])


def _spline_modes(knots: Array, index: IntArray) -> tuple[Array, Array]:
    """Roughness (k,) and orthonormal shapes (n, k) of natural cubic splines with these knots, seen
    at the readings, of which index (n,) gives the knot.
    """
    step = np.diff(knots) / np.ptp(knots)
    count = len(knots) - 2
    bends = np.zeros((count, len(knots)))
    rows = np.arange(count)
    bends[rows, rows], bends[rows, rows + 2] = 1.0 / step[:-1], 1.0 / step[1:]
    bends[rows, rows + 1] = -1.0 / step[:-1] - 1.0 / step[1:]
    overlap = np.diag((step[:-1] + step[1:]) / 3.0)
    overlap += np.diag(step[1:-1] / 6.0, 1) + np.diag(step[1:-1] / 6.0, -1)
    roughness = bends.T @ np.linalg.solve(overlap, bends)
    weight = np.sqrt(np.bincount(index))
    level, shapes = np.linalg.eigh(roughness / np.outer(weight, weight))
    return np.maximum(level, 0.0), (shapes / weight[:, None])[index]


def spline_square(values: Array) -> float:
    """Mean square that a natural smoothing spline, chosen by generalised cross-validation (Wahba,
    Spline Models for Observational Data, SIAM 1990, eq. 4.3.1), leaves of values (n,) at even
    distances.

    At a kink such a spline follows the noise, but second differences do not: the larger one of the
    two estimates is returned.
    """
    from scipy.optimize import minimize_scalar  # here, as it takes long to load

    count = len(values)
    level, modes = _even_modes(count)
    square = (modes.T @ values) ** 2

    def rest(smoothing: float) -> tuple[float, float]:
        """(mean square, share of degrees of freedom) that is left."""
        lost = smoothing * level / (1.0 + smoothing * level)
        return float(lost**2 @ square) / count, float(lost.sum()) / count

    def score(smoothing: float) -> float:
        left, freedom = rest(smoothing)
        return left / freedom**2

    best = minimize_scalar(score, bounds=(0.0, count), method="bounded")
    bend = float(np.median(np.abs(np.diff(values, 2))))
    return max(rest(best.x)[0], (NORMAL_MEDIAN * bend) ** 2 / WHITE_BEND)


@lru_cache(maxsize=KEPT_LENGTHS)
def _even_modes(count: int) -> tuple[Array, Array]:
    """As `_spline_modes`, of so many readings at a distance of 1."""
    order = np.arange(count)
    level, modes = _spline_modes(order.astype(float), order)
    return level / (count - 1.0) ** 3, modes
