"""Synthesised sets: what is written, what is sealed, and who can tell."""

import re
from pathlib import Path

import numpy as np
import pytest

import model_lab
from model_lab.forward import Forward
from model_lab.loading import load_measurements
from model_lab.main import main
from model_lab.seal import SEAL, open_seal
from model_lab.synthesize import EXPERIMENTS, synthesize, write_synthesised
from softhand_model.effects import effect_classes


def outputs(data):
    return np.concatenate([run.columns[data.outputs[0]] for run in data.runs])


def rest(made, effects):
    """Measured less what the model with these effects predicts."""
    forward = Forward(made.data, "pneuflex", (), effects)
    scale = np.full((1, len(forward.parameters)), made.truth["modulus_scale"])
    return outputs(made.data) - forward.predict(scale)[0]


def hidden_in(made):
    return [
        effect_classes()[entry["name"]](**entry["parameters"]) for entry in made.truth["effects"]
    ]


@pytest.mark.parametrize("experiment", EXPERIMENTS)
def test_what_is_hidden_explains_the_set_and_without_it_the_model_fails(experiment):
    made = synthesize(experiment, 5, hide=True)
    left = np.sqrt(np.mean(rest(made, hidden_in(made)) ** 2))
    scatter = 0.006 * np.sqrt(np.mean(outputs(made.data) ** 2))
    assert left == pytest.approx(np.hypot(made.truth["noise"], scatter), rel=0.15)
    assert np.sqrt(np.mean(rest(made, []) ** 2)) > 3.0 * left


def test_without_hiding_nothing_but_noise_is_left():
    made = synthesize("free_bending", 1, hide=False)
    assert made.truth["effects"] == []
    assert np.std(rest(made, [])) == pytest.approx(made.truth["noise"], rel=0.3)


def test_the_seed_decides_all():
    first, again, other = (synthesize("uniaxial", seed, hide=True) for seed in (1, 1, 2))
    assert np.array_equal(outputs(first.data), outputs(again.data))
    assert first.truth == again.truth
    assert not np.array_equal(outputs(first.data), outputs(other.data))


@pytest.fixture
def folder(tmp_path):
    """A set on disk with an effect sealed in it."""
    written = tmp_path / "set"
    write_synthesised(synthesize("free_bending", 0, hide=True), written)
    return written


def test_a_written_set_is_read_as_it_was_made(folder):
    made, read = synthesize("free_bending", 0, hide=True).data, load_measurements(folder)
    assert read.groups() == made.groups()
    assert [run.temperature for run in read.runs] == [run.temperature for run in made.runs]
    assert outputs(read) == pytest.approx(outputs(made), rel=1e-7, abs=1e-9)
    assert read.noise["tip_angle"] == pytest.approx(made.noise["tip_angle"])
    specimen = read.specimens["thick_base_up"]
    assert (specimen.mount, specimen.batch) == ("base_up", "A")
    assert specimen.values["wall"] == pytest.approx(0.004)


def test_no_file_of_the_folder_gives_the_effect_away(folder):
    (hidden,) = open_seal(folder)["effects"]
    words = [hidden["name"].encode(), *(name.encode() for name in hidden["parameters"])]
    for path in folder.iterdir():
        assert not any(re.search(rb"\b%s\b" % word, path.read_bytes()) for word in words)


def test_only_reveal_opens_seals():
    package = Path(model_lab.__file__).parent
    users = {
        path.relative_to(package).as_posix()
        for path in package.rglob("*.py")
        if re.search(r"open_seal|\.seal\b(?!\s+import seal)", path.read_text(encoding="utf-8"))
    }
    assert users <= {"seal.py", "commands/reveal.py", "commands/synthesize.py"}


def test_reveal_says_what_was_hidden(folder, capsys):
    assert main(["reveal", str(folder)]) == 0
    (hidden,) = synthesize("free_bending", 0, hide=True).truth["effects"]
    assert f"hidden: {hidden['name']}" in capsys.readouterr().out


@pytest.mark.parametrize("broken", [None, "no seal at all"])
def test_reveal_refuses_what_is_no_seal_in_one_line(folder, capsys, broken):
    (folder / SEAL).unlink()
    if broken is not None:
        (folder / SEAL).write_text(broken)
    assert main(["reveal", str(folder)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert ".seal: expected" in said


def test_synthesize_overwrites_only_when_forced(folder, capsys):
    command = ["synthesize", "free_bending", "--out", str(folder)]
    before = (folder / "experiment.yaml").read_bytes(), (folder / "r1a.csv").read_bytes()
    assert main(command) == 2
    assert "--force" in capsys.readouterr().err
    after = (folder / "experiment.yaml").read_bytes(), (folder / "r1a.csv").read_bytes()
    assert after == before
    assert main([*command, "--force"]) == 0
    assert (folder / "r1a.csv").read_bytes() != before[1]


def test_an_experiment_that_cannot_be_synthesised_is_refused_with_those_that_can(tmp_path, capsys):
    assert main(["synthesize", "valve_pulse", "--out", str(tmp_path / "set")]) == 2
    said = capsys.readouterr().err
    assert "free_bending" in said and "got valve_pulse" in said
    assert not (tmp_path / "set").exists()
