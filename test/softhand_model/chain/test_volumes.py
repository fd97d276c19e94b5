"""Volumes of a free hand, and what hangs on the channels of the simulated box."""

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.optimize import brentq

from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_model.chain.volumes import Bottles, FreeActuators, FreeVolumes
from softhand_model.gas import AMBIENT_PRESSURE, air_mass
from softhand_model.hand.hand import hand_names, load_hand
from softhand_model.hand.section import bending_moment


# ------------------------------------------------------------------ a hand in free posture
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
        trapezoid(part.chamber_volume_per_length(x, part.free_curvature(20e3, x)), x)
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


# ------------------------------------------------------------------ bottles and actuators
@pytest.fixture
def hand():
    return load_hand("rbo_hand_2")


def test_bottles_keep_their_volume():
    bottles = Bottles([1e-4, 5e-4])
    for pressure in (5e4, 1e5, 4e5):
        assert bottles.volumes(np.full(2, pressure)).tolist() == [1e-4, 5e-4]


def test_unloaded_actuators_have_their_rest_volumes_at_ambient_pressure_and_grow_with_it(hand):
    actuators = FreeActuators(hand)
    rest = actuators.volumes(np.full(4, AMBIENT_PRESSURE))
    np.testing.assert_allclose(rest, hand.rest_volumes(), rtol=1e-12)
    grown = [actuators.volumes(np.full(4, AMBIENT_PRESSURE + p)) for p in (10e3, 20e3, 40e3)]
    assert (np.diff([rest, *grown], axis=0) > 0).all()


def test_a_load_on_one_channel_leaves_the_volumes_of_the_others(hand):
    actuators, pressures = FreeActuators(hand), np.full(4, AMBIENT_PRESSURE + 30e3)
    free = actuators.volumes(pressures)
    actuators.set_load([0.0, 12e3, 0.0, 0.0])
    change = actuators.volumes(pressures) - free
    assert change[1] < -1e-7
    np.testing.assert_allclose(np.delete(change, 1), 0.0, atol=1e-15)


def test_a_moment_on_a_finger_straightens_it_to_where_each_section_is_in_balance():
    """A load of 12 kPa stands for the moment h**2 z/2 * 12 kPa on every section (eq. 3.23)."""
    load, pressure = 12e3, 30e3
    description = load_hand("single_finger")
    finger = description.chains[0].actuators["finger"]

    def curvature(x):
        walls = (finger.wall(x), finger.side_wall(x), finger.shear_modulus)
        height, width = finger.height(x), finger.width(x)
        moment = height**2 * width / 2 * load

        def excess(kappa):
            return float(bending_moment(pressure, kappa, height, width, *walls) - moment)

        return brentq(excess, 0.0, 100.0, xtol=1e-9)

    points, weights = finger.quadrature()
    areas = [finger.chamber_volume_per_length(x, curvature(x)) for x in points]
    expected = float(np.sum(weights * np.array(areas))) + finger.supply_volume
    actuators = FreeActuators(description)
    free = actuators.volumes(np.array([AMBIENT_PRESSURE + pressure]))
    actuators.set_load([load])
    loaded = actuators.volumes(np.array([AMBIENT_PRESSURE + pressure]))
    assert float(loaded[0]) == pytest.approx(expected, rel=1e-3)
    assert loaded[0] < 0.95 * free[0]


def test_a_load_beyond_the_pressure_leaves_the_actuators_straight(hand):
    actuators = FreeActuators(hand)
    actuators.set_load(np.full(4, 50e3))
    volumes = actuators.volumes(np.full(4, AMBIENT_PRESSURE + 30e3))
    np.testing.assert_allclose(volumes, hand.rest_volumes(), rtol=1e-12)


@pytest.mark.parametrize(
    ("load", "words"),
    [
        ([1.0], "pressures must have shape (4,), got (1,)"),
        ([0.0, 0.0, 0.0, -1.0], "pressures must be finite and at least 0 Pa"),
        ([0.0, 0.0, 0.0, float("nan")], "pressures must be finite and at least 0 Pa"),
    ],
)
def test_a_load_that_cannot_be_is_refused(hand, load, words):
    with pytest.raises(ValueError) as error:
        FreeActuators(hand).set_load(load)
    assert words in str(error.value)
