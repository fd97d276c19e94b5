"""From the hardware file to a bench: outlets in use, other boards; an error moves nothing."""

import os
import subprocess
import sys
import threading

import numpy as np
import pytest
from wired_box import AnalogTree, RememberedLines, hardware_file

from pneumaticbox_driver.backends.hardware import inputs
from pneumaticbox_driver.backends.hardware.hardware_file import HardwareError
from pneumaticbox_driver.backends.hardware.opening import open_rig

OWN_BOARD = "boards_of_the_test:Board"


@pytest.fixture
def tree(tmp_path):
    return AnalogTree(tmp_path / "sysfs")


@pytest.fixture
def path(tmp_path, tree):
    return hardware_file(tmp_path, tree.root)


@pytest.fixture
def made():
    return []


@pytest.fixture
def make_lines(made):
    def make(coils):
        made.append(RememberedLines(coils))
        return made[-1]

    return make


def test_every_coil_of_the_box_is_requested_though_few_outlets_are_in_use(path, made, make_lines):
    with open_rig(path, [1], make_lines=make_lines):
        assert [coil.line for coil in made[0].coils[:4]] == ["P8_12", "P8_11", "P8_16", "P8_15"]
        assert len(made[0].coils) == 12
        assert not any(made[0].active)
    assert made[0].released


def test_a_channel_switches_the_coils_and_reads_the_sensor_of_its_outlet(
    path, tree, made, make_lines
):
    tree.put(2, 2000)
    with open_rig(path, [3, 1], make_lines=make_lines) as bench:
        bench.command([1, -1])
        assert np.flatnonzero(made[0].active).tolist() == [1, 4]
        pressures = bench.read()
        assert pressures[0] > pressures[1] + 50e3


def test_from_one_coil_to_the_other_the_first_goes_off_first(path, made, make_lines):
    with open_rig(path, [1, 2], make_lines=make_lines) as bench:
        for valves in ([1, -1], [-1, 1], [1, 1], [-1, -1], [0, 0], [1, 0]):
            bench.command(valves)
            assert made[0].valves(2) == valves
    assert len(made[0].history) > 8
    assert not made[0].both_on()


def test_what_is_as_it_was_is_not_written_again(path, made, make_lines):
    with open_rig(path, [1, 2], make_lines=make_lines) as bench:
        for _ in range(3):
            bench.command([1, 0])
        assert len(made[0].history) == 1


def test_after_a_switching_that_failed_half_way_all_is_written_again(path, made):
    class Failing(RememberedLines):
        fails = False

        def switch(self, active):
            super().switch(active)  # the lines have changed, and then the answer is lost
            if self.fails:
                raise HardwareError("no answer")

    def make(coils):
        made.append(Failing(coils))
        return made[0]

    with open_rig(path, [1, 2], make_lines=make) as bench:
        made[0].fails = True
        with pytest.raises(HardwareError, match="no answer"):
            bench.command([1, 0])
        made[0].fails = False
        bench.command([-1, -1])
        assert made[0].valves(2) == [-1, -1]
    assert not made[0].both_on()


def test_a_converter_that_hangs_does_not_hold_the_lines(path, made, make_lines, monkeypatch):
    converting = threading.Event()
    monkeypatch.setattr(inputs, "_count", lambda file: converting.wait(20.0) and 400.0)
    with open_rig(path, [1, 2], make_lines=make_lines) as bench:
        bench.command([1, 0])
        with pytest.raises(HardwareError, match="read has not returned in time"):
            bench.read()
        bench.command([-1, -1])
        assert made[0].valves(2) == [-1, -1]
        converting.set()
        assert np.isfinite(bench.read()).all()


def test_a_chip_that_hangs_is_reported_and_holds_neither_sensors_nor_the_end(path, made):
    switching = threading.Event()
    switching.set()

    class Hanging(RememberedLines):
        def switch(self, active):
            assert switching.wait(20.0)
            super().switch(active)

    def make(coils):
        made.append(Hanging(coils))
        return made[0]

    bench = open_rig(path, [1, 2], make_lines=make)
    bench.command([1, 0])
    switching.clear()
    with pytest.raises(HardwareError, match="set_valves has not returned in time"):
        bench.command([0, 0])
    assert np.isfinite(bench.read()).all()
    with pytest.raises(HardwareError, match="the valves may be unchanged"):
        bench.close()
    switching.set()


