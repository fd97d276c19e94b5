"""Pressure sensors: class, converter, noise and low-pass."""

import numpy as np
import pytest

from softhand_model.gas import AMBIENT_PRESSURE
from softhand_model.pneumatics import load_pneumatics
from softhand_model.pneumatics.sensors import build_sensors


def sensors(box=0, channels=8):
    p = load_pneumatics()
    tolerances = np.random.default_rng(box)
    return build_sensors(
        p.channel_sensor, p.supply_sensor, AMBIENT_PRESSURE, tolerances, channels, 8
    )


def settled(bank, gauge):
    bank.filtered[:] = AMBIENT_PRESSURE + gauge
    return bank


@pytest.mark.parametrize("gauge", [0.0, 100e3, 240e3])
def test_errors_stay_within_the_class_of_the_sensor(gauge):
    worst = np.zeros(9)
    for box in range(40):
        bank = settled(sensors(box), gauge)
        bank.noise[:] = 0.0
        error = bank.read(np.random.default_rng(0)) - AMBIENT_PRESSURE - gauge
        worst = np.maximum(worst, np.abs(error))
    limit = np.array([0.014 * 250e3] * 8 + [0.025 * 700e3]) + 90.0  # half a step of the converter
    assert (worst < limit).all()
    assert (worst > 0.3 * limit).all()


def test_readings_are_steps_of_a_12_bit_converter():
    readings = settled(sensors(), 50e3).read(np.random.default_rng(1)) - AMBIENT_PRESSURE
    steps = readings / (np.array([250e3] * 8 + [700e3]) / 4096)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)


def test_noise_has_the_stated_width():
    bank, random = settled(sensors(), 50e3), np.random.default_rng(2)
    spread = np.std([bank.read(random) for _ in range(3000)], axis=0)
    p = load_pneumatics()
    for found, sensor in ((spread[0], p.channel_sensor), (spread[-1], p.supply_sensor)):
        step = sensor.range / 4096
        assert found == pytest.approx(np.hypot(sensor.noise, step / np.sqrt(12)), rel=0.06)


def test_a_reading_ends_at_full_scale():
    bank = settled(sensors(), 900e3)
    readings = bank.read(np.random.default_rng(3)) - AMBIENT_PRESSURE
    np.testing.assert_allclose(readings, [250e3] * 8 + [700e3])


def test_the_low_pass_reaches_63_percent_after_its_time_constant():
    bank = settled(sensors(), 0.0)
    for _ in range(200):
        bank.follow(1e-5, np.full(9, AMBIENT_PRESSURE + 1000.0))
    share = (bank.filtered - AMBIENT_PRESSURE) / 1000.0
    np.testing.assert_allclose(share, 1 - np.exp(-1), rtol=0.01)
