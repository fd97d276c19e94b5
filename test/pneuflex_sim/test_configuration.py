"""The shipped configuration of the simulator node says what the node declares."""

from pathlib import Path

import yaml

from pneuflex_sim.parameters import PARAMETERS

CONFIG = Path(__file__).parents[2] / "src/pneuflex_sim/config/hand_sim.yaml"


def test_the_shipped_configuration_holds_every_parameter_with_its_default():
    shipped = yaml.safe_load(CONFIG.read_text())["/**/hand_sim"]["ros__parameters"]
    assert shipped == {parameter.name: parameter.default for parameter in PARAMETERS}
