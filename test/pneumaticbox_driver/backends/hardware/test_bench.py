"""The bench of a real box: closed first, never both coils, outlets open whenever it ends."""

import subprocess
import sys
import time

import numpy as np
import pytest

from pneumaticbox_driver.backends.hardware.bench import HardwareBench
from pneumaticbox_driver.backends.hardware.hardware_file import HardwareError


class RememberingBoard:
    """A board of two channels that remembers what it was told."""

    def __init__(self):
        self.told, self.fails, self.pressures = [], None, [1.0e5, 2.0e5, 4.0e5]

    def set_valves(self, valves):
        if self.fails:
            raise self.fails
        self.told.append(valves.tolist())

    def read(self):
        return 12.5, np.array(self.pressures)

    def close(self):
        self.told.append("closed")


@pytest.fixture
def board():
    return RememberingBoard()


@pytest.fixture
def bench(board):
    with HardwareBench(board, 2, vent_time=0.0, silence_limit=60.0) as bench:
        yield bench


def test_the_valves_are_closed_before_anything_else(board, bench):
    assert board.told == [[0, 0]]


def test_commands_reach_the_board_and_readings_come_with_their_time(board, bench):
    assert np.isnan(bench.time)
    bench.command([1, -1])
    np.testing.assert_array_equal(bench.read(), board.pressures)
    assert board.told == [[0, 0], [1, -1]] and bench.time == 12.5


@pytest.mark.parametrize("valves", [[1], [1, 0, 0], [1, 2], [0.5, 0], [np.nan, 0], [[1, 0]]])
def test_what_are_no_valves_moves_nothing(board, bench, valves):
    with pytest.raises(ValueError, match=r"valves must be 2 of -1, 0, 1, got"):
        bench.command(valves)
    assert board.told == [[0, 0]]


def test_at_the_end_the_outlets_open_for_a_while_before_the_board_is_given_back(board):
    bench = HardwareBench(board, 2, vent_time=0.1)
    bench.command([1, 0])
    begun = time.monotonic()
    bench.close()
    bench.close()
    assert time.monotonic() - begun >= 0.1
    assert board.told == [[0, 0], [1, 0], [-1, -1], "closed"]


def test_the_outlets_open_when_the_block_fails(board):
    with pytest.raises(RuntimeError), HardwareBench(board, 2, vent_time=0.0) as bench:
        bench.command([1, 1])
        raise RuntimeError
    assert board.told[-2:] == [[-1, -1], "closed"]


def test_a_closed_bench_takes_no_command_and_reads_nothing(board):
    bench = HardwareBench(board, 2, vent_time=0.0)
    bench.close()
    for call in (lambda: bench.command([1, 1]), bench.read):
        with pytest.raises(HardwareError, match="the bench is closed"):
            call()
    assert board.told[-1] == "closed"


def test_a_board_that_fails_at_the_end_is_given_back_all_the_same(board):
    bench = HardwareBench(board, 2, vent_time=0.0)
    board.fails = OSError("gone")
    with pytest.raises(OSError, match="gone"):
        bench.close()
    assert board.told[-1] == "closed"


def test_a_board_that_cannot_be_closed_at_the_start_is_given_back(board):
    board.fails = HardwareError("no line")
    with pytest.raises(HardwareError, match="no line"):
        HardwareBench(board, 2, vent_time=0.0)
    assert board.told == ["closed"]


def test_a_board_with_another_number_of_sensors_is_refused(board, bench):
    board.pressures = [1e5, 1e5]
    with pytest.raises(HardwareError, match=r"must read 3 pressures, got \(2,\)"):
        bench.read()


def wait_for(condition):
    end = time.monotonic() + 5.0
    while not condition() and time.monotonic() < end:
        time.sleep(0.01)


def test_silence_opens_the_outlets_until_the_next_command(board):
    with HardwareBench(board, 2, vent_time=0.0, silence_limit=0.1) as bench:
        time.sleep(0.3)
        assert board.told == [[0, 0]]  # no command yet: nothing to vent
        bench.command([1, 0])
        begun = time.monotonic()
        wait_for(lambda: board.told[-1] == [-1, -1])
        assert board.told[-1] == [-1, -1]
        assert time.monotonic() - begun > 0.1
        bench.command([0, 0])
        assert board.told[-1] == [0, 0]


def test_commands_in_time_are_never_overruled(board):
    with HardwareBench(board, 2, vent_time=0.0, silence_limit=0.2) as bench:
        for _ in range(40):
            bench.command([1, 0])
            time.sleep(0.01)
    assert board.told.count([-1, -1]) == 1  # at the end


@pytest.mark.parametrize("error", [OSError("busy"), KeyError("a bug of the board's")], ids=repr)
def test_silence_on_a_board_that_fails_is_tried_again(board, error):
    with HardwareBench(board, 2, vent_time=0.0, silence_limit=0.05) as bench:
        bench.command([1, 0])
        board.fails = error
        time.sleep(0.15)
        board.fails = None
        wait_for(lambda: board.told[-1] == [-1, -1])
        assert board.told[-1] == [-1, -1]


SCRIPT = """
import numpy as np
from pneumaticbox_driver.backends.hardware.bench import HardwareBench

class Board:
    def set_valves(self, valves):
        print(valves.tolist(), flush=True)
    def read(self):
        return 0.0, np.zeros(2)
    def close(self):
        print("closed", flush=True)

bench = HardwareBench(Board(), 1, vent_time=0.0)
bench.command([1])
{end}
"""


@pytest.mark.parametrize("end", ["", "raise RuntimeError", "raise SystemExit(3)"])
def test_a_process_that_ends_or_fails_leaves_the_outlets_open(end):
    command = [sys.executable, "-c", SCRIPT.format(end=end)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.stdout.split("\n")[:-1] == ["[0]", "[1]", "[-1]", "closed"]
