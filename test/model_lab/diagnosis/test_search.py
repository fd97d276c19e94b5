"""What effects promise beside a model, and whether the samples can tell their times."""

from types import SimpleNamespace

import numpy as np
import pytest
from toy_forward import toy_forward, toy_set

from model_lab.diagnosis.search import Signature, is_resolved, promise, unusual
from model_lab.fitting.fit import Likelihood, fit
from model_lab.fitting.noise_floor import make_spectrum, noise_floor
from softhand_model.effects import effect_classes


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


@pytest.mark.parametrize(
    ("effect", "time", "answer"),
    [
        ("viscoelasticity", {"relaxation_time": 0.024}, False),
        ("viscoelasticity", {"relaxation_time": 0.06}, True),
        ("tube_lag", {"time_constant": 0.024}, True),
        ("hysteresis", {}, True),
    ],
)
def test_of_two_parameters_a_time_far_below_that_between_samples_is_not_told(effect, time, answer):
    data = toy_set(np.random.default_rng(0))  # sampled at 10 Hz
    kind = effect_classes()[effect]
    values = {f"{effect}.{p.name}": 1.0 for p in kind.parameters}
    values |= {f"{effect}.{name}": value for name, value in time.items()}
    likelihood = SimpleNamespace(names=list(values))
    found = SimpleNamespace(likelihood=likelihood, values=np.array(list(values.values())))
    assert is_resolved(data, found, kind) == answer


def parameter(effect, typical, logarithmic=False):
    made = SimpleNamespace(effect=effect, typical=typical, logarithmic=logarithmic, spread=np.inf)
    made.low, made.high, made.name = 1e-3, 1e3, "p"
    return made


@pytest.mark.parametrize(
    ("made", "value", "deviance"),
    [
        (parameter("viscoelasticity", (0.05, 0.5)), 0.3, 0.0),
        (parameter("viscoelasticity", (0.05, 0.5)), 0.5 + 0.225, 1.0),
        (parameter("viscoelasticity", (0.05, 0.5)), 4.4, (3.9 / 0.225) ** 2),
        (parameter("tube_lag", (0.1, 10.0), True), 0.01, 1.0),
        (parameter(None, (0.9, 1.1)), 5.0, 0.0),
    ],
)
def test_parameters_outside_of_their_usual_ranges_are_unlikely(made, value, deviance):
    forward = SimpleNamespace(parameters=[made])
    likelihood = Likelihood(forward, None, np.ones(1))
    found = SimpleNamespace(likelihood=likelihood, values=np.array([value]))
    assert unusual(found) == pytest.approx(deviance)
