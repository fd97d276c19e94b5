"""What effects promise beside a model."""

import numpy as np
import pytest
from toy_forward import toy_forward, toy_set

from model_lab.diagnosis.search import Signature, promise
from model_lab.fitting.fit import Likelihood, fit
from model_lab.fitting.noise_floor import make_spectrum, noise_floor


def promised(kept):
    """What a change promises that is the residual of a fitted model in some bands (mask)."""
    data = toy_set(np.random.default_rng(0), gain=0.2)
    forward = toy_forward(data)
    spectrum = make_spectrum(data.table, forward.measured)
    floor = noise_floor(data, spectrum, np.random.default_rng(1).normal(0.0, 0.02, 1200))
    likelihood = Likelihood(forward, spectrum, floor.variance, gain_known=False)
    found = fit(likelihood, forward_start(forward))
    change = np.where(kept(spectrum.bands), found.coefficients, 0.0)
    whitened = 0.5 * change / np.sqrt(found.variance)[spectrum.bands]
    one = np.ones(1)
    made = Signature(one[:, None], np.zeros((2, 1)), whitened[None], one, one)
    return promise(made, found)


def forward_start(forward):
    return np.array([[parameter.start for parameter in forward.parameters]])


def test_an_effect_that_tells_runs_apart_promises_much_of_the_error():
    likelihood, share = promised(lambda bands: bands == 0)
    assert 0.9 < share <= 1.0
    assert likelihood > 0.0


def test_the_shape_of_mere_noise_promises_little_of_the_error():
    _, share = promised(lambda bands: bands > 0)
    assert share < 0.1


def test_a_change_the_wrong_way_promises_nothing():
    likelihood, share = promised(lambda bands: bands < 0)
    assert share == pytest.approx(0.0)
    assert likelihood == pytest.approx(0.0, abs=1e-6)
