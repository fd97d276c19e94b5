"""The bench of a real box: closed first, never both coils, outlets open whenever it ends."""

import itertools
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from pneumaticbox_driver.backends.hardware.hardware_file import HardwareError
from pneumaticbox_driver.backends.hardware.rig import HardwareRig


class RememberingBoard:
    """A board of two channels that remembers what it was told."""

    def __init__(self):
        self.told, self.fails, self.pressures = [], None, [1.0e5, 2.0e5, 4.0e5]
        self.times = []  # monotonic, of what it was told [s]
        self.time = time.monotonic
        self.free = {call: threading.Event() for call in ("read", "set_valves")}  # else it blocks
        for event in self.free.values():
            event.set()

    def set_valves(self, valves):
        assert self.free["set_valves"].wait(20.0)
        if self.fails:
            raise self.fails
        self.told.append(valves.tolist())
        self.times.append(time.monotonic())

    def read(self):
        assert self.free["read"].wait(20.0)
        return self.time(), np.array(self.pressures)

    def close(self):
        self.told.append("closed")


@pytest.fixture
def board():
    return RememberingBoard()


@pytest.fixture
def bench(board):
    with HardwareRig(board, 2, vent_time=0.0, silence_limit=60.0) as bench:
        yield bench


def test_the_valves_are_closed_before_anything_else(board, bench):
    assert board.told == [[0, 0]]


def test_commands_reach_the_board_and_readings_come_with_their_time(board, bench):
    assert np.isnan(bench.time)
    bench.command([1, -1])
    board.time = lambda: 12.5
    np.testing.assert_array_equal(bench.read(), board.pressures)
    assert board.told == [[0, 0], [1, -1]] and bench.time == 12.5


@pytest.mark.parametrize("valves", [[1], [1, 0, 0], [1, 2], [0.5, 0], [np.nan, 0], [[1, 0]]])
def test_what_are_no_valves_moves_nothing(board, bench, valves):
    with pytest.raises(ValueError, match=r"valves must be 2 of -1, 0, 1, got"):
        bench.command(valves)
    assert board.told == [[0, 0]]


def test_at_the_end_the_outlets_open_for_a_while_before_the_board_is_given_back(board):
    bench = HardwareRig(board, 2, vent_time=0.1)
    bench.command([1, 0])
    begun = time.monotonic()
    bench.close()
    bench.close()
    assert time.monotonic() - begun >= 0.1
    assert board.told == [[0, 0], [1, 0], [-1, -1], "closed"]


def test_the_outlets_open_when_the_block_fails(board):
    with pytest.raises(RuntimeError), HardwareRig(board, 2, vent_time=0.0) as bench:
        bench.command([1, 1])
        raise RuntimeError
    assert board.told[-2:] == [[-1, -1], "closed"]


def test_a_closed_bench_takes_no_command_and_reads_nothing(board):
    bench = HardwareRig(board, 2, vent_time=0.0)
    bench.close()
    for call in (lambda: bench.command([1, 1]), bench.read):
        with pytest.raises(HardwareError, match="the board is closed"):
            call()
    assert board.told[-1] == "closed"


def test_a_board_that_fails_at_the_end_is_given_back_all_the_same(board):
    bench = HardwareRig(board, 2, vent_time=0.0)
    board.fails = OSError("gone")
    with pytest.raises(OSError, match="gone"):
        bench.close()
    assert board.told[-1] == "closed"


def test_a_board_that_cannot_be_closed_at_the_start_is_given_back(board):
    board.fails = HardwareError("no line")
    with pytest.raises(HardwareError, match="no line"):
        HardwareRig(board, 2, vent_time=0.0)
    assert board.told == ["closed"]


def test_a_board_with_another_number_of_sensors_is_refused(board, bench):
    board.pressures = [1e5, 1e5]
    with pytest.raises(HardwareError, match=r"must return 3 pressures, got \(2,\)"):
        bench.read()


