"""From the node's parameters to the box's settings."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from pneumaticbox_driver.parameters import PARAMETERS, box_settings, outlet_numbers
from softhand_model.hands import load_hand


def settings(**given):
    values = {parameter.name: parameter.default for parameter in PARAMETERS} | given
    return box_settings(values.__getitem__)


def test_without_a_word_the_hand_gives_channels_volumes_and_limits():
    found, hand = settings(), load_hand("rbo_hand_2")
    assert found.channels == hand.channels
    np.testing.assert_allclose(found.rest_volumes, hand.rest_volumes())
    np.testing.assert_allclose(found.pressure_limits, hand.max_pressures())
    assert found.control_modes == ("mass",) * len(hand.channels)


BOTTLES = {"channels": ["a"], "rest_volumes": [1e-4], "pressure_limits": [1e5]}


@pytest.mark.parametrize(
    ("given", "model"),
    [
        ({}, "hand"),
        ({"backend": "hardware"}, "hand"),
        ({"backend": "embedded"}, "fixed"),
        ({"backend": "embedded", "volume_model": "hand"}, "hand"),
        (BOTTLES, "fixed"),
        ({"volume_model": "fixed"}, "fixed"),
    ],
)
def test_volumes_are_the_hands_unless_there_are_bottles(given, model):
    assert settings(**given).volume_model == model


@pytest.mark.parametrize("given", [[1], [0, 1, 2], [1, 2, 3, 4]])
def test_outlets_are_one_a_channel_counted_from_one(given):
    with pytest.raises(ValueError, match="outlets must be 3 numbers from 1"):
        outlet_numbers(given, 3)


def test_every_parameter_stands_in_the_shipped_file_with_its_default():
    file = Path(__file__).parents[2] / "src/pneumaticbox_driver/config/pneumaticbox.yaml"
    shipped = yaml.safe_load(file.read_text())["pneumaticbox"]["ros__parameters"]
    shipped.pop("use_sim_time")
    assert shipped == {parameter.name: parameter.default for parameter in PARAMETERS}