@pytest.mark.parametrize("outlets", [[0], [7], [1, 1], []])
def test_outlets_that_the_box_does_not_have_are_refused(path, made, make_lines, outlets):
    with pytest.raises(ValueError, match="outlets must be different numbers from 1 to 6, got"):
        open_rig(path, outlets, make_lines=make_lines)
    assert not made


def test_without_the_converter_no_line_is_touched(tmp_path, made, make_lines):
    path = hardware_file(tmp_path, tmp_path / "nothing")
    with pytest.raises(HardwareError, match=r"there is none\), got TI-am335x-adc"):
        open_rig(path, [1], make_lines=make_lines)
    assert not made


def test_without_the_chip_the_error_names_it_and_the_inputs_are_closed(path):
    def no_chip(coils):
        raise HardwareError(f"{coils[0].place}: expected a GPIO chip at {coils[0].chip}, got none")

    before = len(os.listdir("/proc/self/fd"))
    with pytest.raises(HardwareError, match=r"outlets\[0\]\.inflate: expected a GPIO chip"):
        open_rig(path, [1], make_lines=no_chip)
    assert len(os.listdir("/proc/self/fd")) == before


def test_without_the_package_gpiod_nothing_moves_and_the_error_says_so(path, monkeypatch):
    monkeypatch.setitem(sys.modules, "gpiod", None)
    with pytest.raises(HardwareError, match="expected the package gpiod"):
        open_rig(path, [1])


def test_the_package_gpiod_is_imported_only_when_lines_are_asked_for(tmp_path):
    (tmp_path / "gpiod.py").write_text("raise RuntimeError('imported')\n")
    code = "import pneumaticbox_driver.backends.hardware.opening as o; o.GpioLines([])"
    environment = os.environ | {"PYTHONPATH": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False
    )
    assert "RuntimeError: imported" in done.stderr and "in load_gpiod" in done.stderr


class Board:
    """A board of one's own, as a hardware file names it."""

    def __init__(self, outlets, ambient, port="none"):
        self.outlets, self.ambient, self.port, self.valves = outlets, ambient, port, None

    def set_valves(self, valves):
        self.valves = valves.tolist()

    def read(self):
        return 0.0, np.full(len(self.outlets) + 1, self.ambient)

    def close(self):
        pass


def own_board(folder, board=OWN_BOARD, **settings):
    path = folder / "own.yaml"
    path.write_text(
        f"format: pneumaticbox-hardware/1\nboard: {board!r}\nvent_time: 0.0\nsettings: {settings}\n"
    )
    return path


@pytest.fixture
def own_module(monkeypatch):
    monkeypatch.setitem(sys.modules, "boards_of_the_test", sys.modules[__name__])


def test_a_board_of_ones_own_is_made_from_the_file(tmp_path, own_module, monkeypatch):
    boards = []
    make = Board.__init__

    def remember(self, *args, **keywords):
        make(self, *args, **keywords)
        boards.append(self)

    monkeypatch.setattr(Board, "__init__", remember)
    path = own_board(tmp_path, port="/dev/ttyUSB0")
    with open_rig(path, [2, 1], ambient=1e5, allow_board_module=True) as bench:
        assert bench.read().tolist() == [1e5] * 3
        bench.command([1, 0])
        assert boards[0].valves == [1, 0]
    assert (boards[0].outlets, boards[0].port) == ((2, 1), "/dev/ttyUSB0")
    assert boards[0].valves == [-1, -1]


@pytest.mark.parametrize(
    ("board", "settings", "expected"),
    [
        ("no_such_module:Board", {}, ": board: expected linux (GPIO and IIO of this"),
        ("boards_of_the_test:Nothing", {}, ": board: expected linux (GPIO and IIO of this"),
        ("boards_of_the_test", {}, ": board: expected linux (GPIO and IIO of this"),
        (OWN_BOARD, {"baud": 9600}, ": settings: expected settings that boards_of_the_te"),
    ],
    ids=["module", "class", "no class", "settings"],
)
def test_a_board_that_cannot_be_made_is_refused(tmp_path, own_module, board, settings, expected):
    with pytest.raises(ValueError) as error:
        open_rig(own_board(tmp_path, board, **settings), [1], allow_board_module=True)
    assert expected in str(error.value)


def test_a_foreign_board_module_is_not_run_unasked(tmp_path, monkeypatch):
    (tmp_path / "foreign.py").write_text("from pathlib import Path\nPath('ran').touch()\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match="board: expected linux.*--allow-board-module"):
        open_rig(own_board(tmp_path, "foreign:Board"), [1])
    assert not (tmp_path / "ran").exists()
