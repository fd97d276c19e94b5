"""Coils on GPIO lines: inactive from the first moment, released when anything is wrong."""

import inspect
import sys
from dataclasses import fields

import gpiod_stand_in
import numpy as np
import pytest
from gpiod_stand_in import FakeChip, Gpiod

from pneumaticbox_driver.backends.hardware.hardware_file import Coil, HardwareError
from pneumaticbox_driver.backends.hardware.lines import CONSUMER, GpioLines
from pneumaticbox_driver.backends.hardware.opening import LinuxBoard

ONE, TWO = "/dev/gpiochip1", "/dev/gpiochip2"


def coil(line, chip=ONE, active_low=False, place="box.yaml: outlets[0].inflate"):
    return Coil(place, chip, line, active_low)


@pytest.fixture
def chips(monkeypatch):
    chips = {ONE: FakeChip(names={"P8_12": 12, "P8_11": 13}), TWO: FakeChip()}
    monkeypatch.setitem(sys.modules, "gpiod", Gpiod(chips))
    return chips


def test_lines_are_requested_as_inactive_outputs_of_either_polarity(chips):
    GpioLines([coil("P8_12"), coil(13, active_low=True), coil(3, TWO)])
    assert chips[ONE].levels == {12: False, 13: True}
    assert chips[TWO].levels == {3: False}
    assert chips[ONE].users == {12: CONSUMER, 13: CONSUMER}


def test_switching_sets_the_lines_named_and_leaves_the_others(chips):
    lines = GpioLines([coil("P8_12"), coil(13, active_low=True), coil(3, TWO), coil(4, TWO)])
    lines.switch({0: True, 1: True, 2: True})
    assert chips[ONE].levels == {12: True, 13: False}
    assert chips[TWO].levels == {3: True, 4: False}
    lines.switch({0: False})
    assert chips[ONE].levels == {12: False, 13: False}
    assert chips[TWO].levels == {3: True, 4: False}


def test_released_lines_are_free(chips):
    lines = GpioLines([coil("P8_12"), coil(3, TWO)])
    lines.release()
    assert not chips[ONE].users and not chips[TWO].users


def test_a_chip_that_fails_does_not_keep_the_others_from_being_set(chips):
    lines = GpioLines([coil("P8_12"), coil(3, TWO)])
    chips[ONE].broken = True
    with pytest.raises(HardwareError, match=r"gpiochip1: expected to set lines \[12\], got Input"):
        lines.switch({0: True, 1: True})
    assert chips[TWO].levels == {3: True}


def test_a_chip_that_is_gone_keeps_no_outlet_of_the_others_shut(chips):
    # inflate and deflate of outlets 1 and 2, each on its chip, and of outlet 3, on both
    coils = [coil(12), coil(13), coil(2, TWO), coil(3, TWO), coil(14), coil(4, TWO)]
    board = LinuxBoard(GpioLines(coils), None, [1, 2, 3])
    board.set_valves(np.array([1, 1, 1]))
    chips[ONE].broken = True
    for _ in range(2):
        with pytest.raises(HardwareError, match="gpiochip1: expected to set lines"):
            board.set_valves(np.array([-1, -1, -1]))
        assert chips[TWO].levels == {2: False, 3: True, 4: False}
        assert chips[ONE].levels == {12: True, 13: False, 14: True}
    chips[ONE].broken = False
    board.set_valves(np.array([-1, -1, -1]))
    assert chips[TWO].levels == {2: False, 3: True, 4: True}
    assert chips[ONE].levels == {12: False, 13: True, 14: False}


@pytest.mark.parametrize(
    ("second", "expected"),
    [
        (coil(3, "/dev/gpiochip9"), "expected a GPIO chip at /dev/gpiochip9, got No such file or"),
        (coil(3, "/dev/locked"), "expected a GPIO chip at /dev/locked, got Permission denied"),
        (coil("P8_99", TWO), "expected a line of /dev/gpiochip2, got 'P8_99'"),
        (coil(32, TWO), "expected a line of /dev/gpiochip2, got 32"),
        (coil(7, TWO), r"expected lines [7] of /dev/gpiochip2 to be free, got Device or resource"),
        (coil(12), "expected a line of its own, got 12, line 12 of /dev/gpiochip1, twice"),
    ],
    ids=["no chip", "not permitted", "no such name", "no such number", "in use", "twice"],
)
def test_what_cannot_be_used_is_named_and_no_line_is_held(chips, second, expected):
    chips["/dev/locked"] = PermissionError(13, "Permission denied")
    chips[TWO].users = {7: "another"}
    with pytest.raises(HardwareError) as error:
        GpioLines([coil("P8_12"), second])
    assert str(error.value).startswith("box.yaml: outlets[0].inflate: ")
    assert expected in str(error.value)
    assert not chips[ONE].users
    assert not any(chips[ONE].levels.values())


def test_without_the_package_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "gpiod", None)
    with pytest.raises(HardwareError, match=r"expected the package gpiod \(pip install 'gpiod>=2'"):
        GpioLines([coil("P8_12")])


def test_version_1_of_the_package_is_refused(monkeypatch):
    class Old:
        __version__ = "1.6.3"

    monkeypatch.setitem(sys.modules, "gpiod", Old())
    with pytest.raises(HardwareError, match=r"version 2 or above, got 1\.6\.3"):
        GpioLines([coil("P8_12")])


def test_the_stand_in_has_the_names_and_arguments_of_the_package():
    gpiod = pytest.importorskip("gpiod")
    for name in ("line_offset_from_id", "request_lines"):
        real = inspect.signature(getattr(gpiod.Chip, name)).parameters
        ours = inspect.signature(getattr(gpiod_stand_in.Chip, name)).parameters
        assert list(real)[: len(ours)] == list(ours)
    for name in ("set_values", "release"):
        real = inspect.signature(getattr(gpiod.LineRequest, name)).parameters
        assert list(real) == list(
            inspect.signature(getattr(gpiod_stand_in.LineRequest, name)).parameters
        )
    assert {f.name for f in fields(gpiod_stand_in.LineSettings)} <= {
        f.name for f in fields(gpiod.LineSettings)
    }
    for name in ("Direction.OUTPUT", "Value.ACTIVE", "Value.INACTIVE"):
        enumeration, member = name.split(".")
        assert member in getattr(gpiod.line, enumeration).__members__
    with pytest.raises(
        HardwareError, match="expected a GPIO chip at /dev/null, got No such device"
    ):
        GpioLines([coil(3, "/dev/null")])
