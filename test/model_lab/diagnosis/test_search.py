"""What effects promise beside a model."""

from types import SimpleNamespace

import numpy as np
import pytest
from toy_forward import toy_forward, toy_set

from model_lab.diagnosis.search import Signature, promise, signature, starts
from model_lab.fitting.fit import Likelihood, fit
from model_lab.fitting.noise_floor import make_spectrum, noise_floor
from softhand_model.effects.effect import Parameter


def fitted():
    """A fitted model, and its spectrum."""
    data = toy_set(np.random.default_rng(0), gain=0.2)
    forward = toy_forward(data)
    spectrum = make_spectrum(data.table, forward.measured)
    floor = noise_floor(data, spectrum, np.random.default_rng(1).normal(0.0, 0.02, 1200))
    likelihood = Likelihood(forward, spectrum, floor.variance, gain_known=False)
    return fit(likelihood, forward_start(forward)), spectrum


def promised(kept):
    """What a change promises that is the residual of a fitted model in some bands (mask)."""
    found, spectrum = fitted()
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


def test_no_search_begins_where_an_effect_leaves_no_equilibrium():
    """Though every other trial value makes the error larger."""
    found, spectrum = fitted()

    def residuals(values):
        left = found.residual * (1.0 + values[:, -1:])
        return np.where((values[:, -1:] > 3.0) & (np.arange(1200) < 100), np.nan, left)

    size = Parameter("size", "", 0.0, 10.0, "", (1.0, 5.0), neutral=0.0)
    effect = SimpleNamespace(name="load", parameters=(size,))
    own = SimpleNamespace(name="load.size", effect="load", start=1.0)
    parameters = [*found.likelihood.parameters, own]
    likelihood = SimpleNamespace(parameters=parameters, spectrum=spectrum, residuals=residuals)
    seen = signature(likelihood, found, effect)
    assert np.all(starts(seen, found) <= 3.0)
    assert np.all(np.isfinite(seen.raw))
