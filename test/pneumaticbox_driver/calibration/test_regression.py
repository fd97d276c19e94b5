"""Uncertainty of equation 4.1's coefficients against repeated noise; designs that cannot do."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_pulses import SENSOR, VENTING, design, noisy

from pneumaticbox_driver.calibration.regression import fit_pulses, refuse_singular, regressors


@pytest.mark.parametrize("jitter", [0.0, 1.5e-3], ids=["sensor", "sensor and delays"])
@pytest.mark.parametrize("inflating", [True, False], ids=["inflate", "deflate"])
def test_the_covariance_is_that_of_repeated_fits(inflating, jitter):
    random = np.random.default_rng(3)
    pulses = design(inflating)
    fits = [fit_pulses(noisy(pulses, random, jitter)) for _ in range(300)]
    found = np.array([fit.as_array() for fit in fits])
    stated = np.mean([fit.covariance for fit in fits], axis=0)
    # of what a controller wants to know: the mass of short pulses and of many together
    for rows in (regressors(pulses[:1])[0], regressors(pulses).sum(axis=0)):
        spread = np.std(found @ rows)
        assert np.sqrt(rows @ stated @ rows) == pytest.approx(spread, rel=0.2)
    terms = slice(0, 5 if inflating else 4)
    ratio = np.sqrt(np.diag(stated))[terms] / found.std(axis=0)[terms]
    assert (np.abs(ratio - 1) < 0.25).all()


def test_the_scatter_of_the_delays_is_found_beside_the_noise_of_the_sensor():
    random = np.random.default_rng(5)
    pulses = design(False, count=400, durations=(0.045, 0.2))
    found = [fit_pulses(noisy(pulses, random, 1.5e-3)).jitter for _ in range(20)]
    assert np.mean(found) == pytest.approx(1.5e-3, rel=0.15)
    assert np.mean([fit_pulses(noisy(pulses, random, 0.0)).jitter for _ in range(20)]) < 0.3e-3


def test_weights_bring_the_many_short_pulses_nearer_than_equal_weights_do():
    random = np.random.default_rng(7)
    pulses = design(False, durations=(0.045, 1.0))
    short = regressors([p for p in pulses if p.duration < 0.2]).sum(axis=0)
    errors = {SENSOR: [], 0.0: []}
    for _ in range(200):
        # long pulses leave what equation 4.1 does not say, 2 % of their mass
        measured = [
            replace(p, mass=p.mass * (1 + random.normal(0, 0.02)) + random.normal(0, SENSOR))
            for p in pulses
        ]
        for known, error in errors.items():
            fit = fit_pulses([replace(p, noise=known) for p in measured])
            error.append(short @ (fit.as_array() - VENTING.as_array()))
    assert np.std(errors[SENSOR]) < 0.7 * np.std(errors[0.0])


@pytest.mark.parametrize(
    ("pulses", "named"),
    [
        (design(True, supplies=(400e3,)), ("bias", "switch_in")),
        (design(False, durations=(0.1, 0.1)), ("friction", "switch_in")),
    ],
    ids=["one supply pressure", "one duration"],
)
def test_a_design_that_leaves_terms_undetermined_is_refused_and_they_are_named(pulses, named):
    with pytest.raises(ValueError, match="do not separate") as error:
        fit_pulses(pulses)
    assert all(term in str(error.value) for term in named)


def test_with_the_ambient_column_deflation_is_singular_as_algorithm_1_lists_it():
    full = regressors(design(False))
    terms = ("bias", "friction", "injector", "switch_in", "switch_out")
    with pytest.raises(ValueError, match="do not separate bias from switch_out"):
        refuse_singular(full / np.sqrt(np.mean(full**2, axis=0)), terms)
    assert fit_pulses(design(False)).switch_out == 0.0
