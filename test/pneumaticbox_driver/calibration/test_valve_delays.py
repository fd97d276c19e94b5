"""Delays read from a step of the pressure, against the valves of the bench that made it."""

import numpy as np
import pytest

from pneumaticbox_driver.calibration.command import BOTTLE, record_on_rig
from pneumaticbox_driver.calibration.valve_delays import PulseTrace, valve_delays
from pneumaticbox_driver.observer.coefficients import NOMINAL_DELAYS
from pneumaticbox_driver.observer.pulses import PulseIntegrals
from softhand_model.gas import AMBIENT_PRESSURE
from softhand_model.pneumatics import PneumaticPlant

RAMP = 8e3  # of the pressure while air flows [Pa/s]


def trace(opening, closing, length=0.1, step=500.0, direction=-1, noise=0.0, seed=0):
    """A pressure that falls while air flows, and is lower by a step at the sensor."""
    times = np.arange(0.0, length + 0.1, 0.002)
    flowing = np.clip(times - opening, 0.0, length + closing - opening)
    through = (times >= opening) & (times < length + closing)
    pressures = 120e3 + direction * (RAMP * flowing + step * through)
    pressures = pressures + np.random.default_rng(seed).normal(0, noise, len(times))
    after = 120e3 + direction * RAMP * (length + closing - opening)
    return PulseTrace(times, pressures, length, 120e3, after, direction)


@pytest.mark.parametrize(
    ("opening", "closing"), [(0.021, 0.039), (0.037, 0.023), (0.03, 0.03), (0.003, 0.002)]
)
def test_the_delays_are_where_the_step_begins_and_ends(opening, closing):
    traces = [trace(opening, closing, length, noise=60.0, seed=k) for k, length in LENGTHS]
    found = valve_delays(traces, 60.0)
    np.testing.assert_allclose(found, (opening, closing), atol=1.5e-3)


LENGTHS = list(enumerate(np.linspace(0.046, 0.5, 20).round(3)))


def test_pulses_too_short_to_tell_the_opening_tell_no_closing_before_it_either():
    opening, closing = valve_delays(
        [trace(0.003, 0.002, length) for length in (0.008, 0.012)], 60.0
    )
    assert closing >= opening


def test_without_a_clear_step_the_delays_are_the_nominal_ones():
    flat = [
        PulseTrace(t.times, np.full_like(t.times, 120e3), t.length, 120e3, 120e3, -1)
        for t in [trace(0.03, 0.03)]
    ]
    assert valve_delays(flat, 60.0) == NOMINAL_DELAYS
    assert valve_delays([], 60.0) == NOMINAL_DELAYS


def test_on_the_bench_they_are_those_of_the_valves_but_for_the_lag_of_the_sensor():
    (pulses,) = record_on_rig(12, 3, 1, BOTTLE, 300e3)
    valves = PneumaticPlant(["a"], [BOTTLE])._valves
    opening, closing = next(p.delays for p in pulses if not p.inflating)
    assert opening - valves.opening_delay[0, 0] == pytest.approx(2e-3, abs=1e-3)
    assert closing - valves.closing_delay[0, 0] == pytest.approx(2.5e-3, abs=1.5e-3)


def test_the_integrals_run_from_the_opening_to_the_closing():
    integrals = PulseIntegrals(1)
    begun, supply = np.array([True]), 400e3
    delays = np.array([[0.02], [0.035]])
    integrals.begin(begun, np.array([-1]), np.array([150e3]), supply, delays)
    fall, time = 400e3, 0.0
    while integrals.flowing.any():
        time += 0.002
        integrals.advance(0.002, np.array([150e3 - fall * time]), supply)
        if time > 0.05 - 1e-9:
            integrals.end(begun)
    start, end = 0.02, 0.05 + 0.035
    exact = (150e3 - AMBIENT_PRESSURE) * (end - start) - fall * (end**2 - start**2) / 2
    assert integrals.values[1, 0] == pytest.approx(exact, rel=1e-9)
    assert integrals.values[3, 0] == 150e3


def test_while_it_flows_what_is_to_come_counts_at_the_present_rate():
    integrals = PulseIntegrals(1)
    begun, p = np.array([True]), np.array([150e3])
    integrals.begin(begun, np.array([-1]), p, 400e3, np.array([[0.02], [0.035]]))
    for _ in range(4):
        integrals.advance(0.01, p, 400e3)
        expected = (150e3 - AMBIENT_PRESSURE) * max(integrals.lengths[0] + 0.015, 0.0)
        assert integrals.values[1, 0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(("direction", "upstream"), [(1, 396e3), (-1, 150e3)])
def test_the_inlet_switches_at_the_supply_of_its_closing_the_outlet_at_that_of_its_opening(
    direction, upstream
):
    integrals = PulseIntegrals(1)
    begun = np.array([True])
    integrals.begin(begun, np.array([direction]), np.array([150e3]), 400e3)
    for k in range(1, 21):
        # meanwhile other channels open and close
        integrals.advance(0.002, np.array([150e3 - direction * 100.0 * k]), 400e3 - 200.0 * k)
    integrals.end(begun)
    integrals.advance(0.002, np.array([149e3]), 399e3)
    assert integrals.flowing.all()
    assert integrals.values[3, 0] == pytest.approx(upstream, rel=1e-12)


def test_noise_at_ambient_pressure_does_not_add_up_to_a_flow():
    random = np.random.default_rng(2)
    integrals = PulseIntegrals(200)
    every = np.ones(200, dtype=bool)
    integrals.begin(every, -np.ones(200), np.full(200, AMBIENT_PRESSURE), 400e3)
    for _ in range(1000):
        integrals.advance(2e-3, AMBIENT_PRESSURE + random.normal(0, 60.0, 200), 400e3)
    flows = 9.8e-10 * integrals.values[2]  # in 2 s, with an outlet's coefficient [kg]
    assert abs(flows.mean()) < 4 * flows.std() / np.sqrt(200)
    assert flows.std() < 0.5e-6
