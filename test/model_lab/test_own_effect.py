"""An effect of one's own, from a hidden one in a set to simulator and monitor: the example's."""

import json
import subprocess
import sys
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from model_lab.cli.main import main
from model_lab.live.prediction import ChainPrediction
from softhand_model.chain.chain import discretise
from softhand_model.hand.actuator import load_actuator
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model

OWN = Path(__file__).parents[2] / "examples" / "own_effect.py"
HAND = load_hand("single_finger")


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """Folder with a set in which the effect is hidden, the diagnosis, and the model with it."""
    folder = tmp_path_factory.mktemp("own")
    own = ["--effects", str(OWN)]
    made = ["synthesize", "free_bending", "--hide", "--noise", "0.002", "--seed", "2", *own]
    assert main([*made, "--out", str(folder / "set")]) == 0
    # by processes of its own: they get the effect's class across
    command = ["diagnose", str(folder / "set"), *own, "--jobs", "2"]
    command += ["--json", str(folder / "d.json")]
    subprocess.run([sys.executable, "-m", "model_lab", *command], check=True, capture_output=True)
    added = ["add", "stretching_layer", "--data", str(folder / "set"), *own]
    assert main([*added, "--out", str(folder / "model.yaml")]) == 0
    return folder


def _truth(folder):
    assert main(["reveal", str(folder / "set"), "--json", str(folder / "t.json"), "--force"]) == 0
    (hidden,) = json.loads((folder / "t.json").read_text())["effects"]
    return hidden["parameters"]["compliance"]


def test_it_takes_part_in_the_ranking_and_is_named(told):
    found = json.loads((told / "d.json").read_text())
    assert found["verdict"] == "effects_missing"
    (named,) = found["effects"]
    assert named["name"] == "stretching_layer"
    low, high = named["parameters"]["compliance"]["interval"]
    assert low <= _truth(told) <= high
    assert len(found["ranking"]) > 5


def test_the_error_falls_to_the_floor_with_the_model_that_names_its_file(told, capsys):
    text = (told / "model.yaml").read_text()
    assert "file: " in text and "own_effect.py" in text
    command = ["compare", str(told / "set"), "--model", str(told / "model.yaml")]
    assert main(command) == 2
    assert "--allow-effect-files" in capsys.readouterr().err
    command.append("--allow-effect-files")
    assert main([*command, "--json", str(told / "c.json")]) == 0
    compared = json.loads((told / "c.json").read_text())
    assert compared["rmse_heldout"] < 1.2 * compared["noise_floor"]


def test_simulator_and_monitor_have_it_from_the_same_file(told):
    model = load_model(told / "model.yaml", allow_effect_files=True)
    (effect,) = model.effects
    compliance = effect.values["compliance"]
    assert compliance == pytest.approx(_truth(told), rel=0.1)
    chain = discretise(HAND.chain("finger"), 5, model)
    free = float(load_actuator("P10.finger").tip_angle(40e3 / model.modulus_scale("A")))
    expected = pytest.approx(free / (1.0 + compliance * 40e3), rel=1e-6)
    assert float(chain.step(1e-3, [40e3], np.zeros((5, 3)))[:, 1].sum()) == expected
    prediction = ChainPrediction(HAND.chain("finger"), HAND, model)
    assert prediction.tip_angle(0.01, np.array([40e3]), 293.15) == expected


def test_a_model_file_may_name_it_without_its_file_if_effects_does(told, tmp_path, capsys):
    text = (told / "model.yaml").read_text()
    file = text[text.index("file: ") : text.index(", parameters")]
    bare = tmp_path / "bare.yaml"
    bare.write_text(text.replace(file + ", ", ""))
    compare = ["compare", str(told / "set"), "--model", str(bare)]
    assert main(compare) == 2
    assert "got 'stretching_layer'" in capsys.readouterr().err
    assert main([*compare, "--effects", str(OWN)]) == 0


BROKEN = {
    "syntax": ("def f(:\n", "SyntaxError"),
    "no class": ("x = 1\n", "got no such class"),
    "no method": (
        "name = 'odd'",
        "expected a method of its stage, act_on_load or modulus_factor",
    ),
    "no experiment": (
        "name = 'odd'\n    def modulus_factor(self, t): return 1.0",
        "experiments: expected some of",
    ),
    "leaves": (
        "name, experiments = 'odd', frozenset({'free_bending'})\n"
        "    def modulus_factor(self, t): raise SystemExit(7)",
        "Odd.modulus_factor: expected the code to return, got sys.exit(7)",
    ),
    "no bounds": ("name, parameters = 'odd', (Parameter('x', 'm'),)", "'low' and 'high'"),
}


READERS = [
    *(("diagnose", fault) for fault in BROKEN),
    *product(("plan", "compare", "ladder"), ("syntax", "leaves")),  # they read files as diagnose
]


@pytest.mark.parametrize(("command", "fault"), READERS)
def test_a_broken_file_is_told_in_one_line(told, tmp_path, capsys, command, fault):
    body, message = BROKEN[fault]
    head = "from softhand_model.effects import LoadEffect, Parameter\n"
    text = f"{head}class Odd(LoadEffect):\n    {body}\n" if "'odd'" in body else body
    own = tmp_path / "own.py"
    own.write_text(text)
    models = ["base"] if command == "ladder" else []
    assert main([command, str(told / "set"), *models, "--effects", str(own)]) == 2
    said = capsys.readouterr()
    assert said.out == "" and said.err.count("\n") == 1
    assert str(own) in said.err and message in said.err