def test_a_board_may_read_into_the_same_array_each_time():
    board = RememberingBoard()
    readings = np.zeros(3)
    board.read = lambda: (time.monotonic(), readings)
    with HardwareRig(board, 2, vent_time=0.0, silence_limit=60.0) as bench:
        before = bench.read()
        readings += 1.0
        np.testing.assert_array_equal(before, np.zeros(3))
        np.testing.assert_array_equal(bench.read(), np.ones(3))


def wait_for(condition):
    end = time.monotonic() + 5.0
    while not condition() and time.monotonic() < end:
        time.sleep(0.01)


def test_silence_opens_the_outlets_until_the_next_command(board):
    with HardwareRig(board, 2, vent_time=0.0, silence_limit=0.1) as bench:
        time.sleep(0.3)
        assert board.told == [[0, 0]]  # no command yet: nothing to vent
        bench.command([1, 0])
        begun = time.monotonic()
        wait_for(lambda: board.told[-1] == [-1, -1])
        assert board.told[-1] == [-1, -1]
        assert time.monotonic() - begun > 0.1
        with pytest.raises(HardwareError, match="the outlets have been opened"):
            bench.read()
        bench.command([0, 0])
        assert [0, 0] in board.told[1:]


@pytest.mark.parametrize("valves", [[1, 0], [0, 0], [-1, 0]], ids=str)
def test_outlets_opened_in_silence_stay_open_until_a_reading_has_said_so(board, valves):
    with HardwareRig(board, 2, vent_time=0.0, silence_limit=0.1) as bench:
        bench.command([1, 0])
        wait_for(lambda: board.told[-1] == [-1, -1])
        with pytest.raises(HardwareError, match="the outlets have been opened"):
            bench.command(valves)
        bench.command([-1, -1])  # which they do already
        assert all(told == [-1, -1] for told in board.told[2:])
        with pytest.raises(HardwareError, match="the outlets have been opened"):
            bench.read()


def test_outlets_opened_while_a_reading_is_under_way_are_told_by_it(board):
    with HardwareRig(board, 2, vent_time=0.0, silence_limit=0.05) as bench:
        bench.command([1, 0])
        board.time = lambda: wait_for(lambda: board.told[-1] == [-1, -1]) or time.monotonic()
        with pytest.raises(HardwareError, match="the outlets have been opened|not returned"):
            bench.read()


def test_a_reading_that_fails_does_not_make_up_for_one_that_says_so(board):
    with HardwareRig(board, 2, vent_time=0.0, silence_limit=0.05) as bench:
        bench.command([1, 0])
        wait_for(lambda: board.told[-1] == [-1, -1])
        pressures, board.pressures = board.pressures, []
        with pytest.raises(HardwareError, match="must return 3 pressures"):
            bench.read()
        with pytest.raises(HardwareError, match="the outlets have been opened"):
            bench.command([1, 0])
        board.pressures = pressures
        with pytest.raises(HardwareError, match="the outlets have been opened"):
            bench.read()


def test_silence_opens_the_outlets_within_250_ms(board):
    with HardwareRig(board, 2, vent_time=0.0) as bench:
        latencies = []
        for _ in range(5):  # the quickest counts: others are up to what else the machine does
            bench.command([1, 0])
            begun = board.times[-1]
            wait_for(lambda: board.told[-1] == [-1, -1])
            latencies.append(board.times[board.told.index([-1, -1], -1)] - begun)
            with pytest.raises(HardwareError, match="the outlets have been opened"):
                bench.read()
    assert min(latencies) < 0.25


def test_commands_in_time_are_never_overruled(board):
    with HardwareRig(board, 2, vent_time=0.0, silence_limit=2.0) as bench:
        for _ in range(40):
            bench.command([1, 0])
            time.sleep(0.01)
            bench.read()
    assert board.told.count([-1, -1]) == 1  # at the end


