"""Compiled, the observer's sums are those of equation 4.1 as `flow_rates` and numpy have them."""

import numpy as np
import pytest

from pneumaticbox_driver.observer.coefficients import PulseCoefficients, flow_rates
from pneumaticbox_driver.observer.pulses import (
    PulseIntegrals,
    injector_rate,
    predict_pulses,
    sum_terms,
)

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


def test_coefficients_are_equal_whatever_is_known_of_their_errors():
    sure, doubtful = (
        PulseCoefficients(1.0, 2.0, 3.0, 4.0, covariance=np.eye(5) * size) for size in (1.0, 2.0)
    )
    assert sure == doubtful != PulseCoefficients(1.0, 2.0, 3.0, 5.0)


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


@pytest.mark.parametrize("length", [0.005, 0.02])
def test_a_pulse_shorter_than_its_delay_of_opening_moves_nothing_by_its_length(length):
    delays = (np.array([[0.03], [0.01]]),) * 2
    c, found = np.array([[1e-6], [1e-11], [1e-10], [0.0], [0.0]]), np.empty((2, 1))
    predict_pulses(length, PRESSURES[:1], ENDS, (c, c), delays, found)
    assert found.ravel() == pytest.approx([1e-6, 1e-6])  # the bias alone


# ---------------------------------------------------------------- integrals under way
OPENING, CLOSING = 0.031, 0.022
START, SLOPE, SUPPLY = 1.5e5, 4e5, 4.0e5  # pressure [Pa] of the channel, and its rise [Pa/s]
AMBIENT = 1.013e5
STEPS = (0.004, 0.013, 0.009, 0.002, 0.017, 0.011, 0.006, 0.008, 0.012, 0.007)  # 89 ms
SUM_UP = np.cumsum(STEPS)


def pressure_at(time):
    return START + SLOPE * time


def drop_integral(inflating, start, stop):
    """Integral of the drop along the valve over the time [Pa s]."""
    middle = pressure_at(0.5 * (start + stop))
    return (stop - start) * (SUPPLY - middle if inflating else middle - AMBIENT)


def rate(inflating, time):
    return SUPPLY - pressure_at(time) if inflating else pressure_at(time) - AMBIENT


def begun(inflating, channels=1):
    pulse = PulseIntegrals(channels, AMBIENT)
    valves = np.full(channels, 1 if inflating else -1, dtype=np.int8)
    delays = np.repeat([[OPENING], [CLOSING]], channels, axis=1)
    here = np.full(channels, START)
    pulse.begin(np.ones(channels, bool), valves, here, SUPPLY, delays)
    return pulse


def advance(pulse, dt, time, supply=SUPPLY):
    pulse.advance(dt, np.full(len(pulse.lengths), pressure_at(time)), supply)


@pytest.mark.parametrize("inflating", [True, False])
def test_while_open_what_has_flowed_counts_and_what_the_delay_makes_inevitable(inflating):
    pulse = begun(inflating)
    for dt, now in zip(STEPS, SUM_UP, strict=True):
        advance(pulse, dt, now)
        flowed = drop_integral(inflating, OPENING, now) if now > OPENING else 0.0
        to_come = now + CLOSING - max(now, OPENING)
        expected = flowed + max(to_come, 0.0) * rate(inflating, now)
        assert pulse.values[1, 0] == pytest.approx(expected, rel=1e-9)
        assert pulse.rates[0, 0] == pytest.approx(rate(inflating, now))
        assert pulse.flowing[0] and pulse.lengths[0] == pytest.approx(now)


@pytest.mark.parametrize("inflating", [True, False])
def test_after_switch_off_the_flow_goes_on_until_the_valve_has_closed(inflating):
    pulse = begun(inflating)
    for dt, now in zip(STEPS[:5], SUM_UP[:5], strict=True):
        advance(pulse, dt, now)
    off = SUM_UP[4]
    pulse.end(np.array([True]))
    for dt, now in zip(STEPS[5:], SUM_UP[5:], strict=True):
        advance(pulse, dt, now)
        end = off + CLOSING
        expected = drop_integral(inflating, OPENING, min(now, end))
        expected += max(end - now, 0.0) * rate(inflating, now)
        # a sample across the end: the rate is linear over it
        assert pulse.values[1, 0] == pytest.approx(expected, rel=1e-9)
        assert pulse.flowing[0] == (now < end)
        assert pulse.lengths[0] == pytest.approx(off)


def test_the_injector_term_is_integrated_as_the_friction_term_is():
    pulse, constant = begun(True), np.array([START])
    for dt in STEPS:
        pulse.advance(dt, constant, SUPPLY)
    length = SUM_UP[-1] + CLOSING - OPENING
    assert pulse.values[2, 0] == pytest.approx(length * injector_rate(SUPPLY, START))
    assert pulse.values[1, 0] == pytest.approx(length * (SUPPLY - START))
    assert pulse.values[0, 0] == 1.0


def test_the_switching_terms_are_the_pressures_at_switch_off_upstream_and_at_the_start():
    pulse = begun(True)
    advance(pulse, 0.05, 0.05, supply=3.8e5)
    pulse.end(np.array([True]))
    advance(pulse, 0.05, 0.10, supply=3.7e5)
    assert pulse.values[3:, 0] == pytest.approx([3.8e5, START])
    out = begun(False)
    advance(out, 0.05, 0.05)
    assert out.values[3:, 0] == pytest.approx([START, AMBIENT])


def test_a_pulse_of_one_channel_leaves_that_of_another_and_has_delays_of_its_own():
    pair, alone = begun(True, channels=2), begun(True)
    for pulse in (pair, alone):
        advance(pulse, 0.04, 0.04)
    pair.end(np.array([False, True]))
    second, down = np.array([False, True]), np.array([1, -1], dtype=np.int8)
    pair.begin(second, down, np.full(2, pressure_at(0.04)), SUPPLY)
    for pulse in (pair, alone):
        advance(pulse, 0.05, 0.09)
    assert pair.values[:, 0] == pytest.approx(alone.values[:, 0])
    assert pair.lengths == pytest.approx([0.09, 0.05])
    # nominal delays of 30 ms each
    nominal = drop_integral(False, 0.07, 0.09) + 0.03 * rate(False, 0.09)
    assert pair.values[1, 1] == pytest.approx(nominal)


def test_no_time_changes_nothing_and_nothing_flows_before_the_first_pulse():
    pulse = PulseIntegrals(2, AMBIENT)
    assert not pulse.flowing.any()
    pulse = begun(True)
    before = pulse.values.copy()
    pulse.advance(0.0, np.array([9e5]), 9e5)
    assert np.array_equal(pulse.values, before) and pulse.lengths[0] == 0.0
