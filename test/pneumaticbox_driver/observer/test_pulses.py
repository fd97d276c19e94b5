"""Compiled, the observer's sums are those of equation 4.1 as `flow_rates` and numpy have them."""

import numpy as np
import pytest

from pneumaticbox_driver.observer.coefficients import flow_rates
from pneumaticbox_driver.observer.pulses import injector_rate, predict_pulses, sum_terms

N = 6
RANDOM = np.random.default_rng(5)
PRESSURES = RANDOM.uniform(1e5, 3e5, N)
ENDS = (3.6e5, 1.013e5)
COEFFICIENTS = RANDOM.normal(0.0, 1.0, (2, 5, N)) * [[1e-6], [1e-11], [1e-10], [1e-11], [1e-11]]
DELAYS = RANDOM.uniform(0.02, 0.04, (2, 2, N))


def test_the_injector_rate_is_that_of_the_flow_model_both_ways_and_without_a_drop():
    upstream = np.array([3e5, 1e5, 1.2e5, 1.1e5, 1e5, 3.9e5])
    downstream = np.array([1e5, 3e5, 1.1e5, 1.2e5, 1e5, 3.8e5])
    ours = [injector_rate(*pair) for pair in zip(upstream, downstream, strict=True)]
    assert ours == pytest.approx(flow_rates(upstream, downstream)[1], rel=1e-12, abs=1e-12)
    assert ours[0] == pytest.approx(3e5 * 0.4842, rel=1e-4)  # choked


def test_a_predicted_pulse_is_equation_4_1_at_constant_pressures():
    found = np.empty((2, N))
    predict_pulses(0.05, PRESSURES, ENDS, tuple(COEFFICIENTS), tuple(DELAYS), found)
    ways = [(np.full(N, ENDS[0]), PRESSURES), (PRESSURES, np.full(N, ENDS[1]))]
    for mass, c, (opening, closing), ends in zip(found, COEFFICIENTS, DELAYS, ways, strict=True):
        length = 0.05 + closing - opening
        friction, injector = flow_rates(*ends)
        terms = np.array([np.ones(N), length * friction, length * injector, *ends])
        assert mass == pytest.approx(np.maximum((c * terms).sum(axis=0), 0.0), rel=1e-12)


def test_summed_terms_have_the_sign_of_the_pulse_and_the_flow_that_of_the_valve():
    values, rates = RANDOM.uniform(0, 1e4, (5, N)), RANDOM.uniform(0, 1e5, (2, N))
    sign = np.array([1.0, -1.0, 0.0, 1.0, -1.0, 0.0])
    direction = np.array([1, -1, 0, 0, -1, 0], dtype=np.int8)
    c, found = COEFFICIENTS[0], np.empty((2, N))
    sum_terms(c, values, rates, sign, direction, found)
    assert found[0] == pytest.approx(sign * np.maximum(np.einsum("tn,tn->n", c, values), 0.0))
    assert found[1] == pytest.approx(direction * (c[1] * rates[0] + c[2] * rates[1]))
    assert (found[1] != 0).any() and (found[0] != 0).any()


def test_compiled_and_plain_kernels_agree():
    compiled, plain = np.empty((2, N)), np.empty((2, N))
    given = (0.03, PRESSURES, ENDS, tuple(COEFFICIENTS), tuple(DELAYS))
    predict_pulses(*given, compiled)
    predict_pulses.py_func(*given, plain)
    assert compiled == pytest.approx(plain, rel=1e-12)
