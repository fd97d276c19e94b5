"""The command line: results on the standard output, one line on the standard error if refused."""

import json
import shlex
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from measurement_folder import csv_text
from measurement_folder import write_set as write_folder
from tensile_set import tensile_set

from model_lab.cli.main import COMMANDS, main, make_parser
from softhand_common.documents.yaml_document import DocumentError
from softhand_model.model_file import load_model

OWN = """
from softhand_model.effects import ElasticEffect, Parameter

class Own(ElasticEffect):
    name = "own_stiffening"
    experiments = frozenset({"uniaxial"})
    parameters = (Parameter("rate", "", 0.0, 2.0, typical=(0.05, 0.5), neutral=0.0),)

    def stress(self, stress, strain, shape, memory, dt):
        return stress * (1.0 + self.values["rate"] * strain.invariant)
"""


def _stiffened(stretch, _):
    """What a factor 1 + 0.2*J1 adds."""
    return 50e3 * (stretch - stretch**-2) * 0.2 * (stretch**2 + 2.0 / stretch - 3.0)


def _write(folder, **changes):
    """Write a tensile set in units of the bench."""
    data = tensile_set(**changes)
    content = {
        "format": "softhand-measurement/1",
        "experiment": "uniaxial",
        "title": "pulls",
        "specimens": {"bar": {"shear_modulus": 50e3, "batch": "A"}},
        "columns": {"time": {"unit": "s"}, "stretch": {"unit": ""}, "stress": {"unit": "kPa"}},
        "runs": {
            run.name: {"specimen": "bar", "protocol": run.protocol, "file": f"{run.name}.csv"}
            for run in data.runs
        },
    }
    files = {
        f"{run.name}.csv": csv_text({**run.columns, "stress": run.columns["stress"] / 1e3})
        for run in data.runs
    }
    return write_folder(folder, content, files)


@pytest.fixture(scope="module")
def pulls(tmp_path_factory):
    """Folder of a bar that stiffens."""
    return _write(tmp_path_factory.mktemp("pulls"), error=_stiffened)


def _refused(arguments, capsys):
    """The line on the standard error of a command that is refused."""
    try:
        status = main([str(argument) for argument in arguments])
    except SystemExit as ended:  # of the parser
        status = ended.code
    shown = capsys.readouterr()
    assert status == 2
    assert shown.out == ""
    assert shown.err.count("\n") == 1
    return shown.err


def test_compare_prints_and_writes_what_it_finds(pulls, tmp_path, capsys):
    assert main(["compare", str(pulls), "--json", str(tmp_path / "c.json")]) == 0
    shown = capsys.readouterr()
    assert "held out" in shown.out
    assert shown.err == ""
    content = json.loads((tmp_path / "c.json").read_text())
    assert content["rmse_heldout"] > 2.0 * content["noise_floor"]


def test_ladder_names_the_models_in_their_order(pulls, tmp_path, capsys):
    scaled = tmp_path / "scaled.yaml"
    scaled.write_text(
        "format: softhand-model/1\nbase: pneuflex\ncalibration: {modulus_scale: 1.1}\n"
    )
    assert (
        main(["ladder", str(pulls), "base", str(scaled), "--json", str(tmp_path / "l.json")]) == 0
    )
    assert str(scaled) in capsys.readouterr().out
    content = json.loads((tmp_path / "l.json").read_text())
    assert [entry["model"] for entry in content["models"]] == ["base", str(scaled)]


def test_an_effect_of_ones_own_is_added_and_the_error_falls(pulls, tmp_path, capsys):
    own = tmp_path / "own.py"
    own.write_text(OWN)
    out = tmp_path / "models" / "m2.yaml"
    arguments = ["add", "own_stiffening", "--data", str(pulls), "--effects", str(own)]
    assert main([*arguments, "--out", str(out), "--json", str(tmp_path / "a.json")]) == 0
    model = load_model(out, allow_effect_files=True)
    assert model.effects[0].values["rate"] == pytest.approx(0.2, abs=0.01)
    assert model.std["own_stiffening"]["rate"] > 0.0
    assert "falls" in capsys.readouterr().out
    added = json.loads((tmp_path / "a.json").read_text())
    assert added["format"] == "softhand-addition/1"
    assert added["rmse_after"] < 0.5 * added["rmse_before"]
    compare = ["compare", str(pulls), "--model", str(out), "--allow-effect-files"]
    assert main([*compare, "--json", str(tmp_path / "c.json")]) == 0
    compared = json.loads((tmp_path / "c.json").read_text())
    assert compared["rmse_heldout"] == pytest.approx(200.0, rel=0.1)


