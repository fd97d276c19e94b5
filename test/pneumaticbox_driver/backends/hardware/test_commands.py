"""First steps on a box without the driver: read, pulse, vent."""

import os
import signal
import subprocess
import sys
import time

import pytest
from wired_box import AnalogTree, RememberedLines, hardware_file

from pneumaticbox_driver.backends.hardware.__main__ import main
from pneumaticbox_driver.backends.hardware.hardware_file import HardwareError


@pytest.fixture
def tree(tmp_path):
    # 1 bar on the supply's sensor: 5 (0.0012858 x 100 + 0.04) V behind the divider
    tree = AnalogTree(tmp_path / "sysfs")
    tree.put(6, round(5 * (0.0012858 * 100 + 0.04) * 10 / 28 / 1.8 * 4096))
    return tree


@pytest.fixture
def path(tmp_path, tree):
    return str(hardware_file(tmp_path, tree.root))


@pytest.fixture
def box():
    """Makes lines and keeps the last that were made."""

    def make(coils):
        make.lines = RememberedLines(coils)
        return make.lines

    return make


def test_read_shows_pressures_and_volts_and_switches_nothing(path, tree, box, capsys):
    tree.put(1, 0)
    assert main([path, "read", "1", "2"], box) == 0
    first, second, supply, spent = capsys.readouterr().out.splitlines()
    assert "outlet 1:" in first and "0.492 V" in first
    assert "not readable" in second
    assert float(supply.split()[1]) == pytest.approx(100.0, abs=0.1)  # half a count
    assert 0 < float(spent.split()[3]) < 2
    assert box.lines.history == [] and box.lines.released


@pytest.mark.parametrize(("direction", "coil"), [("inflate", 2), ("deflate", 3)])
def test_a_pulse_switches_one_coil_then_vents_that_outlet(path, box, capsys, direction, coil):
    assert main([path, "pulse", "2", direction, "30"], box) == 0
    on = [[i for i, active in enumerate(state) if active] for state in box.lines.history]
    assert on == [[coil], [], [3]]
    assert box.lines.released
    assert "outlet 2: " in capsys.readouterr().out


def test_a_pulse_without_a_sound_sensor_moves_nothing_but_the_outlet(path, tree, box, capsys):
    tree.put(0, 4095)
    assert main([path, "pulse", "1", "inflate", "30"], box) == 2
    assert box.lines.history == [[False, True] + [False] * 10] and box.lines.released
    assert "sensor of the outlet: expected a pressure, got none" in capsys.readouterr().err


@pytest.mark.parametrize("duration", ["0", "501", "nan"])
def test_a_pulse_of_no_sensible_length_is_refused(path, box, capsys, duration):
    assert main([path, "pulse", "1", "inflate", duration], box) == 2
    assert "at most 500 ms" in capsys.readouterr().err
    assert not hasattr(box, "lines")


def test_vent_opens_outlets_even_when_the_converter_is_gone(tmp_path, box):
    path = str(hardware_file(tmp_path, tmp_path / "nothing"))
    assert main([path, "vent", "1", "3"], box) == 0
    assert [i for i, active in enumerate(box.lines.active) if active] == [1, 5]
    assert box.lines.released


def test_vent_keeps_the_lines_for_the_vent_time(tmp_path, tree):
    times = []

    class TimedLines(RememberedLines):
        def switch(self, active):
            super().switch(active)
            times.append(time.monotonic())

        def release(self):
            super().release()
            times.append(time.monotonic())

    change = {"vent_time": 0.3}
    path = str(hardware_file(tmp_path, tree.root, lambda document: document.update(change)))
    assert main([path, "vent", "1"], TimedLines) == 0
    switched, released = times
    assert released - switched >= 0.3


def test_vent_keeps_the_lines_for_the_vent_time_when_some_cannot_be_switched(tmp_path, tree):
    begun = time.monotonic()
    released = []

    class HalfGone(RememberedLines):
        def switch(self, active):
            super().switch(active)
            raise HardwareError("/dev/gpiochip2: expected to set lines [3]")

        def release(self):
            released.append(time.monotonic())

    change = {"vent_time": 0.3}
    path = str(hardware_file(tmp_path, tree.root, lambda document: document.update(change)))
    assert main([path, "vent", "1"], HalfGone) == 2
    assert released[0] - begun >= 0.3


def test_what_cannot_be_done_is_said(path, box, capsys):
    assert main([path, "vent", "7"], box) == 2
    assert "outlets must be different numbers from 1 to 6, got [7]" in capsys.readouterr().err


PRINTING_BOARD = """
import numpy as np

class Board:
    def __init__(self, outlets, ambient):
        self.n = len(outlets)
    def set_valves(self, valves):
        print(valves.tolist(), flush=True)
    def read(self):
        return 0.0, np.full(self.n + 1, 1e5)
    def close(self):
        print("closed", flush=True)
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_pulse_that_is_interrupted_ends_with_the_outlet_open(tmp_path, number):
    (tmp_path / "printing_board.py").write_text(PRINTING_BOARD)
    path = tmp_path / "own.yaml"
    path.write_text(
        "format: pneumaticbox-hardware/1\nboard: printing_board:Board\nvent_time: 0.0\n"
    )
    command = [sys.executable, "-m", "pneumaticbox_driver.backends.hardware", str(path)]
    with subprocess.Popen(
        [*command, "--allow-board-module", "pulse", "1", "inflate", "500"],
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as process:
        told = [process.stdout.readline() for _ in range(2)]
        process.send_signal(number)
        told += process.stdout.readlines()
    assert told[:2] == ["[0]\n", "[1]\n"]
    assert told[-2:] == ["[-1]\n", "closed\n"]
    assert "[0]\n" not in told[2:]  # it did not run to its end
