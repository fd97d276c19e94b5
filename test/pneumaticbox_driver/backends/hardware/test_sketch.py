"""The shipped Arduino sketch, compiled for this computer, behind a pseudo terminal."""

import os
import pty
import shutil
import subprocess
import time
import tty
from pathlib import Path

import numpy as np
import pytest
from board_process import EXAMPLES

SKETCH = EXAMPLES / "valve_board" / "valve_board.ino"
ARDUINO = Path(__file__).parents[3] / "support" / "arduino"
AMBIENT = 101_325.0
VOLTS = 5.0 / 1023
INFLATE, DEFLATE = {"2": 1, "4": 2}, {"3": 1, "5": 2}  # outlets by pin
# 2.0 V and a short circuit on the outlets' sensors, 3.0 V on the supply's
PINS = f"14:{round(2.0 / VOLTS)} 15:1023 16:{round(3.0 / VOLTS)}"

pytestmark = pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++")


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    program = tmp_path_factory.mktemp("sketch") / "valve_board"
    header = ["-x", "c++", "-include", str(ARDUINO / "Arduino.h")]
    warnings = ["-Wall", "-Wextra", "-Werror"]
    subprocess.run(["g++", *warnings, *header, str(SKETCH), "-o", str(program)], check=True)
    return program


@pytest.fixture
def levels(tmp_path):
    """Levels of the pins that have changed: time [s], pin, level."""

    def read():
        lines = [line.split() for line in (tmp_path / "pins").read_text().splitlines()]
        return [(float(ms) / 1e3, pin, int(level)) for ms, pin, level in lines]

    return read


@pytest.fixture
def path(program, tmp_path):
    """Path of the serial line that the sketch is behind."""
    board, computer = pty.openpty()
    tty.setraw(computer)
    with (tmp_path / "pins").open("wb") as pins:
        process = subprocess.Popen(
            [program], stdin=board, stdout=board, stderr=pins, env={"PINS": PINS}
        )
    yield os.ttyname(computer)
    process.kill()
    process.wait()
    os.close(board)
    os.close(computer)


@pytest.fixture
def board(path, monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLES)
    from text_board import SerialBoard

    board = SerialBoard((2, 1), AMBIENT, path)
    yield board
    board.close()


def valves(levels):
    """What the coils do: +1 inflate, -1 deflate, by outlet; both coils of a valve never are on."""
    state, on = {1: 0, 2: 0}, set()
    for _, pin, level in levels:
        on = on | {pin} if level else on - {pin}
        for pair in ({"2", "3"}, {"4", "5"}):
            assert not pair <= on
        state = {1: 0, 2: 0}
        state |= {INFLATE[pin]: 1 for pin in on & INFLATE.keys()}
        state |= {DEFLATE[pin]: -1 for pin in on & DEFLATE.keys()}
    return state


def test_it_answers_the_driver_and_switches_its_valves(board, levels):
    _, pressures = board.read()
    gauge = [np.nan, 54_200 * 1.8, 155_500 * 2.8]  # outlets 2 and 1, supply
    np.testing.assert_allclose(pressures - AMBIENT, gauge, atol=400.0)
    for told in ([1, -1], [-1, 1], [0, -1], [1, 1], [-1, -1], [0, 0]):
        board.set_valves(np.array(told))
        board.read()  # which fails unless the valves have been taken
        assert valves(levels()) == {2: told[0], 1: told[1]}


def test_without_valves_it_opens_the_outlets_after_250_ms(board, levels):
    board.set_valves(np.array([1, 0]))
    end = time.monotonic() + 5.0
    while valves(levels()) != {1: -1, 2: -1}:
        assert time.monotonic() < end
        board.read()  # questions do not hold the valves
    times = {pin: at for at, pin, level in levels() if level}
    assert times["3"] - times["4"] > 0.25
    board.set_valves(np.array([1, 0]))
    board.read()
    assert valves(levels()) == {1: 0, 2: 1}


@pytest.mark.parametrize(
    "spoilt",
    [
        b"5 valves 1:+1 *00\n",
        b"5 valves 1:+1\n",
        b"\xff\xfe*valves 1:+1 *\n",
        b"5 valves 1:+1 " * 50 + b"\n",
        b"\n*\n",
    ],
)
def test_lines_that_are_spoilt_move_nothing(board, levels, spoilt):
    os.write(board.link, spoilt)
    board.read()
    assert levels() == []


@pytest.mark.parametrize("words", ["3:+1", "0:+1", "1:+2", "1:x", "1", "1:", "1:+1 2:9"])
def test_valves_that_are_none_are_refused_whole(board, levels, words):
    board.send(f"valves {words}", valves=True)
    with pytest.raises(OSError, match="has not taken the valves"):
        board.read()
    assert levels() == []
