"""What hangs on the channels of the pretended bench: bottles and actuators under load."""

import numpy as np
import pytest

from softhand_model.actuator import load_actuator
from softhand_model.gas import AMBIENT_PRESSURE
from softhand_model.hands import load_hand
from softhand_model.pneumatics.chambers import Bottles, FreeActuators


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


def test_a_moment_on_a_finger_straightens_it_as_the_section_says():
    """Eq. 3.23: the section carries `M = h**2 z p/2` at rest, so half of that takes half of p."""
    finger = load_actuator("P10.finger")
    x = np.array([0.0])
    moment = 0.5 * finger.height(x) ** 2 * finger.width(x) * 30e3 / 2
    load = float(2 * moment[0] / (finger.height(x)[0] ** 2 * finger.width(x)[0]))
    actuators = FreeActuators(load_hand("single_finger"))
    halfway = actuators.volumes(np.array([AMBIENT_PRESSURE + 15e3]))
    actuators.set_load([load])
    loaded = actuators.volumes(np.array([AMBIENT_PRESSURE + 30e3]))
    np.testing.assert_allclose(loaded, halfway, rtol=1e-9)


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
