"""Settings and parameters: refused by name, expected and got; the hand fills what is not given."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from pneumaticbox_driver.ros.parameters import PARAMETERS, box_settings
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.hand.hand import load_hand

GOOD = {
    "channels": ("a", "b"),
    "rest_volumes": (3e-5, 3e-5),
    "pressure_limits": (5e4, 5e4),
    "control_modes": ("mass", "mass"),
}


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"channels": ("a", "a")}, "channels must be 1 to 8 different names, got ['a', 'a']"),
        ({"channels": ("a", "b/c")}, "channels must be names of letters, digits and _"),
        ({"rest_volumes": (3e-5,)}, "rest_volumes must have 2 values, one per channel, got 1"),
        ({"rest_volumes": (3e-5, 0.0)}, "rest_volumes must be above 0, got [3e-05, 0.0]"),
        ({"pressure_limits": (5e4, float("inf"))}, "pressure_limits must be above 0"),
        ({"control_modes": ("mass",)}, "control_mode must have 2 entries, got 1"),
        ({"control_modes": ("mass", "volume")}, "expects volume_model 'hand', got 'fixed'"),
        ({"control_modes": ("mass", "magic")}, "control_mode must be one of ['mass', "),
        ({"volume_model": "wish"}, "volume_model must be one of ['hand', 'fixed'], got 'wish'"),
        ({"command_timeout": -1.0}, "command_timeout must be 0 or above, got -1.0"),
    ],
)
def test_a_setting_that_cannot_be_is_refused_by_name_expected_and_got(change, expected):
    with pytest.raises(ValueError) as error:
        BoxSettings(**{**GOOD, **change})
    assert expected in str(error.value)


def settings(**changes):
    values = {parameter.name: parameter.default for parameter in PARAMETERS} | changes
    return box_settings(values.__getitem__)


def test_by_default_channels_volumes_and_limits_are_those_of_the_hand():
    made, hand = settings(), load_hand("rbo_hand_2")
    assert made.channels == hand.channels
    np.testing.assert_allclose(made.rest_volumes, hand.rest_volumes())
    np.testing.assert_allclose(made.pressure_limits, hand.max_pressures())
    assert made.control_modes == ("mass",) * len(hand.channels)


def test_what_is_given_stands_over_the_hand():
    made = settings(hand="single_finger", pressure_limits=[4e4], channels=["x"])
    assert made.channels == ("x",)
    assert made.pressure_limits == (4e4,)
    assert made.rest_volumes == tuple(load_hand("single_finger").rest_volumes())


def test_without_need_of_a_hand_none_is_read():
    made = settings(hand="none such", channels=["x"], rest_volumes=[1e-4], pressure_limits=[1e5])
    assert made.rest_volumes == (1e-4,)


def test_a_hand_that_does_not_exist_is_refused_with_those_that_do():
    with pytest.raises(ValueError, match=r"rbo_hand_2.*single_finger.*got 'rbo_hand_9'"):
        settings(hand="rbo_hand_9")


def test_modes_are_one_for_all_or_one_a_channel():
    with pytest.raises(ValueError, match="control_mode must have 1 or 4 entries, got 2"):
        settings(control_mode=["mass", "mass"])


def test_the_shipped_configuration_holds_every_parameter_with_its_default():
    path = Path(__file__).parents[2] / "src/pneumaticbox_driver/config/pneumaticbox.yaml"
    shipped = yaml.safe_load(path.read_text())["/**"]["ros__parameters"]
    assert shipped.pop("use_sim_time") is True
    assert shipped == {parameter.name: parameter.default for parameter in PARAMETERS}


def test_every_parameter_says_what_it_is():
    for parameter in PARAMETERS:
        assert len(parameter.description) > 10
        if parameter.bounds:
            assert parameter.bounds[0] <= parameter.default <= parameter.bounds[1]