def test_a_reading_that_blocks_neither_holds_the_valves_nor_the_caller(board, bench):
    bench.command([1, 0])
    board.free["read"].clear()
    for _ in range(2):
        with pytest.raises(HardwareError, match="read has not returned in time"):
            bench.read()
    bench.command([-1, -1])
    assert board.told[-1] == [-1, -1]
    board.pressures = [1.0, 2.0, 3.0]
    board.free["read"].set()
    np.testing.assert_array_equal(bench.read(), board.pressures)


def test_a_reading_that_comes_too_late_is_thrown_away(board, bench):
    times = iter([1.0, 2.0])
    board.time = lambda: next(times)
    board.free["read"].clear()
    with pytest.raises(HardwareError, match="read has not returned in time"):
        bench.read()
    board.free["read"].set()
    bench.read()
    assert bench.time == 2.0


def test_valves_that_block_are_reported_and_the_newest_command_is_done_when_they_go_on(board):
    with HardwareRig(board, 2, vent_time=0.0, silence_limit=60.0) as bench:
        board.free["set_valves"].clear()
        for valves in ([1, 0], [0, 1], [-1, -1]):
            told = r"set_valves has not returned .* may be unchanged"
            with pytest.raises(HardwareError, match=told):
                bench.command(valves)
        board.free["set_valves"].set()
        wait_for(lambda: board.told[-1] == [-1, -1])
        assert board.told == [[0, 0], [1, 0], [-1, -1]]


def test_outlets_that_could_not_be_opened_are_opened_as_soon_as_the_board_takes_it(board):
    with HardwareRig(board, 2, vent_time=0.0, silence_limit=60.0) as bench:
        bench.command([1, 0])
        board.fails = OSError("refused")
        with pytest.raises(OSError, match="refused"):
            bench.command([-1, -1])
        board.fails = None
        wait_for(lambda: board.told[-1] == [-1, -1])
        assert board.told[-1] == [-1, -1]


def test_an_error_of_the_reading_says_also_that_the_valves_are_not_taken(board, bench):
    board.free["read"].clear()
    board.fails = OSError("the bus is stuck")
    with pytest.raises(OSError):
        bench.command([1, 0])
    with pytest.raises(HardwareError, match=r"read has not returned in time; the bus is stuck"):
        bench.read()
    board.free["read"].set()
    board.fails = None


@pytest.mark.parametrize("blocked", [["read"], ["set_valves"], ["read", "set_valves"]], ids=str)
def test_a_bench_whose_board_blocks_ends_all_the_same(board, blocked):
    bench = HardwareRig(board, 2, vent_time=0.0)
    bench.command([1, 0])
    for call in blocked:
        board.free[call].clear()
    if "read" in blocked:
        with pytest.raises(HardwareError):
            bench.read()
    if "set_valves" in blocked:
        with pytest.raises(HardwareError, match="has not returned"):
            bench.close()
    else:
        bench.close()
        assert board.told[-2:] == [[-1, -1], "closed"]
    for event in board.free.values():
        event.set()


def test_outlets_that_are_open_already_are_not_waited_for_again(board):
    bench = HardwareRig(board, 2, vent_time=5.0)
    bench._valves.command(np.array([-1, -1], dtype=np.int8))
    bench._valves.open_since -= 5.0  # as if that long ago
    begun = time.monotonic()
    bench.close()
    assert time.monotonic() - begun < 5.0


class WithoutText(Exception):
    def __str__(self):
        raise self.args[0]


class Nameless(type):
    @property
    def __name__(cls):
        raise RuntimeError


class WithoutName(WithoutText, metaclass=Nameless):
    pass


@pytest.mark.parametrize(
    "error",
    [WithoutText(RuntimeError()), WithoutText(SystemExit()), WithoutName(RuntimeError())],
    ids=["text", "exit", "name"],
)
def test_an_error_whose_text_cannot_be_had_ends_no_thread(board, error):
    bench = HardwareRig(board, 2, vent_time=0.0, silence_limit=60.0)
    bench.command([1, 0])
    board.fails = error
    with pytest.raises((WithoutText, HardwareError)):
        bench.command([1, 0])
    board.fails = None
    wait_for(lambda: board.told[-1] == [-1, -1])
    assert board.told[-1] == [-1, -1]
    bench.close()
    assert board.told[-1] == "closed"


