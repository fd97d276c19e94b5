"""Air that heats and cools: closed forms of filling, compressing and emptying (first law)."""

from dataclasses import replace

import numpy as np
import pytest

from softhand_model.gas import AMBIENT_PRESSURE, GAS_CONSTANT
from softhand_model.pneumatics import PneumaticPlant, load_pneumatics
from softhand_model.pneumatics.air_flow import HEAT_CAPACITY, ChannelHeat
from softhand_model.pneumatics.parameters import Gas

WALL = 293.15  # [K]
KAPPA = 1.4
BOTTLE = 0.5e-3
FINGER = 30e-6
NEVER, AT_ONCE = 1e9, 1e-6  # [s]


def plant_with(time_constant, volume=BOTTLE):
    """Next to no dead volume, so that all air is in the channel."""
    p = load_pneumatics()
    box = replace(
        p,
        gas=replace(p.gas, thermal_time_constant=time_constant),
        choke=replace(p.choke, dead_volume=1e-14),
        supply=replace(p.supply, droop=0.0),
        compressor=replace(p.compressor, passed=0.0),
    )
    return PneumaticPlant(["a"], [volume], box)


def run(plant, duration, valve, volume, dt=1e-3):
    for _ in range(round(duration / dt)):
        plant.step(dt, [valve], [volume])


def pressure_rise(time_constant):
    plant = plant_with(time_constant)
    run(plant, 0.1, 1, BOTTLE)
    before = float(plant.pressures[0])
    run(plant, 1.0, 1, BOTTLE)
    return float(plant.pressures[0]) - before


def test_a_bottle_fills_kappa_times_as_fast_without_heat_to_its_walls():
    assert pressure_rise(NEVER) / pressure_rise(0.0) == pytest.approx(KAPPA, rel=1e-4)


def test_walls_that_take_heat_at_once_make_it_isothermal():
    assert pressure_rise(AT_ONCE) == pytest.approx(pressure_rise(0.0), rel=1e-9)


def test_air_of_the_supply_heats_the_bottle_as_the_first_law_says():
    plant = plant_with(NEVER)
    start = float(plant.mass[0])
    run(plant, 2.0, 1, BOTTLE)
    gained = float(plant.mass[0]) - start
    expected = WALL * (start + KAPPA * gained) / (start + gained)
    assert plant.temperatures[0] == pytest.approx(expected, rel=1e-6)
    assert expected > WALL + 5


def test_a_bottle_that_empties_follows_the_adiabat():
    plant = plant_with(NEVER)
    plant.fill(2.5 * plant.rest_mass([BOTTLE]))
    before = float(plant.mass[0]), float(plant.pressures[0])
    run(plant, 2.0, -1, BOTTLE)
    mass, pressure = float(plant.mass[0]) / before[0], float(plant.pressures[0]) / before[1]
    assert mass < 0.9
    assert pressure == pytest.approx(mass**KAPPA, rel=1e-6)


def test_enclosed_air_is_compressed_along_the_adiabat_or_the_isotherm():
    for time_constant, exponent in ((NEVER, KAPPA), (AT_ONCE, 1.0), (0.0, 1.0)):
        plant = plant_with(time_constant, FINGER)
        plant.step(0.05, [0], [0.8 * FINGER])
        expected = AMBIENT_PRESSURE * 0.8**-exponent
        assert plant.pressures[0] == pytest.approx(expected, rel=1e-6)


def test_a_hot_bottle_cools_exponentially_to_where_isothermal_air_would_be():
    plant = plant_with(0.5)
    run(plant, 0.5, 1, BOTTLE)
    run(plant, 0.1, 0, BOTTLE)
    hot = float(plant.temperatures[0]) - WALL
    run(plant, 0.7, 0, BOTTLE)
    assert hot > 1
    assert plant.temperatures[0] - WALL == pytest.approx(hot * np.exp(-0.7 / 0.5), rel=1e-6)
    run(plant, 10.0, 0, BOTTLE, dt=0.01)
    isothermal = float(plant.mass[0]) * GAS_CONSTANT * WALL / BOTTLE
    assert plant.pressures[0] == pytest.approx(isothermal, rel=1e-6)


def test_filled_and_cooled_the_walls_have_taken_volume_times_rise_of_pressure():
    plant = plant_with(0.3)
    run(plant, 1.0, 1, BOTTLE)
    run(plant, 6.0, 0, BOTTLE, dt=0.01)
    expected = BOTTLE * (float(plant.pressures[0]) - AMBIENT_PRESSURE)
    assert plant.wall_heat[0] == pytest.approx(expected, rel=1e-4)


def test_the_work_of_a_slow_compression_ends_in_the_walls():
    plant = plant_with(1e-3, FINGER)
    for volume in np.linspace(FINGER, 0.5 * FINGER, 2001)[1:]:
        plant.step(1e-3, [0], [volume])
    run(plant, 0.1, 0, 0.5 * FINGER)
    work = AMBIENT_PRESSURE * FINGER * np.log(2.0)
    assert plant.wall_heat[0] == pytest.approx(work, rel=2e-3)


def test_energy_is_kept_whatever_comes_in_goes_out_and_is_compressed():
    random = np.random.default_rng(3)
    heat = ChannelHeat(WALL, np.full(2, 0.4))
    air = np.array([30e-6, 60e-6])
    balance = HEAT_CAPACITY * air * WALL
    for _ in range(400):
        ratio = random.uniform(0.98, 1.02, 2)
        hot = heat.temperature.copy()
        heat.compress(np.ones(2), ratio)
        balance += HEAT_CAPACITY * air * hot * (ratio**-0.4 - 1)  # work on it, along the adiabat
        received, sent = random.uniform(0, 2e-6, (2, 2)) * random.integers(0, 2, (2, 2))
        balance += KAPPA * HEAT_CAPACITY * WALL * received
        mixed = (air * heat.temperature + KAPPA * received * WALL) / (air + received)
        left = (air + received - sent) / (air + received)
        # enthalpy of what leaves, the integral of c_p T dm with T falling along the adiabat
        balance -= HEAT_CAPACITY * (air + received) * mixed * (1 - left**KAPPA)
        air = air + received - sent
        heat.mix(2e-3, air, received, received - sent)
    np.testing.assert_allclose(
        HEAT_CAPACITY * air * heat.temperature + heat.heat, balance, rtol=1e-9
    )
    assert np.abs(heat.heat).min() > 1e-3


def test_a_small_channel_takes_on_the_walls_temperature_sooner_by_the_square_of_its_size():
    gas = Gas(0.6, BOTTLE)
    np.testing.assert_allclose(gas.time_constants(np.array([BOTTLE, BOTTLE / 8])), [0.6, 0.15])
    np.testing.assert_allclose(Gas(0.6).time_constants(np.array([BOTTLE, FINGER])), [0.6, 0.6])


def test_heat_of_the_pneumaticbox_shows_in_a_bottle_and_hardly_in_a_finger():
    def share_left(volume):
        plant = PneumaticPlant(["a"], [volume], load_pneumatics("pneumaticbox"))
        plant.fill(2 * plant.rest_mass([volume]))
        run(plant, 0.2, -1, volume)
        run(plant, 0.1, 0, volume)  # the valve has closed
        cold = WALL - float(plant.temperatures[0])
        run(plant, 0.2, 0, volume)
        return (WALL - float(plant.temperatures[0])) / cold

    assert share_left(BOTTLE) > 0.6
    assert share_left(FINGER) < 0.2
