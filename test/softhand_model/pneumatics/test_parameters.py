"""Constants of the pneumatic box: the thesis's numbers, and errors that name the place."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from softhand_model.data_files import data_file
from softhand_model.pneumatics import PneumaticPlant, load_pneumatics


@pytest.fixture
def content():
    return yaml.safe_load(data_file("pneumatics.yaml").read_text(encoding="utf-8"))


def load_changed(tmp_path: Path, content):
    path = tmp_path / "box.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    return load_pneumatics(path)


def test_the_pneumaticbox_is_that_of_the_thesis():
    p = load_pneumatics("pneumaticbox")
    assert (p.choke.inlet_diameter, p.choke.outlet_diameter) == (0.2e-3, 0.6e-3)
    assert p.choke.dead_volume == 0.15e-6
    assert p.valve.opening_delay == p.valve.closing_delay
    assert 0.020 <= p.valve.opening_delay[0] < p.valve.opening_delay[1] <= 0.040
    assert (p.channel_sensor.range, p.channel_sensor.accuracy) == (250e3, 0.014)
    assert (p.supply_sensor.range, p.supply_sensor.accuracy) == (700e3, 0.025)
    assert 260e3 <= p.supply.pressure <= 320e3
    assert p.leak.conductance == (0.0, 0.0) and p.gas.thermal_volume == 0.5e-3


def test_the_ideal_box_has_isothermal_air_and_all_of_the_thesis_s_delays():
    ideal = load_pneumatics("ideal")
    assert ideal.gas.thermal_time_constant == 0.0
    assert ideal.valve.opening_delay == ideal.valve.closing_delay == (0.020, 0.040)
    assert load_pneumatics(None) == ideal != load_pneumatics("pneumaticbox")


def test_a_box_without_a_thermal_volume_has_the_same_time_constant_in_all_channels(
    tmp_path, content
):
    del content["gas"]["thermal_volume"]
    gas = load_changed(tmp_path, content).gas
    assert gas.time_constants(np.array([5e-4, 1e-5])).tolist() == [gas.thermal_time_constant] * 2


@pytest.mark.parametrize(
    ("path", "value", "expected"),
    [
        (
            ("choke", "dead_volume"),
            -1.0,
            "choke.dead_volume: expected a number from 1e-10 to 10",
        ),
        (("valve", "opening_delay"), [0.04, 0.02], "valve.opening_delay: expected [smallest"),
        (("valve", "opening_delay"), 0.03, "valve.opening_delay: expected a list, got 0.03"),
        (
            ("supply", "pressure"),
            "high",
            "supply.pressure: expected a number from 1000 to 1e+08",
        ),
        (
            ("box_seed",),
            1.5,
            "box_seed: expected a whole number from 0 to 922",
        ),
        (
            ("leak", "conductance"),
            [-1e-9, 0.0],
            "leak.conductance[0]: expected a number from 0 to 0.001 kg/(s Pa)",
        ),
        (
            ("compressor", "cut_out"),
            5e5,
            "compressor.cut_out: expected a number above cut_in, 6000",
        ),
        (("gas", "thermal_time_constant"), -1, "time_constant: expected a number from 0 to"),
        (("relief", "margin"), 0.9, "relief.margin: expected a number from 1 to 100"),
        (("relief", "diameter"), 0, "relief.diameter: expected a number from 1e-05 to 0.1 m"),
        (
            ("temperature",),
            float("nan"),
            "temperature: expected a number from 200 to 500 K",
        ),
    ],
)
def test_an_error_names_file_key_expected_and_got(tmp_path, content, path, value, expected):
    place = content
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    with pytest.raises(ValueError) as error:
        load_changed(tmp_path, content)
    assert "box.yaml" in str(error.value)
    assert expected in str(error.value)


def test_a_box_with_valves_of_a_few_milliseconds_is_a_matter_of_the_file(tmp_path, content):
    content["valve"] |= {"opening_delay": [0.001, 0.004], "closing_delay": [0.001, 0.004]}
    plant = PneumaticPlant(["a"], [30e-6], load_changed(tmp_path, content))
    plant.step(0.006, [1], [30e-6])
    assert plant.valve_states.tolist() == [1]
    plant.step(0.005, [0], [30e-6])
    assert plant.valve_states.tolist() == [0]
    assert plant.inflow[0] > 1e-7


def test_missing_and_unknown_keys_are_named(tmp_path, content):
    del content["line"]["length"]
    with pytest.raises(ValueError, match="line: expected the key length"):
        load_changed(tmp_path, content)
    content["line"]["lenght"] = [0.5, 0.7]
    content["line"]["length"] = [0.5, 0.7]
    with pytest.raises(ValueError, match=r"expected only the keys .*, got lenght"):
        load_changed(tmp_path, content)
