"""Long work shows a sign of life, short work none."""

import io
import time

import pytest

from model_lab.cli import options as progress
from model_lab.cli.options import Progress
from model_lab.report.text import text_table


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def quick(monkeypatch):
    monkeypatch.setattr(progress, "LINE_EVERY", 0.02)
    monkeypatch.setattr(progress, "MOVE_EVERY", 0.02)


def _wait_for(stream, text):
    deadline = time.monotonic() + 5.0
    while text not in stream.getvalue() and time.monotonic() < deadline:
        time.sleep(0.01)


def test_short_work_shows_nothing():
    stream = io.StringIO()
    with Progress("reading", stream) as tell:
        tell(0.5)
    assert stream.getvalue() == ""


def test_long_work_shows_lines_where_none_can_be_written_over(quick):
    stream = io.StringIO()
    with Progress("reading", stream, patience=0.01) as tell:
        tell(0.25, "r1")
        _wait_for(stream, "25 %")
        tell(0.5, "r2")
        _wait_for(stream, "50 %")
    lines = stream.getvalue().splitlines()
    assert all(line.startswith("reading:") for line in lines)
    assert any(line.endswith("s, r1") for line in lines)
    assert any(line.startswith("reading: 50 %, 0 s") for line in lines)


def test_long_work_moves_one_line_on_a_terminal_and_takes_it_away(quick):
    stream = Terminal()
    with Progress("reading", stream, patience=0.01):
        _wait_for(stream, "reading")
    assert "\n" not in stream.getvalue()
    assert stream.getvalue().endswith("\r")


def test_nothing_is_shown_once_work_has_failed(quick):
    stream = io.StringIO()
    with pytest.raises(ValueError, match="wrong"), Progress("reading", stream, patience=0.01):
        _wait_for(stream, "reading")
        raise ValueError("wrong")
    shown = stream.getvalue()
    time.sleep(0.1)
    assert stream.getvalue() == shown


def test_columns_of_numbers_are_aligned_to_the_right():
    table = text_table([["a", "b"], ["x", "1.5"], ["longer", "-10"]])
    assert table.splitlines() == ["  a         b", "  x       1.5", "  longer  -10"]
