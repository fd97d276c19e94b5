"""Faults of the simulated box: each does what its name says, and the air stays accounted for."""

import numpy as np
import pytest

from softhand_model.gas import AMBIENT_PRESSURE, GAS_CONSTANT, orifice_flow
from softhand_model.pneumatics import PneumaticPlant, load_pneumatics

GAS = GAS_CONSTANT * 293.15  # [J/kg]
BOTTLE = 0.5e-3
VOLUMES = np.full(2, BOTTLE)
SUPPLY_SENSOR = 2


@pytest.fixture
def plant():
    return PneumaticPlant(["a", "b"], VOLUMES, load_pneumatics("ideal"), seed=2)


def run(plant, duration, valves):
    for _ in range(round(duration / 1e-3)):
        plant.step(1e-3, valves, VOLUMES)


@pytest.mark.parametrize("state", [-1, 0, 1])
def test_a_stuck_valve_stays_whatever_is_commanded(plant, state):
    plant.faults.stick_valve("a", state)
    for command in (1, -1, 0):
        run(plant, 0.1, [command, 0])
        assert plant.valve_states.tolist() == [state, 0]
    assert bool(plant.inflow[0] > 1e-6) == (state == 1)


def test_a_repaired_valve_follows_its_command_again(plant):
    plant.faults.stick_valve(0, 1)
    run(plant, 0.1, [0, 0])
    plant.faults.clear()
    run(plant, 0.1, [0, 0])
    assert plant.valve_states.tolist() == [0, 0]


def test_a_burst_bottle_empties_through_its_hole_as_an_orifice_says(plant):
    plant.fill(2.5 * plant.rest_mass(VOLUMES))
    plant.faults.burst("b", diameter=0.5e-3)
    before = plant.mass
    run(plant, 0.2, [0, 0])  # choked all the time: the pressure falls exponentially
    area = np.pi / 4 * 0.5e-3**2
    rate = float(orifice_flow(1.0, 0.1, area)) * GAS / BOTTLE
    lost = (before - plant.mass) / before
    assert lost[0] == pytest.approx(0.0, abs=1e-12)
    assert lost[1] == pytest.approx(1 - np.exp(-0.2 * rate), rel=5e-3)
    np.testing.assert_allclose(before - plant.leaked, plant.mass, rtol=1e-12)


def test_a_burst_bottle_ends_at_ambient_pressure(plant):
    plant.fill(2.5 * plant.rest_mass(VOLUMES))
    plant.faults.burst("a", diameter=5e-3)
    run(plant, 1.0, [0, 0])
    assert plant.pressures[0] == pytest.approx(AMBIENT_PRESSURE, rel=1e-6)


def test_a_lost_supply_empties_and_recovers_when_repaired(plant):
    rest = plant.supply_pressure
    plant.faults.lose_supply()
    run(plant, 0.3, [0, 0])
    assert AMBIENT_PRESSURE + 5e3 < plant.supply_pressure < rest - 50e3
    run(plant, 3.0, [0, 0])
    assert plant.supply_pressure == pytest.approx(AMBIENT_PRESSURE, rel=1e-4)
    assert plant.read()[SUPPLY_SENSOR] < AMBIENT_PRESSURE + 20e3
    plant.faults.clear()
    run(plant, 3.0, [0, 0])
    # what filled the reservoir is missing in the compressor's tank
    assert plant.supply_pressure == pytest.approx(rest, rel=2e-3)


def test_with_the_supply_lost_an_open_inlet_lets_the_channel_empty_backwards(plant):
    plant.fill(2.0 * plant.rest_mass(VOLUMES))
    plant.faults.lose_supply(diameter=5e-3)
    run(plant, 0.5, [0, 0])
    before = plant.mass[0]
    run(plant, 0.5, [1, 0])
    assert plant.mass[0] < before - 1e-6
    assert plant.inflow[0] < 0


def test_a_stuck_sensor_repeats_its_last_reading_to_the_bit(plant):
    run(plant, 0.1, [1, 1])
    last = plant.read()
    plant.faults.stick_sensor(0)
    run(plant, 0.5, [1, 1])
    readings = [plant.read() for _ in range(5)]
    assert [reading[0] for reading in readings] == [last[0]] * 5
    assert readings[0][1] > last[1] + 1e3


def test_a_sensor_stuck_before_it_was_ever_read_keeps_its_first_reading(plant):
    plant.faults.stick_sensor(SUPPLY_SENSOR)
    first = plant.read()[SUPPLY_SENSOR]
    assert {plant.read()[SUPPLY_SENSOR] for _ in range(20)} == {first}


def test_a_lost_sensor_reads_nan_until_repaired(plant):
    plant.faults.lose_sensor(1)
    assert np.isnan(plant.read()).tolist() == [False, True, False]
    plant.faults.clear()
    assert np.isfinite(plant.read()).all()


def test_faults_are_part_of_a_saved_state_and_gone_after_a_reset(plant):
    plant.faults.stick_valve("a", 1)
    plant.faults.lose_sensor(1)
    plant.faults.burst("b")
    saved = plant.save()
    plant.faults.clear()
    plant.restore(saved)
    run(plant, 0.05, [0, 0])
    assert plant.valve_states[0] == 1
    assert np.isnan(plant.read()[1])
    plant.reset()
    run(plant, 0.05, [0, 0])
    assert plant.valve_states[0] == 0
    assert np.isfinite(plant.read()).all()
    assert not plant.leaked.any()


def test_sound_readings_are_those_of_a_plant_without_faults(plant):
    other = PneumaticPlant(["a", "b"], VOLUMES, load_pneumatics("ideal"), seed=2)
    plant.faults.lose_sensor(0)
    for _ in range(10):
        np.testing.assert_array_equal(plant.read()[1:], other.read()[1:])


@pytest.mark.parametrize(
    ("method", "arguments", "words"),
    [
        ("stick_valve", ("a", 2), "state must be -1, 0 or 1, got 2"),
        ("stick_valve", ("c", 1), "channel must be one of a, b, got c"),
        ("stick_valve", (2, 1), "channel must be one of a, b, got 2"),
        ("burst", (0, 0.0), "diameter must be above 0 m, got 0.0"),
        ("burst", (-1,), "channel must be one of a, b, got -1"),
        ("stick_sensor", (3,), "index must be 0 to 2, got 3"),
        ("lose_sensor", (-1,), "index must be 0 to 2, got -1"),
        ("lose_supply", (float("nan"),), "diameter must be above 0 m, got nan"),
    ],
)
def test_a_fault_that_cannot_be_is_refused(plant, method, arguments, words):
    with pytest.raises(ValueError) as error:
        getattr(plant.faults, method)(*arguments)
    assert words in str(error.value)
