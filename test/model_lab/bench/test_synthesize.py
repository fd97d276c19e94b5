"""Synthesised sets: what is written, what is sealed, and who can tell."""

import re
from pathlib import Path

import numpy as np
import pytest

import model_lab
from model_lab.bench.synthesize import EXPERIMENTS, SEAL, open_seal, synthesize, write_synthesised
from model_lab.cli.main import main
from model_lab.experiments.forward import Forward
from model_lab.measurements.load import load_measurements
from softhand_model.effects import effect_classes


def outputs(data):
    scales = dict(zip(data.outputs, data.output_scales, strict=True))
    parts = [scales[name] * run.columns[name] for run in data.runs for name in data.outputs]
    return np.concatenate(parts)


def rest(made, effects):
    """Measured less what the model with these effects predicts."""
    forward = Forward(made.data, "pneuflex", (), effects, made.truth["calibration"], False)
    return outputs(made.data) - forward.predict(np.zeros((1, 0)))[0]


def hidden_in(made):
    found = []
    for entry in made.truth["effects"]:
        kind = effect_classes()[entry["name"]]
        kind = kind.at(**entry["where"]) if "where" in entry else kind
        found.append(kind(**entry["parameters"]))
    return found


# grasps: rig and lab differ by more than noise, and a test of their own follows them
@pytest.mark.parametrize("experiment", [name for name in EXPERIMENTS if name != "grasp"])
def test_what_is_hidden_explains_the_set_and_without_it_the_model_fails(experiment):
    made = synthesize(experiment, 5, hide=True)
    left = np.sqrt(np.mean(rest(made, hidden_in(made)) ** 2))
    scatter = 0.006 * np.sqrt(np.mean(outputs(made.data) ** 2))
    assert left == pytest.approx(np.hypot(made.truth["noise"], scatter), rel=0.15)
    assert np.sqrt(np.mean(rest(made, []) ** 2)) > 3.0 * left
    samples = {"hand_pose": 12, "hand_motion": 121, "press": 61}.get(experiment, 200)
    assert {run.samples for run in made.data.runs} == {samples}
    assert [len(group) for group in made.data.groups()] == [2] * 6


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
    assert users == {"bench/synthesize.py", "cli/commands.py"}


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
    assert main(["synthesize", "levitation", "--out", str(tmp_path / "set")]) == 2
    said = capsys.readouterr().err
    assert "valve_pulse" in said and "got levitation" in said
    assert not (tmp_path / "set").exists()


@pytest.mark.parametrize("experiment", ["valve_pulse", "base_torque"])
def test_sets_without_a_driven_input_are_read_as_they_were_made(experiment, tmp_path):
    made = synthesize(experiment, 0, hide=False)
    write_synthesised(made, tmp_path / "set")
    read = load_measurements(tmp_path / "set")
    for run, other in zip(made.data.runs, read.runs, strict=True):
        for name, values in run.columns.items():
            assert other.columns[name] == pytest.approx(values, rel=1e-7, abs=1e-12), name


def test_held_tips_are_moderate_loads_for_the_actuator():
    """A pose off the chain's own would pull at it along its length, a hundred times as hard."""
    torque = outputs(synthesize("base_torque", 0, hide=False).data)
    assert 5e-3 < np.abs(torque).max() < 0.2


def test_pulses_go_both_ways_choked_and_not():
    columns = [run.columns for run in synthesize("valve_pulse", 0, hide=False).data.runs]
    ratio = np.concatenate([c["p_out"] / c["p_in"] for c in columns])
    inflating = np.concatenate([c["direction"] for c in columns]) > 0.0
    for way in (ratio[inflating], ratio[~inflating]):
        assert 0.1 < np.mean(way < 0.5283) < 0.9


def test_no_effect_that_shows_is_said_in_one_line(tmp_path, capsys):
    own = tmp_path / "own.py"
    own.write_text(
        "from softhand_model.effects import LoadEffect\n"
        "class Idle(LoadEffect):\n"
        "    name = 'idle'\n"
        "    experiments = frozenset({'uniaxial'})\n"
        "    def modulus_factor(self, temperature):\n"
        "        return 1.0\n"
    )
    folder = tmp_path / "set"
    command = ["synthesize", "uniaxial", "--hide", "--effects", str(own), "--out", str(folder)]
    assert main(command) == 2
    assert (
        "expected one that changes the outputs of uniaxial more than noise does, got idle"
        in capsys.readouterr().err
    )
    assert not folder.exists()
