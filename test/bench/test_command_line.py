"""Each bench says how to use it, and runs nothing, with `--help`."""

import runpy
import sys
from pathlib import Path

import pytest

import bench
from bench.command_line import chosen_cases

FOLDER = Path(bench.__file__).parent
PROGRAMS = [
    ".".join(file.relative_to(FOLDER.parent).with_suffix("").parts).removesuffix(".__main__")
    for file in sorted(FOLDER.rglob("*.py"))
    if '\nif __name__ == "__main__":' in file.read_text()
]


@pytest.mark.filterwarnings("ignore:.*found in sys.modules:RuntimeWarning")
@pytest.mark.parametrize("program", PROGRAMS)
def test_help_says_how_to_use_a_bench(program, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", [program, "--help"])
    with pytest.raises(SystemExit) as left:
        runpy.run_module(program, run_name="__main__")
    assert not left.value.code
    assert capsys.readouterr().out.startswith("usage: ")


def test_cases_are_those_of_the_command_line_or_all(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["bench"])
    assert chosen_cases("bench.hands", None, 3) == [0, 1, 2]
    monkeypatch.setattr(sys, "argv", ["bench", "2", "0"])
    assert chosen_cases("bench.hands", None, 3) == [2, 0]
    monkeypatch.setattr(sys, "argv", ["bench", "3"])
    with pytest.raises(SystemExit):
        chosen_cases("bench.hands", None, 3)
    assert "expected 0 to 2, got 3" in capsys.readouterr().err
