"""Recognising a pressure that stands still, through noise."""

import numpy as np
import pytest

from pneumaticbox_driver.observer.still_pressure import StillPressure

NOISE = 65.0  # of the channel sensors with their converter [Pa]


def fed(pressure, dt=2e-3, duration=0.6, channels=1):
    random, still = np.random.default_rng(0), StillPressure(channels)
    for k in range(round(duration / dt)):
        still.add(dt, pressure(k * dt) + NOISE * random.standard_normal(channels))
    return still


@pytest.mark.parametrize("dt", [2e-3, 1e-2])
def test_noise_alone_stands_still(dt):
    still = fed(lambda t: 101e3, dt, channels=50)
    assert still.still.mean() > 0.9
    np.testing.assert_allclose(still.mean, 101e3, atol=60.0)


def test_a_slow_leak_of_a_kilopascal_a_second_does_not():
    assert not fed(lambda t: 140e3 - 1e3 * t, channels=50).still.any()


def test_one_window_is_not_enough_to_tell():
    assert not fed(lambda t: 101e3, duration=0.15).still.any()


def test_restarting_a_channel_forgets_it_alone():
    still = fed(lambda t: 101e3, channels=2)
    assert still.still.all()
    still.restart(np.array([True, False]))
    assert still.still.tolist() == [False, True]
    assert np.isnan(still.mean).tolist() == [True, False]


def test_a_window_goes_on_when_the_offset_of_its_sensor_is_found():
    still = StillPressure(1)
    told = [still.add(4e-3, np.array([101e3])) for _ in range(13)]
    still.shift(0, -500.0)
    told += [still.add(4e-3, np.array([100.5e3])) for _ in range(12)]
    assert told == [False] * 24 + [True]
    assert still.mean[0] == pytest.approx(100.5e3)
    still.shift(0, 200.0)
    assert still.mean[0] == pytest.approx(100.7e3)
