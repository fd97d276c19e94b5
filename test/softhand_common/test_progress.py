"""Long work says what it is at and how far, short work nothing."""

import io

import pytest

from model_lab.report.text import text_table
from softhand_common import progress
from softhand_common.progress import Progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def at_once(monkeypatch):
    monkeypatch.setattr(progress, "LINE_EVERY", 0.0)
    monkeypatch.setattr(progress, "MOVE_EVERY", 0.0)


@pytest.mark.parametrize("stream", [io.StringIO(), Terminal()], ids=["pipe", "terminal"])
def test_short_work_shows_nothing(stream, at_once):
    with Progress("reading", stream) as tell:
        tell("r1", 1, 2)
    assert stream.getvalue() == ""


def test_into_a_pipe_go_lines_that_say_what_is_done_and_how_far(at_once):
    stream = io.StringIO()
    with Progress("diagnosing", stream, patience=0.0) as tell:
        tell("fitting viscoelasticity", 7, 31)
        tell("judging what is left", 0, 0)
    assert stream.getvalue().splitlines()[-2:] == [
        "diagnosing: fitting viscoelasticity, 7 of 31 (00:00)",
        "diagnosing: judging what is left (00:00)",
    ]


def test_into_a_pipe_work_within_work_moves_no_cursor(at_once):
    stream = io.StringIO()
    with Progress("maps", stream, patience=0.0) as whole:
        whole("push", 1, 2)
        with Progress("sweep", stream, patience=0.0) as part:
            part("trial", 3, 9)
    assert "sweep: trial, 3 of 9 (00:00)" in stream.getvalue().splitlines()
    assert "\33" not in stream.getvalue()


def test_into_a_pipe_lines_go_rarely(monkeypatch):
    monkeypatch.setattr(progress, "LINE_EVERY", 3600.0)
    stream = io.StringIO()
    with Progress("reading", stream, patience=0.0) as tell:
        for number in range(100):
            tell("r", number, 100)
    assert stream.getvalue().count("\n") <= 1


def test_a_terminal_has_one_line_that_moves_and_is_taken_away(at_once):
    stream = Terminal()
    with Progress("reading", stream, patience=0.0) as tell:
        tell("r1", 1, 2)
        tell("r2", 2, 2)
    shown = stream.getvalue()
    assert "r1, 1 of 2" in shown and "r2, 2 of 2" in shown and "\n" not in shown
    assert shown.endswith("\r") and shown.split("\r")[-2].strip() == ""


def test_nothing_is_shown_once_work_has_failed(at_once):
    stream = io.StringIO()
    with pytest.raises(ValueError, match="wrong"), Progress("reading", stream, patience=0.0):
        raise ValueError("wrong")
    shown = stream.getvalue()
    assert "\r" not in shown


def test_columns_of_numbers_are_aligned_to_the_right():
    table = text_table([["a", "b"], ["x", "1.5"], ["longer", "-10"]])
    assert table.splitlines() == ["  a         b", "  x       1.5", "  longer  -10"]
