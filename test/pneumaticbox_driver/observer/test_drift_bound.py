"""The drift bound against repeated calibrations: the truth lies within it about 95 times of 100."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_pulses import KNOWN, VENTING, design, noisy

from pneumaticbox_driver.calibration.regression import fit_channel
from pneumaticbox_driver.observer.coefficients import (
    ChannelCalibration,
    PulseCoefficients,
)
from pneumaticbox_driver.observer.observer import MassObserver

CLOSED, UP, DOWN = (np.array([v], dtype=np.int8) for v in (0, 1, -1))
SUPPLY = 400e3
JITTER = 1e-3  # [s]
CYCLES = 15


def pulse(observer, valves, length=0.05, pressure=125e3):
    """One pulse at constant pressures, and the pause after it."""
    here = np.full(len(valves), pressure)
    observer.switch(valves, here, SUPPLY)
    for _ in range(round(length / 0.01)):
        observer.advance(0.01, here, SUPPLY)
    observer.switch(np.zeros_like(valves), here, SUPPLY)
    for _ in range(7):
        observer.advance(0.01, here, SUPPLY)


def true_change(calibration):
    """What the cycles move if the coefficients are the true ones [kg]."""
    eye = MassObserver([calibration])
    for _ in range(CYCLES):
        pulse(eye, UP)
        pulse(eye, DOWN)
    return eye.mass[0]


def test_the_truth_is_within_the_bound_in_about_95_of_100_calibrations():
    random = np.random.default_rng(11)
    truth = true_change(ChannelCalibration(KNOWN, VENTING))
    up, down = design(True), design(False)
    flow = [1.2e-10 * 0.484 * SUPPLY, 9.8e-10 * 0.4 * 125e3]
    within = 0
    for _ in range(100):
        own = fit_channel(noisy(up, random, JITTER) + noisy(down, random, JITTER))
        eye = MassObserver([own])
        for _ in range(CYCLES):
            pulse(eye, UP)
            pulse(eye, DOWN)
        moved = truth + random.normal(0, JITTER * np.hypot(*flow) * np.sqrt(CYCLES))
        within += abs(moved - eye.mass[0]) < eye.drift_bound[0]
    assert 88 <= within <= 99


def known(covariance, jitter=0.0):
    sure = {"covariance": covariance, "jitter": jitter}
    return ChannelCalibration(replace(KNOWN, **sure), replace(VENTING, **sure))


def test_an_uncertain_bias_adds_up_pulse_by_pulse_and_jitter_by_its_square():
    bias = np.zeros((5, 5))
    bias[0, 0] = 1e-8**2
    eye = MassObserver([known(bias)])
    for count in range(1, 6):
        pulse(eye, UP)
        assert eye.pulses[0] == count
        assert eye.drift_bound[0] == pytest.approx(2 * count * 1e-8)
    scattered = MassObserver([known(np.zeros((5, 5)), 1e-3)])
    bounds = []
    for _ in range(9):
        pulse(scattered, UP)
        bounds.append(scattered.drift_bound[0])
    assert bounds[8] == pytest.approx(3 * bounds[0])


def test_the_bound_of_a_linear_model_is_its_covariance_in_the_summed_regressors():
    (fit,) = [fit_channel(noisy(design(True) + design(False), np.random.default_rng(1), 0.0))]
    eye = MassObserver([fit])
    pressure, length, pulses = 125e3, 0.05, 3
    for _ in range(pulses):
        pulse(eye, UP, length, pressure)
    friction, injector = (SUPPLY - pressure) * length, SUPPLY * 0.48418 * length
    columns = np.array([1.0, friction, injector, SUPPLY, pressure])
    variance = pulses**2 * columns @ fit.inflate.covariance @ columns
    flow = (fit.inflate.friction * columns[1] + fit.inflate.injector * columns[2]) / length
    expected = 2 * np.sqrt(variance + pulses * (fit.inflate.jitter * flow) ** 2)
    assert eye.drift_bound[0] == pytest.approx(expected, rel=1e-3)


def test_a_known_mass_begins_the_bound_anew_for_its_channel_alone():
    bias = np.diag([1e-16, 0, 0, 0, 0])
    eye = MassObserver([known(bias)] * 2)
    pulse(eye, np.array([1, 1], dtype=np.int8))
    eye.set_mass(0, 3e-6)
    assert eye.pulses.tolist() == [0, 1]
    assert eye.drift_bound[0] == 0.0 < eye.drift_bound[1]


def test_other_coefficients_keep_the_estimate_and_the_bound_so_far():
    bias = np.diag([1e-16, 0, 0, 0, 0])
    eye = MassObserver([known(bias)])
    pulse(eye, UP)
    mass, bound = eye.mass.copy(), eye.drift_bound.copy()
    other = PulseCoefficients(0.0, 0.0, 1e-10, 0.0)
    eye.set_calibrations([ChannelCalibration(other, other)])
    np.testing.assert_array_equal(eye.mass, mass)
    np.testing.assert_allclose(eye.drift_bound, bound)
    pulse(eye, UP)
    added = 1e-10 * SUPPLY * 0.48418 * 0.05
    assert eye.mass[0] - mass[0] == pytest.approx(added, rel=1e-4)
    np.testing.assert_allclose(eye.drift_bound, bound)
    with pytest.raises(ValueError, match="calibrations must be 1, one per channel, got 2"):
        eye.set_calibrations([known(bias)] * 2)
