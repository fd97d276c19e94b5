"""Smoothing splines: the noise of readings is estimated from their residual."""

from __future__ import annotations

import numpy as np

from model_lab.aliases import Array, IntArray
from model_lab.measurements.preprocess import NORMAL_MEDIAN
from model_lab.rules import RULES

WHITE_BEND = 6.0  # variance of second differences of white noise of variance 1
SMOOTHINGS = (1e-9, 1e3, 60)


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
    """Mean square that a smoothing spline, chosen by cross-validation, leaves of values (n,).

    At a kink such a spline follows the noise, but second differences do not: the larger one of the
    two estimates is returned.
    """
    from scipy.interpolate import make_smoothing_spline  # here, as it takes long to load

    order = np.arange(len(values), dtype=float)
    left = float(np.mean((values - make_smoothing_spline(order, values)(order)) ** 2))
    bend = float(np.median(np.abs(np.diff(values, 2))))
    return max(left, (NORMAL_MEDIAN * bend) ** 2 / WHITE_BEND)
