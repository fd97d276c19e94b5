"""The bench's table and file, tried with benchmarks that take no time."""

import importlib
import json
import sys
from pathlib import Path
from types import ModuleType

import pytest

import bench
from bench import __main__ as program
from bench.row import at_least, at_most, stated


@pytest.fixture
def measured(monkeypatch, tmp_path):
    """Run the bench with given rows; what it printed and wrote."""

    def run(rows, capsys):
        module = ModuleType("bench.quick")
        module.run = lambda: rows() if callable(rows) else rows
        monkeypatch.setitem(sys.modules, "bench.quick", module)
        monkeypatch.chdir(tmp_path)
        code = program.main(["quick"])
        return (
            code,
            capsys.readouterr(),
            json.loads((tmp_path / "out/bench/bench.json").read_text()),
        )

    return run


def test_rows_are_printed_and_written_with_the_agreed_keys(measured, capsys):
    rows = [at_least("speed", 0.5, "", 1.0), at_most("drift", 0.2, "mm", 1.0), stated("n", 7, "")]
    code, printed, written = measured(rows, capsys)
    assert code == 0
    assert written == [
        {"name": "speed", "value": 0.5, "unit": "", "target": ">= 1", "met": False},
        {"name": "drift", "value": 0.2, "unit": "mm", "target": "<= 1", "met": True},
        {"name": "n", "value": 7.0, "unit": "", "target": None, "met": None},
    ]
    lines = {line.split()[0]: line.split()[-1] for line in printed.out.splitlines() if line}
    assert (lines["speed"], lines["drift"], lines["n"]) == ("NO", "yes", "-")


def test_a_broken_benchmark_is_named_and_fails_the_run(measured, capsys):
    code, printed, written = measured(lambda: 1 / 0, capsys)
    assert code == 1
    assert "quick could not be run" in printed.err
    assert written == []


def test_a_row_with_other_keys_is_refused(measured, capsys):
    code, printed, _ = measured([{"name": "x"}], capsys)
    assert code == 1 and "expected the keys" in printed.err


def test_every_benchmark_of_the_folder_takes_part():
    names = {file.stem for file in Path(bench.__file__).parent.glob("*.py")} - {"__main__"}
    modules = {name: importlib.import_module(f"bench.{name}") for name in names}
    able = {name for name, module in modules.items() if callable(getattr(module, "run", None))}
    assert set(program.modules()) == able
