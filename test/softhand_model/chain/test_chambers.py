"""What hangs on the channels of the pretended bench: bottles and actuators under load."""

import numpy as np
import pytest
from scipy.optimize import brentq

from softhand_model.chain.volumes import Bottles, FreeActuators
from softhand_model.gas import AMBIENT_PRESSURE
from softhand_model.hand.hand import load_hand
from softhand_model.hand.section import bending_moment


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
        walls = (finger.wall, finger.side_wall, finger.shear_modulus)
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
