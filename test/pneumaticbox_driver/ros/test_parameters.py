"""From the node's parameters to the box's settings."""

from pathlib import Path

import pytest
import yaml

from pneumaticbox_driver.ros.parameters import PARAMETERS, box_settings
from pneumaticbox_driver.settings import outlet_numbers


def settings(**given):
    values = {parameter.name: parameter.default for parameter in PARAMETERS} | given
    return box_settings(values.__getitem__)


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


@pytest.mark.parametrize(
    ("backend", "given", "enabled"),
    [
        ("topic", "", True),
        ("embedded", "", True),
        ("hardware", "", False),
        ("topic", "false", False),
        ("hardware", "true", True),
    ],
)
def test_hardware_alone_waits_for_a_call_unless_told_otherwise(backend, given, enabled):
    assert settings(backend=backend, start_enabled=given).start_enabled is enabled


@pytest.mark.parametrize("given", [[1], [0, 1, 2], [1, 2, 3, 4]])
def test_outlets_are_one_a_channel_counted_from_one(given):
    with pytest.raises(ValueError, match="outlets must be 3 numbers from 1"):
        outlet_numbers(given, 3)


def test_every_parameter_stands_in_the_shipped_file_with_its_default():
    file = Path(__file__).parents[3] / "src/pneumaticbox_driver/config/pneumaticbox.yaml"
    shipped = yaml.safe_load(file.read_text())["/**"]["ros__parameters"]
    shipped.pop("use_sim_time")
    assert shipped == {parameter.name: parameter.default for parameter in PARAMETERS}
