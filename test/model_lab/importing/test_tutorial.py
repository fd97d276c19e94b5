"""The first tutorial's files become a set as its page says."""

import re
import runpy
import shlex
import sys
from pathlib import Path

import numpy as np
import pytest

from model_lab.cli.main import main
from model_lab.measurements.load import load_measurements

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "start" / "first-verdict.md"


def test_the_files_of_the_tutorial_become_a_set(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["two_csv_files.py"])
    runpy.run_path(str(ROOT / "examples" / "two_csv_files.py"), run_name="__main__")
    command = re.search(
        r"^ *model-lab (import .*)$", PAGE.read_text(encoding="utf-8"), re.MULTILINE
    )
    assert main([*shlex.split(command[1]), "--yes"]) == 0
    said = re.search(r"clock seems (\S+) s late", capsys.readouterr().out)
    assert said[1] in PAGE.read_text(encoding="utf-8")
    assert float(said[1]) == pytest.approx(1.2, abs=0.03)
    run = load_measurements("out/first").runs[0]
    assert np.ptp(run.columns["pressure"]) == pytest.approx(45e3)
    assert run.lead["time"][-1] < run.columns["time"][0] == pytest.approx(1.2)
