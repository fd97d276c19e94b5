"""Leaks and relief valves of the simulated box against closed forms and bounds."""

from dataclasses import replace

import numpy as np
import pytest

from softhand_model.gas import AMBIENT_PRESSURE, GAS_CONSTANT
from softhand_model.pneumatics import PneumaticPlant, load_pneumatics

GAS = GAS_CONSTANT * 293.15  # [J/kg]
BOTTLE = 0.5e-3
FINGER = 30e-6
EIGHT = list("abcdefgh")


def leaky(smallest, largest):
    p = load_pneumatics("ideal")
    return replace(p, leak=replace(p.leak, conductance=(smallest, largest)))


def without_chokes():
    p = load_pneumatics()
    return replace(p, choke=replace(p.choke, inlet_diameter=0.01, outlet_diameter=0.01))


def run(plant, duration, valves, volumes, dt=1e-3):
    for _ in range(round(duration / dt)):
        plant.step(dt, valves, volumes)


@pytest.mark.parametrize("step", [5e-4, 2e-3, 7e-3])
def test_a_relief_valve_that_stays_closed_changes_no_bit(step):
    """A plant without any is stepped by another kernel."""
    plants = [PneumaticPlant(EIGHT, [FINGER] * 8, relief_pressures=r) for r in (None, [1e6] * 8)]
    random, readings, valves = np.random.default_rng(2), [], [0] * 8
    for _ in range(300):
        if random.uniform() < 0.1:
            valves = random.integers(-1, 2, 8)
        volumes = FINGER * random.uniform(0.9, 1.3, 8)
        for plant in plants:
            pressures = plant.step(step, valves, volumes)
            readings.append(np.concatenate([pressures, plant.read(), [plant.tank_pressure]]))
    assert np.ptp(readings, axis=0)[:8].min() > 20e3
    np.testing.assert_array_equal(readings[::2], readings[1::2])


@pytest.mark.parametrize("gauge", [-30e3, 5e3, 100e3])
def test_gauge_pressure_decays_exponentially_through_a_leak(gauge):
    conductance = 2e-9
    plant = PneumaticPlant(["a"], [BOTTLE], leaky(conductance, conductance))
    plant.fill((1 + gauge / AMBIENT_PRESSURE) * plant.rest_mass([BOTTLE]))
    run(plant, 2.0, [0], [BOTTLE], dt=5e-3)
    volume = BOTTLE + 2 * plant.parameters.choke.dead_volume
    expected = gauge * np.exp(-2.0 * conductance * GAS / volume)
    assert abs(expected) < 0.6 * abs(gauge)
    assert plant.pressures[0] - AMBIENT_PRESSURE == pytest.approx(expected, rel=1e-3)
    np.testing.assert_allclose(
        plant.mass + plant.leaked, (1 + gauge / AMBIENT_PRESSURE) * plant.rest_mass([BOTTLE])
    )


def test_each_channel_has_a_leak_of_its_own_within_the_range():
    volumes = np.full(8, BOTTLE)
    plant = PneumaticPlant(EIGHT, volumes, leaky(1e-12, 1e-11))
    plant.fill(2 * plant.rest_mass(volumes))
    run(plant, 1.0, [0] * 8, volumes)
    conductance = plant.leaked / AMBIENT_PRESSURE
    assert conductance.min() > 0.99e-12 and conductance.max() < 1.01e-11
    assert len(set(np.round(conductance, 15))) == 8


def test_a_box_with_leaks_has_the_valves_and_sensors_of_the_tight_one():
    tight, leaking = (
        PneumaticPlant(EIGHT, np.full(8, BOTTLE), b)
        for b in (load_pneumatics("ideal"), leaky(1e-12, 1e-12))
    )
    for plant in (tight, leaking):
        plant.step(0.2, [1] * 8, np.full(8, BOTTLE))
    np.testing.assert_allclose(leaking.pressures, tight.pressures, rtol=1e-5)


@pytest.mark.parametrize(
    ("box", "volume"),
    [(load_pneumatics(), FINGER), (without_chokes(), FINGER), (without_chokes(), BOTTLE)],
    ids=["choked finger", "unchoked finger", "unchoked bottle"],
)
def test_relief_valves_hold_a_channel_whose_inlet_is_stuck_open(box, volume):
    limit = 100e3
    opens = box.relief.pressures([limit])
    plant = PneumaticPlant(["a"], [volume], box, relief_pressures=opens)
    plant.faults.stick_valve("a", 1)
    highest = 0.0
    for _ in range(5000):
        highest = max(highest, *plant.step(1e-3, [0], [volume]))
    bound = float(opens[0]) * (1 + box.relief.accumulation)
    assert opens[0] < highest - AMBIENT_PRESSURE < bound
    assert plant.relieved[0] > 0


def test_a_relief_valve_is_shut_below_its_pressure_and_lets_it_come_down_to_it():
    plant = PneumaticPlant(["a"], [FINGER], relief_pressures=[80e3])
    plant.fill(plant.rest_mass([FINGER]) * (1 + 79e3 / AMBIENT_PRESSURE))
    run(plant, 0.5, [0], [FINGER])
    assert plant.relieved[0] == 0.0
    plant.step(0.3, [0], [0.7 * FINGER])
    run(plant, 2.0, [0], [0.7 * FINGER])
    assert plant.relieved[0] > 0
    assert plant.pressures[0] - AMBIENT_PRESSURE == pytest.approx(80e3, rel=0.01)


@pytest.mark.parametrize(
    ("pressures", "words"),
    [
        ([1e5, 1e5], "relief_pressures must have shape (1,), got (2,)"),
        ([0.0], "relief_pressures must be above 0 Pa, got [0.0]"),
        ([float("nan")], "relief_pressures must be above 0 Pa, got [nan]"),
    ],
)
def test_relief_pressures_that_cannot_be_are_refused(pressures, words):
    with pytest.raises(ValueError) as error:
        PneumaticPlant(["a"], [FINGER], relief_pressures=pressures)
    assert words in str(error.value)
