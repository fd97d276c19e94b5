"""Boards by the node's parameters: which simulated box the embedded one is."""

from pneumaticbox_driver.backends.board import open_board
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.pneumatics import load_pneumatics

SETTINGS = BoxSettings(("a",), (0.5e-3,), (1e5,), ("mass",))


def plant_of(name):
    given = {"embedded_plant": name, "embedded_seed": 0, "embedded_supply": 0.0}
    return open_board("embedded", SETTINGS, given.__getitem__).rig.plant.parameters


def test_the_embedded_board_is_the_ideal_box_unless_another_is_named():
    assert plant_of("") == load_pneumatics("ideal")
    assert plant_of("pneumaticbox") == load_pneumatics("pneumaticbox") != plant_of("ideal")
