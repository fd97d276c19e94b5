"""The observer's mass against the truth of the bench, for any spacing of the samples."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from bottle_rig import BottleRig

from pneumaticbox_driver.observer.coefficients import ChannelCalibration, Leak, PulseCoefficients
from pneumaticbox_driver.observer.observer import MassObserver
from softhand_model.gas import AMBIENT_PRESSURE, psi

MG = 1e-6
PULSE = PulseCoefficients(1e-8, 2e-13, 1.2e-10, 3e-12, -1e-12)
VENT = PulseCoefficients(-2e-8, 1e-12, 9e-10, 2e-12)


def observer(channels=1):
    return MassObserver([ChannelCalibration(PULSE, VENT)] * channels)


def test_a_pulse_at_constant_pressures_moves_what_equation_4_1_says():
    eye = observer()
    p, supply = np.array([150e3]), 400e3
    eye.switch(np.array([1], dtype=np.int8), p, supply)
    for dt in (0.002, 0.005, 0.043):
        eye.advance(dt, p, supply)
    by_hand = 1e-8 + 2e-13 * 250e3 * 0.05 + 1.2e-10 * 400e3 * float(psi(0.375)) * 0.05
    by_hand += 3e-12 * 400e3 - 1e-12 * 150e3
    assert eye.mass[0] == pytest.approx(by_hand, rel=1e-9)


def test_deflation_takes_the_channel_as_upstream_and_ambient_as_downstream():
    eye = observer()
    p, supply = np.array([150e3]), 400e3
    eye.switch(np.array([-1], dtype=np.int8), p, supply)
    eye.advance(0.05, p, supply)
    ratio = AMBIENT_PRESSURE / 150e3
    taken = -2e-8 + 1e-12 * (150e3 - AMBIENT_PRESSURE) * 0.05 + 2e-12 * 150e3
    taken += 9e-10 * 150e3 * float(psi(ratio)) * 0.05
    assert eye.mass[0] == pytest.approx(-taken, rel=1e-9)
    assert eye.flow[0] < 0


def test_the_integral_of_a_ramp_does_not_depend_on_how_it_is_sampled():
    def final(times):
        eye, supply = observer(), 400e3
        eye.switch(np.array([1], dtype=np.int8), np.array([120e3]), supply)
        for before, now in pairwise(times):
            eye.advance(now - before, np.array([120e3 + 50e3 * now]), supply)
        return eye.mass[0]

    random = np.random.default_rng(0)
    jittered = np.concatenate([[0.0], np.sort(random.uniform(0, 1, 200)), [1.0]])
    assert final(jittered) == pytest.approx(final(np.linspace(0, 1, 501)), rel=1e-6)


def test_switching_one_channel_leaves_the_pulse_of_another_alone():
    pair, alone = observer(2), observer(1)
    p, supply = np.array([150e3, 140e3]), 400e3
    pair.switch(np.array([1, 0], dtype=np.int8), p, supply)
    alone.switch(np.array([1], dtype=np.int8), p[:1], supply)
    for k in range(20):
        pair.advance(0.002, p, supply)
        alone.advance(0.002, p[:1], supply)
        pair.switch(np.array([1, k % 2], dtype=np.int8), p, supply)
    assert pair.mass[0] == pytest.approx(alone.mass[0], rel=1e-12)
    assert pair.mass[1] > 0


def test_a_closed_channel_keeps_its_mass_whatever_its_pressure_does():
    eye = observer()
    eye.set_mass(0, 12 * MG)
    for pressure in (101e3, 180e3, 90e3):
        eye.advance(0.1, np.array([pressure]), 400e3)
    assert eye.mass[0] == 12 * MG
    assert eye.flow[0] == 0.0


def test_a_leak_of_the_calibration_is_taken_off_above_ambient_pressure_if_asked():
    eye = MassObserver([ChannelCalibration(PULSE, VENT, leak=Leak(2e-12))] * 2)
    eye.set_mass(0, 12 * MG)
    eye.set_mass(1, 12 * MG)
    pressures = np.array([AMBIENT_PRESSURE + 50e3, AMBIENT_PRESSURE - 5e3])
    eye.advance(3.0, pressures, 400e3)
    assert eye.mass == pytest.approx([12 * MG] * 2)
    eye.leak_model = True
    eye.advance(3.0, pressures, 400e3)
    assert eye.mass == pytest.approx([12 * MG - 3.0 * 2e-12 * 50e3, 12 * MG])


def test_a_pulse_that_follows_before_the_last_has_closed_adds_to_it():
    up, down = np.array([1], dtype=np.int8), np.array([-1], dtype=np.int8)
    p, supply = np.array([150e3]), 400e3
    eye, one, other = observer(), observer(), observer()
    for observed, valves in ((eye, up), (one, up)):
        observed.switch(valves, p, supply)
        observed.advance(0.05, p, supply)
    brought = one.mass[0]
    for observed in (eye, other):
        observed.switch(down, p, supply)
        observed.advance(0.05, p, supply)
        assert observed.flow[0] < 0
    assert eye.mass[0] == pytest.approx(brought + other.mass[0], rel=1e-12)
    assert eye.moved[0] == pytest.approx(other.moved[0], rel=1e-12)


def test_a_closed_valve_has_no_flow_and_its_pulse_ends_with_the_delay():
    eye, p, supply = observer(), np.array([150e3]), 400e3
    eye.switch(np.array([1], dtype=np.int8), p, supply)
    eye.advance(0.05, p, supply)
    assert eye.flow[0] == pytest.approx(2e-13 * 250e3 + 1.2e-10 * 400e3 * float(psi(0.375)))
    eye.switch(np.array([0], dtype=np.int8), p, supply)
    assert eye.flow[0] == 0.0
    eye.advance(0.02, p, supply)
    assert eye.moved[0] > 0 and eye.pulses[0] == 0
    before = eye.mass[0]
    eye.advance(0.02, p, supply)
    assert eye.moved[0] == 0.0 and eye.pulses[0] == 1
    assert eye.mass[0] == pytest.approx(before)
    eye.advance(0.5, np.array([250e3]), 100e3)
    assert eye.mass[0] == pytest.approx(before)


def test_a_mass_that_is_set_in_a_pulse_stays_until_the_next():
    eye, p, supply = observer(), np.array([150e3]), 400e3
    eye.switch(np.array([1], dtype=np.int8), p, supply)
    eye.advance(0.02, p, supply)
    eye.set_mass(0, 3 * MG)
    eye.advance(0.02, p, supply)
    assert eye.mass[0] == 3 * MG
    eye.switch(np.array([0], dtype=np.int8), p, supply)
    eye.advance(0.1, p, supply)
    assert eye.mass[0] == 3 * MG and eye.pulses[0] == 0


def test_a_pulse_of_no_length_brings_an_uncertainty_that_is_finite():
    sure = replace(PULSE, jitter=1e-3)
    eye, p, supply = MassObserver([ChannelCalibration(sure, VENT)]), np.array([150e3]), 400e3
    eye.switch(np.array([1], dtype=np.int8), p, supply)
    eye.switch(np.array([0], dtype=np.int8), p, supply)
    eye.advance(0.1, p, supply)
    assert eye.pulses[0] == 1
    assert 0.0 <= eye.drift_bound[0] < 0.1 * MG


@pytest.mark.parametrize(("valve", "jitter"), [(1, 1e-3), (-1, 4e-3)])
def test_the_scatter_of_a_pulse_is_its_jitter_times_its_mean_flow(valve, jitter):
    fits = ChannelCalibration(replace(PULSE, jitter=1e-3), replace(VENT, jitter=4e-3))
    eye, p, supply = MassObserver([fits]), np.array([150e3]), 400e3
    eye.switch(np.array([valve], dtype=np.int8), p, supply)
    eye.advance(0.05, p, supply)
    flow = abs(eye.flow[0])
    eye.switch(np.array([0], dtype=np.int8), p, supply)
    eye.advance(0.1, p, supply)
    assert eye.drift_bound[0] == pytest.approx(2 * jitter * flow)


def test_calibrations_of_another_number_of_channels_are_refused():
    eye = observer(2)
    with pytest.raises(ValueError, match="calibrations must be 2, one per channel, got 1"):
        eye.set_calibrations([ChannelCalibration(PULSE, VENT)])
    eye.set_calibrations([ChannelCalibration(VENT, PULSE)] * 2)
    up, p = np.array([1, 0], dtype=np.int8), np.array([150e3, 150e3])
    eye.switch(up, p, 400e3)
    eye.advance(0.05, p, 400e3)
    expected = observer(2)
    expected.switch(up, p, 400e3)
    expected.advance(0.05, p, 400e3)
    assert eye.mass[0] != pytest.approx(expected.mass[0])


def test_the_pulse_to_come_is_that_of_equation_4_1_in_each_direction():
    gain, loss = observer(2).pulse_mass(0.05, np.array([150e3, 120e3]), 400e3)
    for channel, pressure in enumerate((150e3, 120e3)):
        for found, valve in ((gain, 1), (-loss, -1)):
            eye, p = observer(), np.array([pressure])
            eye.switch(np.array([valve], dtype=np.int8), p, 400e3)
            eye.advance(0.05, p, 400e3)
            assert found[channel] == pytest.approx(eye.mass[0], rel=1e-9)


@pytest.mark.parametrize(
    ("dt", "jitter"), [(2e-3, None), (2e-3, 7), (1e-2, None)], ids=["2 ms", "jittered", "10 ms"]
)
def test_after_a_filling_pulse_the_estimate_is_true_to_a_fifth_of_a_milligram(dt, jitter):
    rig = BottleRig(channels=4).started(dt)
    rig.command(*[15 * MG] * 4)
    rig.run(2.0, dt, jitter and np.random.default_rng(jitter))
    assert (rig.mass > 14 * MG).all()
    assert np.abs(rig.error).max() < 0.2 * MG


def test_a_changed_supply_leaves_no_trace_in_the_estimate():
    rig = BottleRig(channels=4, volume=0.5e-3)
    rig.plant.set_supply(240e3)  # 20 % below what the box usually has
    rig.started()
    rig.command(*[30 * MG] * 4)
    rig.run(3.0)
    assert np.abs(rig.error).max() < 0.4 * MG