def test_plan_says_what_it_proposes_or_that_nothing_is_tied(pulls, tmp_path, capsys):
    out = tmp_path / "next"
    command = ["plan", str(pulls), "--out", str(out), "--jobs", "1"]
    assert main([*command, "--json", str(tmp_path / "p.json")]) == 0
    shown = capsys.readouterr().out
    content = json.loads((tmp_path / "p.json").read_text())
    assert content["format"] == "softhand-plan/1"
    assert any(content["tied"]) == (content["next_experiment"] is not None)
    if content["next_experiment"] is None:
        assert "No effects are tied" in shown
        assert content["files"] == [] and not out.exists()
    else:
        assert "next experiment" in shown
        assert content["files"] == [str(out / "next.csv"), str(out / "experiment-part.yaml")]
        assert (out / "next.csv").is_file()


def test_plan_takes_what_diagnose_found_and_does_not_search_again(
    pulls, tmp_path, capsys, monkeypatch
):
    """From the JSON, the folder of the report, or what is kept; not the answer on another set."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    answer, report = tmp_path / "d.json", tmp_path / "report"
    found = ["diagnose", str(pulls), "--jobs", "1", "--json", str(answer), "--report", str(report)]
    assert main(found) == 0
    said = capsys.readouterr().out.splitlines()[0]

    def searched(*_):
        raise AssertionError("the set is searched again")

    monkeypatch.setattr("model_lab.diagnosis.diagnose.diagnose", searched)
    for given in (["--diagnosis", answer], ["--diagnosis", report], []):
        out = tmp_path / f"p{len(list(tmp_path.iterdir()))}.json"
        assert main(["plan", str(pulls), *map(str, given), "--json", str(out)]) == 0
        assert capsys.readouterr().out.splitlines()[0] == said
        planned = json.loads(out.read_text())
        assert planned["next_experiment"] == json.loads(answer.read_text())["next_experiment"]
    other = _write(tmp_path / "other", error=lambda stretch, _: 1.01 * _stiffened(stretch, _))
    refused = _refused(["plan", other, "--diagnosis", answer], capsys)
    assert "run `model-lab diagnose` again" in refused
    with pytest.raises(AssertionError, match="searched again"):
        main(["plan", str(other)])


def test_a_sealed_effect_is_revealed(tmp_path, capsys):
    folder = tmp_path / "set"
    assert main(["synthesize", "uniaxial", "--hide", "--seed", "1", "--out", str(folder)]) == 0
    assert main(["compare", str(folder)]) == 0
    capsys.readouterr()
    assert main(["reveal", str(folder), "--json", str(tmp_path / "truth.json")]) == 0
    truth = json.loads((tmp_path / "truth.json").read_text())
    assert f"hidden: {truth['effects'][0]['name']}" in capsys.readouterr().out


def test_a_wrong_row_is_told_in_one_line(tmp_path, capsys):
    folder = _write(tmp_path / "set")
    file = folder / "r3.csv"
    lines = file.read_text().splitlines()
    lines[5] = lines[5].replace(lines[5].split(",")[2], "nan")
    file.write_text("\n".join(lines))
    line = _refused(["compare", folder], capsys)
    assert line.startswith("model-lab: ")
    assert f"{file}: row 5 (line 6 of the file), column stress: expected a finite number" in line


def test_a_key_that_the_model_needs_is_told_in_one_line(tmp_path, capsys):
    folder = _write(tmp_path / "set")
    document = folder / "experiment.yaml"
    document.write_text(document.read_text().replace("shear_modulus: 50000.0", "note: unknown"))
    line = _refused(["compare", folder], capsys)
    assert "specimens.bar: expected the key shear_modulus" in line
    assert "--model linear" in line


WRONG = {
    "no set": (["compare", "/nowhere"], "/nowhere/experiment.yaml: expected a readable file"),
    "no model": (["compare", "DATA", "--model", "levity"], "expected one of base, gravity, linear"),
    "unknown effect": (
        ["add", "levity", "--data", "DATA", "--out", "OUT/m.yaml"],
        "got 'levity'",
    ),
    "a typing error": (
        ["add", "tube_lagg", "--data", "DATA", "--out", "OUT/m.yaml"],
        "got 'tube_lagg'; did you mean tube_lag?",
    ),
    "how to begin a set": (["compare", "/nowhere"], "`model-lab import FILE... -o SET` begins"),
    "no file of effects": (
        ["add", "x", "--data", "DATA", "--out", "OUT/m.yaml", "--effects", "/no.py"],
        "/no.py: expected a Python file",
    ),
    "name of the model": (["add", "x", "--data", "DATA", "--out", "OUT/m"], "that ends in .yaml"),
    "no experiment": (["synthesize", "levity", "--out", "OUT/s"], "got levity"),
    "no seal": (["reveal", "DATA"], ".seal: expected the file that names the hidden"),
    "no command": ([], "the following arguments are required: COMMAND"),
    "unknown command": (["explain"], "explain"),
    "no processes": (
        ["diagnose", "DATA", "--jobs", "0"],
        "--jobs: expected a whole number not below 1, got 0",
    ),
    "no seed": (
        ["diagnose", "DATA", "--seed", "x"],
        "--seed: expected a whole number not below 0, got x",
    ),
    "no place to write": (
        ["synthesize", "uniaxial", "--out", "/proc/set"],
        "/proc/set/experiment.yaml: expected a place to write to",
    ),
    "no noise": (
        ["synthesize", "uniaxial", "--noise", "0", "--out", "OUT/s"],
        "noise: expected a number between 0 and 1, got 0",
    ),
    "no folder": (
        ["synthesize", "uniaxial", "--out", "DATA/r1.csv"],
        "expected the name of a folder",
    ),
    "no such option": (["compare", "DATA", "--levity"], "--levity"),
}


@pytest.mark.parametrize(("arguments", "part"), WRONG.values(), ids=WRONG)
def test_unusable_input_is_told_in_one_line(arguments, part, pulls, tmp_path, capsys):
    placed = [a.replace("DATA", str(pulls)).replace("OUT", str(tmp_path)) for a in arguments]
    assert part in _refused(placed, capsys)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_every_command_has_examples_and_units(command, capsys):
    with pytest.raises(SystemExit) as ended:
        main([command, "--help"])
    text = capsys.readouterr().out
    assert ended.value.code == 0
    examples = [line for line in text.splitlines() if line.startswith(f"  model-lab {command} ")]
    assert examples
    assert any(word in text for word in ("SI units", "kPa", "Units:"))
    for line in examples:  # they parse
        arguments = shlex.split(line.split(" && ")[0])[1:]
        assert make_parser().parse_args(arguments).command == command


@pytest.mark.parametrize(
    "arguments",
    [
        ["compare", "DATA", "--json", "FILE"],
        ["ladder", "DATA", "base", "--json", "FILE"],
        ["add", "gent_stiffening", "--data", "DATA", "--out", "FILE"],
        ["diagnose", "DATA", "--json", "FILE"],
        ["plan", "DATA", "--json", "FILE"],
    ],
    ids=lambda arguments: arguments[0],
)
def test_nothing_is_overwritten_unless_forced(arguments, pulls, tmp_path, capsys):
    file = tmp_path / "result.yaml"
    file.write_text("mine")
    placed = [a.replace("DATA", str(pulls)).replace("FILE", str(file)) for a in arguments]
    line = _refused(placed, capsys)
    assert f"{file}: expected a new file" in line
    assert "--force" in line
    assert file.read_text() == "mine"


def test_force_overwrites(pulls, tmp_path):
    file = tmp_path / "c.json"
    file.write_text("old")
    assert main(["compare", str(pulls), "--json", str(file), "--force"]) == 0
    assert json.loads(file.read_text())["format"] == "softhand-comparison/1"


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help(command, capsys):
    with pytest.raises(SystemExit) as ended:
        main([command, "--help"])
    assert ended.value.code == 0
    assert command in capsys.readouterr().out


def test_the_package_runs_as_a_module(pulls):
    done = subprocess.run(
        [sys.executable, "-m", "model_lab", "compare", str(pulls), "--model", "linear"],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    assert "base linear" in done.stdout


def test_a_reader_that_has_seen_enough_is_no_error(pulls):
    done = subprocess.run(
        f"{sys.executable} -m model_lab compare {pulls} | head -1",
        shell=True,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.stdout.count("\n") == 1
    assert "Error" not in done.stderr


def test_noise_alone_is_within_the_floor(tmp_path, capsys):
    assert main(["compare", str(_write(tmp_path / "set"))]) == 0
    assert "within the noise floor" in capsys.readouterr().out


def test_a_fault_of_the_lab_is_not_told_as_one_of_the_input(monkeypatch, capsys):
    def fails(_):
        np.zeros(0).min()

    def refuses(_):
        raise DocumentError("r1.csv: expected numbers, got none")

    for run, status in ((fails, 70), (refuses, 2)):
        monkeypatch.setitem(COMMANDS, "compare", replace(COMMANDS["compare"], run=run))
        assert main(["compare", "set"]) == status
        said = capsys.readouterr().err
        assert ("Traceback" in said) == ("fault of model-lab" in said) == (status == 70)
