"""Volume models of the channels: bottles, and a hand with tubes of any length."""

import numpy as np
import pytest

from pneumaticbox_driver.observer.volume_model import (
    FixedVolumes,
    HandVolumes,
    make_volume_model,
    pressure_after,
)
from softhand_model.hand.hand import load_hand


def test_a_bottle_keeps_its_volume_and_its_pressure_tells_nothing_of_growth():
    model = FixedVolumes((1e-4, 2e-4))
    gauge = np.array([0.0, 5e4])
    np.testing.assert_array_equal(model.volumes(gauge), [1e-4, 2e-4])
    np.testing.assert_array_equal(pressure_after(model, gauge, np.full(2, 1e-6)), gauge)


def test_longer_tubes_add_to_the_volume_at_every_pressure():
    hand = load_hand("rbo_hand_2")
    gauge = 0.4 * hand.max_pressures()
    short = make_volume_model("hand", "rbo_hand_2", hand.rest_volumes())
    long = make_volume_model("hand", "rbo_hand_2", hand.rest_volumes() + 5e-6)
    np.testing.assert_allclose(long.volumes(gauge) - short.volumes(gauge), 5e-6)
    np.testing.assert_array_equal(long.slopes(gauge), short.slopes(gauge))


@pytest.mark.parametrize("share", [0.9, 1.0, 3.5])
def test_at_rest_the_volumes_are_those_that_are_given(share):
    rest = share * load_hand("rbo_hand_2").rest_volumes()
    model = make_volume_model("hand", "rbo_hand_2", rest)
    np.testing.assert_allclose(model.volumes(np.zeros(len(rest))), rest)


def test_the_pressure_after_a_growth_gives_that_growth():
    finger = HandVolumes("single_finger", load_hand("single_finger").rest_volumes())
    for start, end in ((0.0, 4e4), (4e4, 1e4), (2e4, 2.1e4)):
        growth = finger.volumes(np.array([end])) - finger.volumes(np.array([start]))
        np.testing.assert_allclose(
            pressure_after(finger, np.array([start]), growth), end, rtol=1e-6
        )
    assert pressure_after(finger, np.array([1e4]), np.array([-1e-3]))[0] == 0.0


def test_a_hand_of_other_channels_is_refused():
    with pytest.raises(ValueError, match="expected a hand of 2 channels, got rbo_hand_2"):
        make_volume_model("hand", "rbo_hand_2", (1e-5, 1e-5))
