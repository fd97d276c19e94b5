"""The hardware file: what is shipped can be read, and every error names file, key and value."""

import re

import pytest
from wired_box import SHIPPED, hardware_file

from pneumaticbox_driver.backends.hardware.hardware_file import read_hardware


def test_the_shipped_file_is_the_thesis_box_on_two_banks():
    hardware = read_hardware(SHIPPED)
    assert len(hardware.outlets) == 6
    assert [o.sensor.input for o in hardware.outlets] == [0, 1, 2, 3, 4, 5]
    assert hardware.supply.input == 6
    assert {o.inflate.chip for o in hardware.outlets} == {"/dev/gpiochip1", "/dev/gpiochip2"}
    assert hardware.outlets[0].inflate.line == "P8_12"
    assert hardware.outlets[0].deflate.place.endswith("hardware.yaml:14: outlets[0].deflate")
    assert not hardware.outlets[0].inflate.active_low
    assert hardware.converter.scale is None


def test_no_sensor_of_the_shipped_file_can_overload_its_input():
    hardware = read_hardware(SHIPPED)
    for sensor in [*(o.sensor for o in hardware.outlets), hardware.supply]:
        assert 5.0 * sensor.divider < 1.8


def test_an_outlet_may_have_a_chip_and_a_polarity_of_its_own(tmp_path):
    def change(document):
        document["gpio"]["active_low"] = True
        document["outlets"][1] |= {"chip": "/dev/gpiochip3", "active_low": False, "inflate": 7}

    first, second, *_ = read_hardware(hardware_file(tmp_path, "/sys", change)).outlets
    assert first.inflate.active_low and first.inflate.chip == "/dev/gpiochip1"
    assert not second.inflate.active_low and second.deflate.chip == "/dev/gpiochip3"
    assert second.inflate.line == 7


CHANGES = {
    "no board": (
        lambda d: d.pop("board"),
        "document: expected the key board, got converter, format",
    ),
    "unknown key": (
        lambda d: d.update(pump=1),
        "document: expected only the keys format, board, vent_time,",
    ),
    "other format": (
        lambda d: d.update(format="pneumaticbox-hardware/9"),
        "format: expected one of pneumaticbox-hardware/1, got 'pneumaticbox-hardware/9'",
    ),
    "no outlets": (
        lambda d: d.update(outlets=[]),
        "outlets: expected 1 to 8 outlets, got []",
    ),
    "line below 0": (
        lambda d: d["outlets"][2].update(inflate=-1),
        "outlets[2].inflate: expected a whole number from 0 to 10000 or a line's name, got -1",
    ),
    "line as flag": (
        lambda d: d["outlets"][2].update(inflate=True),
        "outlets[2].inflate: expected a whole number from 0 to 10000 or a line's name, got True",
    ),
    "polarity": (
        lambda d: d["gpio"].update(active_low="no"),
        "gpio.active_low: expected true or false, got 'no'",
    ),
    "a line twice": (
        lambda d: d["outlets"][1].update(inflate="P8_11"),
        "outlets[1].inflate: expected an unused line, got that of outlets[0].deflate: ",
    ),
    "an input twice": (
        lambda d: d["supply"].update(input=3),
        "supply.input: expected an unused input, got that of outlets[3].sensor.input: 3",
    ),
    "input": (
        lambda d: d["supply"].update(input="AIN6"),
        "supply.input: expected a whole number from 0 to 10000, got 'AIN6'",
    ),
    "unknown sensor": (
        lambda d: d["supply"].update(type="mpx2010"),
        "supply.type: expected one of mpx4250, mpx5700, got 'mpx2010'",
    ),
    "5 V on an input": (
        lambda d: d["outlets"][0]["sensor"].update(divider=0.5),
        "outlets[0].sensor.divider: expected at most 0.3614, so that 4.98 V of the sensor stay "
        "within 1.8 V of the input, got 0.5",
    ),
    "no divider": (
        lambda d: d["outlets"][0]["sensor"].update(divider=0.0),
        "outlets[0].sensor.divider: expected a number from 0.0001 to 1, got 0.0",
    ),
    "gain": (
        lambda d: d["sensor_types"]["mpx4250"].update(gain=-1.0),
        "sensor_types.mpx4250.gain: expected a number from 1 to 1e+09 Pa/V, got -1.0",
    ),
    "output": (
        lambda d: d["sensor_types"]["mpx5700"].update(output=[0.0, 4.9]),
        "sensor_types.mpx5700.output[0]: expected a number from 1e-09 to 1000 V, got 0.0",
    ),
    "reference": (
        lambda d: d["sensor_types"]["mpx5700"].update(reference="vacuum"),
        "sensor_types.mpx5700.reference: expected one of gauge, absolute, got 'vacuum'",
    ),
    "vent time": (
        lambda d: d.update(vent_time=60),
        "vent_time: expected a number at least 0 and at most 10, got 60",
    ),
    "scale": (
        lambda d: d["converter"].update(scale=0),
        "converter.scale: expected a number from 1e-09 to 1000 V, got 0",
    ),
}


@pytest.mark.parametrize("name", CHANGES)
def test_what_cannot_be_is_refused_by_file_key_expected_and_got(tmp_path, name):
    change, expected = CHANGES[name]
    path = hardware_file(tmp_path, "/sys", change)
    with pytest.raises(ValueError) as error:
        read_hardware(path)
    assert re.fullmatch(rf"{path}(:\d+)?: {re.escape(expected)}.*", str(error.value))


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"none\.yaml: expected a readable file, got No such file"):
        read_hardware(tmp_path / "none.yaml")
