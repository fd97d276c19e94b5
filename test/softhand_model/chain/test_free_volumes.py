"""Volumes of a free hand against the simulator's, the gas law and differences."""

import numpy as np
import pytest

from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_model.chain.volumes import FreeVolumes
from softhand_model.gas import AMBIENT_PRESSURE, air_mass
from softhand_model.hand.hand import hand_names, load_hand


def random_pressures(hand, count=30):
    shape = (count, len(hand.channels))
    return np.random.default_rng(4).uniform(0.0, 1.3, shape) * hand.max_pressures()


@pytest.mark.parametrize("name", hand_names())
def test_at_every_pressure_volumes_are_those_that_the_simulator_counts(name):
    simulation, hand = Simulation(SimulationConfig(hand=name)), load_hand(name)
    air, free = simulation.air, FreeVolumes(hand)
    for gauge in random_pressures(hand):
        bend = air.rest_bend(0.001, gauge, np.zeros_like(air.layout.offset), 293.15)
        np.testing.assert_allclose(free.volumes(gauge), air.volumes(bend), rtol=1e-6)
    simulation.close()


def test_a_free_hand_filled_with_a_mass_stands_at_the_pressure_of_the_model():
    hand = load_hand("rbo_hand_2")
    simulation = Simulation(SimulationConfig(scene="stand", model="base", step=0.004))
    gauge = np.array([20e3, 30e3, 25e3, 10e3])
    free = FreeVolumes(hand)
    mass = air_mass(gauge + AMBIENT_PRESSURE, free.volumes(gauge))
    simulation.set_air_masses(mass - air_mass(AMBIENT_PRESSURE, free.rest))
    for _ in range(500):
        simulation.step()
    np.testing.assert_allclose(simulation.pressures(), gauge, rtol=0.01)
    simulation.close()


def test_a_finger_of_constant_section_has_the_volume_of_its_curvature():
    hand = load_hand("rbo_hand_1")
    parts = [part for chain in hand.chains for part in chain.actuators.values()]
    free = FreeVolumes(hand)
    expected = sum(
        np.trapezoid(part.chamber_volume_per_length(x, part.free_curvature(20e3, x)), x)
        + part.supply_volume
        for part in parts
        for x in [np.linspace(0.0, part.length, 2001)]
    )
    np.testing.assert_allclose(free.volumes([20e3]), expected, rtol=5e-4)


def test_slopes_are_the_derivatives_also_beyond_the_table_and_none_below_zero():
    hand = load_hand("rbo_hand_2")
    free, step = FreeVolumes(hand), 5.0
    for scale in (0.02, 0.7, 1.1, 3.4):
        gauge = scale * hand.max_pressures() * np.array([1.0, 0.8, 0.9, 0.7])
        around = [
            (free.volumes(gauge + step * row) - free.volumes(gauge - step * row)) / (2 * step)
            for row in np.eye(4)
        ]
        np.testing.assert_allclose(free.slopes(gauge), np.diagonal(around), rtol=1e-5)
    np.testing.assert_array_equal(free.volumes(np.full(4, -2e3)), free.rest)


def test_of_two_arcs_each_changes_the_volume_of_the_other():
    free = FreeVolumes(load_hand("rbo_hand_2"))
    alone = free.volumes([0.0, 0.0, 40e3, 0.0])
    assert alone[2] > free.rest[2] and alone[3] > free.rest[3]
    assert alone[1] == free.rest[1]
