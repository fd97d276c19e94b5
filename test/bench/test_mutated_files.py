"""Mutated files: a few of every format, and the bench's own eye for what goes wrong."""

import math
import os
import time

import pytest

from bench.robust import files
from bench.robust.files import FORMATS, Format, rows_of, run_format, try_case

FEW = 8


@pytest.mark.parametrize("name", FORMATS)
def test_mutated_files_are_read_or_refused_with_file_and_place(name):
    cases = [try_case(FORMATS[name], name, seed) for seed in range(FEW)]
    assert not [case for case in cases if case.bad]
    assert any(case.message for case in cases)


@pytest.mark.parametrize("name", FORMATS)
def test_the_file_that_is_mutated_is_sound(name, tmp_path):
    FORMATS[name].read(FORMATS[name].write(tmp_path))


def raises(error):
    def read(path):
        raise error

    return read


@pytest.mark.parametrize(
    ("read", "bad"),
    [
        (raises(KeyError("x")), "traceback"),
        (raises(SystemExit(0)), "traceback"),
        (raises(ValueError("expected a number")), "refused without file and place"),
        (raises(ValueError("own.yaml:3: mass: expected\na number")), "refused without file and"),
        (raises(ValueError("own.yaml:3: mass: expected a number, got 'x'")), ""),
        (lambda path: {"mass": [1.0, math.nan]}, "taken, senseless"),
        (lambda path: {"length": -0.1}, "taken, senseless"),
        (lambda path: {"position": -0.1}, ""),
        (lambda path: bytearray(3 * 2**30), "over 1 GB"),
        (lambda path: os._exit(3), "traceback"),
        (lambda path: time.sleep(60.0), "over 5 s"),
    ],
)
def test_what_goes_wrong_is_seen(monkeypatch, read, bad):
    monkeypatch.setattr(files, "HANGS", 3.0)
    monkeypatch.setattr(files, "_warm", lambda name: None)
    monkeypatch.setitem(FORMATS, "friction", Format(FORMATS["friction"].write, read))
    (case,) = run_format("friction", 1, 0)
    assert case.bad.startswith(bad) and bool(case.bad) == bool(bad)
    assert rows_of({"friction": [case]})[-2]["met"] is not bool(bad)