def test_an_error_of_a_reading_may_be_without_text(board, bench):
    board.time = lambda: sys.exit(WithoutText(RuntimeError()))
    for _ in range(2):
        with pytest.raises(HardwareError, match="the board raised SystemExit: .* without a text"):
            bench.read()


class InvertingBoard(RememberingBoard):
    """A board of inverted polarity, which inverts the array that it is given."""

    def set_valves(self, valves):
        super().set_valves(valves)
        valves *= -1


def test_a_board_that_changes_the_array_it_is_given_opens_the_outlets_all_the_same():
    board = InvertingBoard()
    bench = HardwareRig(board, 2, vent_time=0.0, silence_limit=0.05)
    valves = np.array([1, 0], dtype=np.int8)
    bench.command(valves)
    wait_for(lambda: len(board.told) > 5)  # the outlets are opened again and again
    bench.close()
    assert valves.tolist() == [1, 0]
    assert board.told[:2] == [[0, 0], [1, 0]] and board.told[-1] == "closed"
    assert all(told == [-1, -1] for told in board.told[2:-1])


def test_outlets_that_the_board_opens_in_part_stay_open_for_the_vent_time(board):
    bench = HardwareRig(board, 2, vent_time=0.2)
    bench.command([1, 0])
    board.fails = HardwareError("one of two chips is gone")
    begun = time.monotonic()
    with pytest.raises(HardwareError, match="one of two chips is gone"):
        bench.close()
    assert time.monotonic() - begun >= 0.2
    assert board.told[-1] == "closed"


NO_READINGS = [None, 7, (1.0,), (1.0, [1e5, "x", 1e5]), ("now", [1e5] * 3), (np.nan, [1e5] * 3)]


@pytest.mark.parametrize("reading", NO_READINGS, ids=repr)
def test_what_is_no_reading_is_refused(reading):
    board = RememberingBoard()
    board.read = lambda: reading
    with (
        HardwareRig(board, 2, vent_time=0.0) as bench,
        pytest.raises(HardwareError, match="must"),
    ):
        bench.read()


def test_a_board_that_wants_to_end_the_process_is_an_error_of_the_board(board, bench):
    board.time = lambda: sys.exit(3)
    with pytest.raises(HardwareError, match="the board raised SystemExit: 3"):
        bench.read()


@pytest.mark.parametrize("error", [OSError("busy"), KeyError("a bug of the board's")], ids=repr)
def test_silence_on_a_board_that_fails_is_tried_again(board, error):
    with HardwareRig(board, 2, vent_time=0.0, silence_limit=0.05) as bench:
        bench.command([1, 0])
        board.fails = error
        time.sleep(0.15)
        board.fails = None
        wait_for(lambda: board.told[-1] == [-1, -1])
        assert board.told[-1] == [-1, -1]


SCRIPT = """
import threading
import numpy as np
from pneumaticbox_driver.backends.hardware.rig import HardwareRig

class Board:
    def set_valves(self, valves):
        print(valves.tolist(), flush=True)
    def read(self):
        threading.Event().wait()
    def close(self):
        print("closed", flush=True)

bench = HardwareRig(Board(), 1, vent_time=0.0)
bench.command([1])
{end}
"""


@pytest.mark.parametrize("end", ["", "raise RuntimeError", "raise SystemExit(3)", "bench.read()"])
def test_a_process_that_ends_or_fails_leaves_the_outlets_open(end):
    command = [sys.executable, "-c", SCRIPT.format(end=end)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    told = [line for line, _ in itertools.groupby(done.stdout.splitlines())]
    assert told == ["[0]", "[1]", "[-1]", "closed"]
