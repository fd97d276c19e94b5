"""The shipped configuration of the simulator node says what the node declares."""

from pathlib import Path

import pytest
import yaml

from pneuflex_sim.ros.parameters import PARAMETERS, configuration
from pneuflex_sim.simulation import SimulationConfig

CONFIG = Path(__file__).parents[3] / "src/pneuflex_sim/config/hand_sim.yaml"


def test_the_shipped_configuration_holds_every_parameter_with_its_default():
    shipped = yaml.safe_load(CONFIG.read_text())["/**"]["ros__parameters"]
    assert shipped == {parameter.name: parameter.default for parameter in PARAMETERS}


def values(**changed):
    return {parameter.name: parameter.default for parameter in PARAMETERS} | changed


def test_the_defaults_give_the_usual_simulation_at_two_milliseconds():
    assert configuration(values()) == SimulationConfig(step=0.002)


def test_settings_of_the_solver_are_more_exact_by_name_from_fast_to_stable():
    found = [configuration(values(solver=name)).solver for name in ("fast", "default", "stable")]
    assert found[0].iterations < found[1].iterations < found[2].iterations
    assert found[0].residual > found[1].residual > found[2].residual


def test_an_unknown_setting_of_the_solver_is_refused_with_those_there_are():
    with pytest.raises(ValueError, match="solver: expected one of fast, default, stable; got 'x'"):
        configuration(values(solver="x"))
