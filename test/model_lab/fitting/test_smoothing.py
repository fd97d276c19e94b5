"""Smoothing splines by their modes, against those of scipy by banded matrices."""

import numpy as np
import pytest
from scipy.interpolate import make_smoothing_spline

from model_lab.fitting.smoothing import spline_square

PLACE = np.linspace(0.0, 1.0, 90)
NOISE = np.random.default_rng(2).standard_normal(90)
COURSES = {
    "noise": NOISE,
    "a wave": np.sin(9.0 * PLACE) + 0.02 * NOISE,
    "a walk": np.cumsum(NOISE),
    "a tiny step": 1e-6 * (PLACE > 0.5) + 1e-7 * NOISE,
}


@pytest.mark.parametrize("values", COURSES.values(), ids=COURSES)
@pytest.mark.parametrize("count", [9, 40, 90])
def test_a_spline_leaves_what_one_by_banded_matrices_leaves(values, count):
    order, values = np.arange(float(count)), values[:count]
    left = np.mean((values - make_smoothing_spline(order, values)(order)) ** 2)
    bend = np.median(np.abs(np.diff(values, 2)))
    assert spline_square(values) == pytest.approx(max(left, (bend / 0.6745) ** 2 / 6.0), rel=1e-4)
