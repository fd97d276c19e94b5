"""Residual tests within runs, on residuals whose correlations are known."""

from __future__ import annotations

import numpy as np
import pytest

from model_lab.bench.synthesize import synthesize
from model_lab.series.within_runs import residual_tests


@pytest.fixture(scope="module")
def data():
    return synthesize("free_bending", 3, False).data


@pytest.fixture
def white(data):
    return 0.01 * np.random.default_rng(1).standard_normal(data.table.samples)


def test_white_noise_is_within_its_bands(data, white):
    found = residual_tests(data, white)
    assert abs(found.autocorrelation[1]) < found.white_band
    assert np.max(np.abs(found.input_correlation)) < found.input_band
    assert not found.follows_input


def test_neighbours_that_share_noise_correlate_as_calculated(data, white):
    """A mean of two neighbours has an autocorrelation of 1/2 at a lag of one, 0 at two."""
    found = residual_tests(data, white + np.roll(white, 1))
    assert found.autocorrelation[1:3] == pytest.approx([0.5, 0.0], abs=0.05)
    assert found.white_p_value < 1e-6
    assert not found.follows_input


def test_scale_and_zero_of_a_run_do_not_count(data, white):
    gain = np.random.default_rng(2).normal(0.0, 0.05, data.table.runs)[data.table.run]
    measured = data.table.value
    scaled = white + gain * (measured - white)
    assert residual_tests(data, scaled).autocorrelation[1] < 0.3
    assert np.corrcoef(scaled[1:], scaled[:-1])[0, 1] > 0.9


def test_an_error_that_lags_behind_the_input_is_found(data, white):
    late = np.concatenate([np.roll(data.driving(run), 10) - data.driving(run) for run in data.runs])
    found = residual_tests(data, white + 0.05 * late / late.std())
    assert found.follows_input
    assert np.max(np.abs(found.input_correlation)) > found.input_band
