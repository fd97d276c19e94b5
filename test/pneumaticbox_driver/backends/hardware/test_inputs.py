"""Sensors on analog inputs: the data sheets' pressures, and NaN for what cannot be believed."""

import errno
import math
import os
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from wired_box import SHIPPED, AnalogTree

from pneumaticbox_driver.backends.hardware.hardware_file import HardwareError, read_hardware
from pneumaticbox_driver.backends.hardware.inputs import IioInputs

AMBIENT = 101.3e3
DIVIDER = 10 / 28
HARDWARE = read_hardware(SHIPPED)
SENSORS = [HARDWARE.outlets[0].sensor, HARDWARE.outlets[1].sensor, HARDWARE.supply]
INPUT_OF_SUPPLY = 6


def open_inputs(tree, **converter):
    return IioInputs(replace(HARDWARE.converter, sysfs=tree.root, **converter), SENSORS, AMBIENT)


def raw(volts):
    """Counts of 12 bit over 1.8 V for a sensor's output behind the divider."""
    return round(volts * DIVIDER / 1.8 * 4096)


def mpx4250(kpa):
    return 5 * (0.00369 * kpa + 0.04)


def mpx5700(kpa):
    return 5 * (0.0012858 * kpa + 0.04)


@pytest.fixture
def tree(tmp_path):
    return AnalogTree(tmp_path)


def test_pressures_are_those_of_the_data_sheets(tree):
    inputs = open_inputs(tree)
    for kpa in (0.0, 60.0, 250.0):
        tree.put(0, raw(mpx4250(kpa)))
        tree.put(1, raw(mpx4250(kpa / 2)))
        tree.put(INPUT_OF_SUPPLY, raw(mpx5700(2 * kpa)))
        gauge = np.array([1, 0.5, 2]) * kpa * 1e3
        # half a count is 33 Pa and 96 Pa; the divider of the file is rounded to 1e-4
        np.testing.assert_allclose(inputs.read() - AMBIENT, gauge, rtol=3e-4, atol=110)


def test_volts_are_those_of_the_sensors_before_the_divider(tree):
    tree.put(0, raw(3.0))
    assert open_inputs(tree).volts()[0] == pytest.approx(3.0, abs=2e-3)


def test_an_absolute_sensor_needs_no_ambient_pressure(tree):
    # MPX4250A: volts = 5 (0.004 kPa - 0.04)
    kind = replace(SENSORS[0].type, gain=50e3, offset=10e3, reference="absolute")
    sensors = [replace(SENSORS[0], type=kind)]
    tree.put(0, raw(5 * (0.004 * 180.0 - 0.04)))
    inputs = IioInputs(replace(HARDWARE.converter, sysfs=tree.root), sensors, AMBIENT)
    assert inputs.read()[0] == pytest.approx(180e3, abs=100)


@pytest.mark.parametrize(
    "content", ["nan", "", "12.5.1", "0", "-40", "4095", "1e999"], ids=lambda text: text or "empty"
)
def test_what_no_sound_sensor_gives_is_not_a_number_and_the_others_stand(tree, content):
    inputs = open_inputs(tree)
    before = inputs.read()
    tree.write("in_voltage1_raw", content)
    after = inputs.read()
    assert math.isnan(after[1])
    np.testing.assert_array_equal(after[[0, 2]], before[[0, 2]])
    tree.put(1, 400)
    np.testing.assert_array_equal(inputs.read(), before)


def test_an_input_that_fails_while_running_is_not_a_number(tree, monkeypatch):
    inputs = open_inputs(tree)

    def gone(*_):
        raise OSError(errno.ENODEV, "No such device")

    monkeypatch.setattr(os, "pread", gone)
    assert np.isnan(inputs.read()).all()


def test_scale_and_offset_may_stand_with_the_input_or_in_the_hardware_file(tree):
    volts = open_inputs(tree).volts()
    tree.write("in_voltage1_scale", 2 * 1800 / 4096)
    np.testing.assert_allclose(open_inputs(tree).volts(), volts * [1, 2, 1])
    tree.write("in_voltage_offset", 100)
    np.testing.assert_allclose(open_inputs(tree).volts(), volts * [1.25, 2.5, 1.25])
    np.testing.assert_allclose(
        open_inputs(tree, scale=1.8 / 4096).volts(), volts * [1.25, 1.25, 1.25]
    )


def test_a_device_is_found_by_its_name_or_its_folder(tree):
    by_name = open_inputs(tree).read()
    np.testing.assert_array_equal(open_inputs(tree, device="iio:device0").read(), by_name)


def test_a_device_that_is_not_there_is_named_with_those_that_are(tree):
    with pytest.raises(HardwareError) as error:
        open_inputs(tree, device="ads1115")
    assert "hardware.yaml:24: converter.device: expected one IIO device" in str(error.value)
    assert "TI-am335x-adc.0.auto (iio:device0)), got ads1115" in str(error.value)


def test_two_devices_of_one_name_are_told_apart_by_their_folder(tree):
    other = tree.root / "iio:device1"
    other.mkdir()
    (other / "name").write_text("TI-am335x-adc.0.auto\n")
    with pytest.raises(HardwareError, match="expected one IIO device"):
        open_inputs(tree)
    assert np.isfinite(open_inputs(tree, device="iio:device0").read()).all()


def test_an_input_that_is_not_there_is_named_with_its_sensor_and_files_are_closed(tree):
    (tree.device / "in_voltage6_raw").unlink()
    before = len(os.listdir("/proc/self/fd"))
    with pytest.raises(
        HardwareError, match=r"supply\.input: expected the analog input .*6_raw, go"
    ):
        open_inputs(tree)
    assert len(os.listdir("/proc/self/fd")) == before


def test_an_input_that_may_not_be_read_is_named(tree, monkeypatch):
    def denied(path, flags):
        raise PermissionError(errno.EACCES, "Permission denied", str(path))

    monkeypatch.setattr(os, "open", denied)
    with pytest.raises(
        HardwareError, match=r"outlets\[0\]\.sensor\.input: .*got Permission denied"
    ):
        open_inputs(tree)


@pytest.mark.parametrize(("scale", "said"), [(None, "got None"), (0.0, "got 0"), ("x", "number")])
def test_a_device_without_a_usable_scale_is_refused(tmp_path, scale, said):
    tree = AnalogTree(tmp_path, scale=scale)
    with pytest.raises(HardwareError, match=f"expected .*{said}"):
        open_inputs(tree)


def test_the_kernels_files_give_a_new_number_at_every_pread():
    file = os.open(Path("/proc/sys/kernel/random/uuid"), os.O_RDONLY)
    try:
        assert os.pread(file, 64, 0) != os.pread(file, 64, 0)
    finally:
        os.close(file)


def test_closed_inputs_hold_no_files(tree):
    before = len(os.listdir("/proc/self/fd"))
    open_inputs(tree).close()
    assert len(os.listdir("/proc/self/fd")) == before


def test_seven_sensors_take_less_than_a_tenth_of_a_step_of_2_ms(tree):
    sensors = [*(outlet.sensor for outlet in HARDWARE.outlets), HARDWARE.supply]
    inputs = IioInputs(replace(HARDWARE.converter, sysfs=tree.root), sensors, AMBIENT)
    spent = []
    for _ in range(500):
        begun = time.perf_counter()
        inputs.read()
        spent.append(time.perf_counter() - begun)
    assert np.median(spent) < 0.2e-3
