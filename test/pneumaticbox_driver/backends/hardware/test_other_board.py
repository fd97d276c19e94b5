"""The shipped examples of a board of one's own, on a simulated board with faults of its own."""

import os
import threading
import time

import numpy as np
import pytest
from board_process import EXAMPLES, LINKS, BoardProcess
from valve_board import FAULTS

from pneumaticbox_driver.backends.hardware.__main__ import main
from pneumaticbox_driver.backends.hardware.opening import open_rig

AMBIENT = 101_325.0
CLOSED, OPEN = [0, 0], [-1, -1]
# faults of the readings alone, which the box recognises: the board does what it should
OF_SENSORS = {"nan", "frozen", "huge"}


@pytest.fixture(params=LINKS)
def board(request, tmp_path):
    with BoardProcess(request.param, tmp_path) as board:
        yield board


@pytest.fixture
def bench(board, monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLES)
    with open_rig(board.hardware_file, [2, 1], AMBIENT, allow_board_module=True) as bench:
        yield bench


def was_told(board):
    """Words of the last command that reached the board; None before the first."""
    last = board.last("told")
    return None if last is None else last.words


def use(bench, valves, done):
    """Read and command, whatever errors there are, until `done` of the last pressures; None before
    the first. An error may be of a busy machine that kept the board waiting.

    The last pressures, and the errors.
    """
    errors, pressures = set(), None
    end = time.monotonic() + 20.0
    while not done(pressures):
        assert time.monotonic() < end, errors
        for call in (lambda: bench.read(), lambda: bench.command(valves)):
            try:
                found = call()
                pressures = pressures if found is None else found
            except (ValueError, OSError) as error:
                errors.add(str(error))
        time.sleep(0.002)
    return pressures, errors


def was_read(pressures):
    return pressures is not None


def test_the_example_switches_reads_and_vents_at_the_end(board, monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLES)
    with open_rig(board.hardware_file, [2, 1], AMBIENT, allow_board_module=True) as bench:
        pressures, _ = use(bench, CLOSED, was_read)
        np.testing.assert_allclose(pressures, AMBIENT + np.array([0.0, 0.0, 300e3]), atol=3e3)
        assert np.isfinite(bench.time)
        # outlet 2 inflates, as the first channel is that of outlet 2
        use(bench, [1, 0], lambda _: was_told(board) == ("2:1", "1:0"))
    assert board.wait("told", ("2:-1", "1:-1"))


def test_the_simulated_board_fills_and_empties_by_its_physics(board, bench):
    pressures, _ = use(bench, [1, 0], lambda p: was_read(p) and p[0] > AMBIENT + 20e3)
    assert pressures[1] < AMBIENT + 1e3  # the other channel has kept its air
    use(bench, [-1, 0], lambda p: was_read(p) and p[0] < AMBIENT + 2e3)


@pytest.mark.parametrize("fault", sorted(set(FAULTS) - OF_SENSORS))
def test_a_board_that_fails_is_an_error_and_comes_back_by_itself(board, bench, fault):
    use(bench, [1, 0], lambda _: board.inflating)
    begun = board.switch(fault)
    end = time.monotonic() + 10.0
    while True:
        try:
            bench.read()
        except (ValueError, OSError):
            break
        assert time.monotonic() < end
    use(bench, OPEN, lambda _: board.opened is not None and board.opened > begun)
    board.switch("none")
    use(bench, OPEN, was_read)
    use(bench, [1, 0], lambda _: board.inflating)


@pytest.mark.parametrize("fault", sorted(OF_SENSORS))
def test_what_a_sensor_tells_is_passed_on_for_the_box_to_judge(board, bench, fault):
    before, _ = use(bench, CLOSED, was_read)
    board.switch(fault)
    after, _ = use(bench, CLOSED, was_read)
    if fault == "frozen":
        np.testing.assert_array_equal(use(bench, CLOSED, was_read)[0], after)
    else:
        assert not 0.0 < after[1] < 10e6  # of outlet 1
        np.testing.assert_allclose(after[[0, 2]], before[[0, 2]], atol=5e3)


def test_a_board_left_alone_opens_its_outlets_by_its_watchdog(board, monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLES)
    from text_board import NetworkBoard, SerialBoard

    kind = SerialBoard if "path" in board.settings else NetworkBoard
    alone = kind((1, 2), AMBIENT, **board.settings)
    alone.set_valves(np.array([1, 0]))
    end = time.monotonic() + 5.0
    while board.last("watchdog") is None:
        assert time.monotonic() < end
        time.sleep(0.01)
    assert board.last("watchdog").time - board.last("told").time >= 0.25
    alone.close()


def test_a_board_that_answers_nothing_is_vented_by_hand_all_the_same(board, monkeypatch, capsys):
    monkeypatch.syspath_prepend(EXAMPLES)
    import text_board

    monkeypatch.setattr(text_board, "START_LIMIT", 0.2)
    board.switch("silent")
    words = [str(board.hardware_file), "--allow-board-module", "vent", "1", "2"]
    assert main(words) == 0, capsys.readouterr().err
    board.wait("told", ("1:-1", "2:-1"))


def test_a_line_that_cannot_be_closed_does_not_hold_up_the_valves(board, monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLES)
    import text_board

    kind = text_board.SerialBoard if "path" in board.settings else text_board.NetworkBoard
    stuck = kind((1, 2), AMBIENT, **board.settings)
    closing, freed = threading.Event(), threading.Event()

    def close(link, close=os.close):
        closing.set()
        freed.wait(60.0)
        close(link)

    monkeypatch.setattr(text_board.os, "close", close)
    closer = threading.Thread(target=stuck.close)
    closer.start()
    assert closing.wait(60.0)
    errors = []

    def switch():
        try:
            stuck.set_valves(np.array([-1, -1]))
        except OSError as error:
            errors.append(str(error))

    switcher = threading.Thread(target=switch)
    switcher.start()
    switcher.join(20.0)
    told = list(errors)
    freed.set()
    for thread in (closer, switcher):
        thread.join()
    assert told == ["the board is not connected"]


def test_a_board_that_is_not_there_is_an_error_that_moves_nothing(board, monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLES)
    import text_board

    monkeypatch.setattr(text_board, "START_LIMIT", 0.2)
    board.switch("silent")
    with pytest.raises(OSError, match="the board does not answer"):
        open_rig(board.hardware_file, [1], AMBIENT, allow_board_module=True)
    assert board.last("told") is None
