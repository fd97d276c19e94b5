"""Whatever a bench produces: a verdict, or one line that says what is wrong; never a traceback."""

import json
import warnings

import numpy as np
import pytest
from nasty_sets import bending_sets, other_sets, refused_sets

from model_lab.cli.main import main

USABLE = bending_sets() | other_sets()
REFUSED = refused_sets()
VERDICTS = {"adequate", "effects_missing", "unexplained", "slip"}
REPORTED = ("no_time", "one_pulse_a_run", "no_stretch")
PLANNED = ("single_run", "drifting_gauge_linear", "negative_stress", "pulses")


def _run(arguments):
    """Exit status of a command during which numpy complains of nothing."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        return main([str(argument) for argument in arguments])


NO_MODEL = {
    "below_zero": "the model is one of inflation",
    "no_angle": "tip_angle: expected readings that change with the input, got 0 deg throughout",
}


@pytest.mark.parametrize(("name", "said"), NO_MODEL.items())
def test_what_no_model_can_be_judged_by_is_refused_before_any_search(name, said, tmp_path, capsys):
    folder = USABLE[name].write(tmp_path / "set")
    assert _run(["diagnose", folder, "--model", "base"]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("name", sorted(USABLE.keys() - NO_MODEL.keys()))
def test_diagnose_comes_to_a_verdict_and_writes_a_report(name, tmp_path, capsys):
    folder, out = USABLE[name].write(tmp_path / "set"), tmp_path / "d.json"
    given = ["diagnose", folder, "--model", USABLE[name].model, "--json", out, "--jobs", 1]
    report = tmp_path / "report"
    assert _run([*given, *(["--report", report] if name in REPORTED else [])]) == 0
    if name in REPORTED:
        assert "</html>" in (report / "report.html").read_text()
    content = json.loads(out.read_text())
    assert content["verdict"] in VERDICTS
    assert content["noise_floor"] > 0.0
    assert np.isfinite(content["rmse_before"]) and np.isfinite(content["rmse_after"])
    assert capsys.readouterr().out.strip()


@pytest.mark.parametrize("name", PLANNED)
def test_plan_compare_and_ladder_come_to_an_end(name, tmp_path, capsys):
    folder, model = USABLE[name].write(tmp_path / "set"), USABLE[name].model
    assert _run(["plan", folder, "--model", model, "--jobs", 1]) == 0
    assert _run(["compare", folder, "--model", model]) == 0
    assert _run(["ladder", folder, model]) == 0
    assert "noise floor" in capsys.readouterr().out


def test_strain_in_place_of_a_stretch_is_told_as_a_slip(tmp_path):
    folder, out = REFUSED["strain_for_stretch"].write(tmp_path / "set"), tmp_path / "d.json"
    assert _run(["diagnose", folder, "--model", "base", "--json", out]) == 0
    content = json.loads(out.read_text())
    assert content["verdict"] == "slip"
    assert [slip["name"] for slip in content["slips"]] == ["strain"]


REFUSALS = [
    (name, command)
    for name in REFUSED
    for command in ("compare", "diagnose", "ladder", "plan")
    if name != "strain_for_stretch" or command in ("compare", "ladder")
]


@pytest.mark.parametrize(("name", "command"), REFUSALS)
def test_what_cannot_be_used_is_refused_in_one_line(name, command, tmp_path, capsys):
    folder = REFUSED[name].write(tmp_path / "set")
    given = [folder, "base"] if command == "ladder" else [folder, "--model", "base"]
    assert _run([command, *given]) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err.count("\n") == 1
    assert "experiment.yaml" in shown.err or str(folder) in shown.err
    assert REFUSED[name].refused in shown.err
