"""`model-lab learn` on sets whose effect is outside of the catalogue, from set to simulator."""

import json
import re

import numpy as np
import pytest
import yaml
from browser import overlapping, printed, render

from bench.hidden import make_set
from model_lab.bench.synthesize import synthesize, write_synthesised
from model_lab.cli.main import main
from model_lab.learning.courses import answer_of
from model_lab.learning.effect_file import Shape
from model_lab.learning.learn import learn
from model_lab.live.prediction import ChainPrediction
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen
from model_lab.measurements.save import write_set
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model

HAND = load_hand("single_finger")
GAIN = 0.4


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """Folder with a set seen by a camera whose gain grows with the angle, and what follows."""
    folder = tmp_path_factory.mktemp("learn")
    hidden = [("camera_gain", {"gain": GAIN})]
    make_set(folder / "set", "free_bending", hidden, seed=5, samples=100, design="shapes")
    command = ["learn", str(folder / "set"), "--out", str(folder / "camera.py")]
    assert main([*command, "--json", str(folder / "l.json"), "--report", str(folder)]) == 0
    add = ["add", "camera", "--effects", str(folder / "camera.py"), "--data", str(folder / "set")]
    assert main([*add, "--out", str(folder / "camera.yaml")]) == 0
    return folder


def test_stage_form_axis_and_curve_are_those_of_the_truth(told):
    found = json.loads((told / "l.json").read_text())
    assert found["format"] == "softhand-learned/1"
    assert (found["stage"], found["against"]) == ("output", "output")
    assert found["rmse_after"] <= 1.3 * found["noise_floor"] < 0.4 * found["rmse_before"]
    assert {"stage", "form", "against", "rmse_after"} <= set(found["alternatives"][0])
    place, value, low, high = np.array(found["curve"]).T
    assert np.all((low <= value) & (value <= high))
    largest = max(np.abs(run.columns["tip_angle"]).max() for run in _data(told).runs) / (1 + GAIN)
    seen = place <= largest
    truth = 1.0 + GAIN * (np.abs(place[seen]) / largest) ** 1.5
    learned = value[seen] if found["form"] == "factor" else 1.0 + value[seen] / place[seen]
    # up to a constant factor, which the modulus may have instead
    assert np.ptp(learned[1:] / truth[1:]) < 0.12
    assert learned[-1] / learned[1] > 1.25


def test_the_report_shows_the_curve_with_its_band_on_a_phone_too(told):
    page = told / "learned.html"
    assert "on the reading, against tip angle" in page.read_text()
    assert page.stat().st_size <= 6_000_000
    rendered = render(page, told, 390)
    figure = rendered.figure("learned")
    titles = re.findall(r'<span class="title">(.*?)</span>', page.read_text())
    assert titles == ["Learned curve", "Residual before and after", "Error by candidate"]
    assert (figure["panels"], figure["empty"]) == (3, 0)
    assert "The band holds 95 %." in figure["caption"]
    assert rendered.width == [390, 390] and rendered.smallest >= 14.0
    assert overlapping(figure) == []
    _, found = printed(page, told)
    assert found["pictures"] == 3
    assert (told / "learned.png").stat().st_size > 10000


def _data(folder):
    return load_measurements(folder / "set")


def test_the_file_is_added_like_any_other_and_the_error_falls(told, capsys):
    command = ["compare", str(told / "set"), "--model", str(told / "camera.yaml")]
    assert main(command) == 2
    assert "--allow-effect-files" in capsys.readouterr().err
    assert main([*command, "--allow-effect-files", "--json", str(told / "c.json")]) == 0
    found, learned = (json.loads((told / name).read_text()) for name in ("c.json", "l.json"))
    assert found["held_out"]["rmse"] < 1.1 * learned["rmse_after"]


def test_monitor_and_simulator_read_the_same_angle_through_it(told):
    from pneuflex_sim.hand.kinematics import TipSensors

    model = load_model(str(told / "camera.yaml"), allow_effect_files=True)
    plain = load_model("base")
    single = type(model)(model.base, {"modulus_scale": 1.0}, model.effects, springs=model.springs)
    true = ChainPrediction(HAND.chains[0], HAND, plain).tip_angle(0.02, np.array([30e3]), 293.15)
    read = ChainPrediction(HAND.chains[0], HAND, single).tip_angle(0.02, np.array([30e3]), 293.15)
    sensors = TipSensors(single)
    sensors.step(0.02, {"finger": true})
    assert read > 1.01 * true
    assert sensors.readings({"finger": true})["finger"] == pytest.approx(read)


def test_nothing_is_learned_and_no_file_written_where_nothing_is_hidden(tmp_path, capsys):
    make_set(tmp_path / "set", "free_bending", [], seed=8, samples=80)
    command = ["learn", str(tmp_path / "set"), "--out", str(tmp_path / "none.py")]
    assert main([*command, "--json", str(tmp_path / "l.json")]) == 0
    assert "Nothing was learned: the model is adequate" in capsys.readouterr().out
    assert not (tmp_path / "none.py").exists()
    found = json.loads((tmp_path / "l.json").read_text())
    assert found["stage"] is None and "adequate" in found["reason"]


def test_a_wrong_unit_is_told_and_no_curve_is_learned_of_it(tmp_path, capsys):
    make_set(tmp_path / "set", "free_bending", [], seed=8, samples=80)
    document = tmp_path / "set" / "experiment.yaml"
    content = yaml.safe_load(document.read_text())
    assert content["columns"]["pressure"]["unit"] == "kPa"
    content["columns"]["pressure"]["unit"] = "psi"
    document.write_text(yaml.safe_dump(content))
    command = ["learn", str(tmp_path / "set"), "--out", str(tmp_path / "none.py")]
    assert main([*command, "--json", str(tmp_path / "l.json")]) == 0
    said = capsys.readouterr().out
    assert said.startswith("The data fit if pressure is kPa, not psi as stated")
    assert "With that mended: Nothing was learned: the model is adequate" in said
    assert json.loads((tmp_path / "l.json").read_text())["slips"][0]["fits"] == "kPa"


def test_a_set_of_several_outputs_is_refused_in_one_line(tmp_path, capsys):
    write_synthesised(synthesize("base_torque", 1, hide=False), tmp_path / "set")
    assert main(["learn", str(tmp_path / "set"), "--out", str(tmp_path / "torque.py")]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "got base_torque, which has torque_x, torque_y" in said


def bellows(lag=0.2, snap=8.0, offset=0.04, noise=0.004):
    """Blocked tip of another make: chambers that balloon, a late force, a gauge's offset."""
    random, time = np.random.default_rng(3), np.linspace(0.0, 6.0, 61)
    runs = []
    for number, peak in enumerate(np.linspace(10e3, 50e3, 9)):
        pressure = np.where(time < 3.0, peak, 0.0)
        level = 2e-6 * peak * (1.0 + snap / (1.0 + np.exp((38e3 - peak) / 2e3)))
        force = level * np.where(
            time < 3.0, 1.0 - np.exp(-time / lag), np.exp(-np.maximum(time - 3.0, 0.0) / lag)
        )
        columns = {"time": time, "pressure": pressure}
        columns["tip_force"] = force + offset + noise * random.standard_normal(len(time))
        runs.append(Run(f"r{number}", "spa", f"p{number}", 293.15, columns))
    specimens = {"spa": Specimen("spa", {"length": 0.05})}
    return MeasurementSet("blocked_tip", "bellows", specimens, tuple(runs), {"tip_force": noise})


def test_what_several_effects_leave_is_learned_curve_by_curve(tmp_path, capsys):
    write_set(bellows(), tmp_path / "set")
    given = ["--data", str(tmp_path / "set"), "--model"]
    learned = ["learn", str(tmp_path / "set"), "--model", "linear", "--json"]
    assert main([*learned, str(tmp_path / "l.json"), "--out", str(tmp_path / "seen.py")]) == 0
    found = json.loads((tmp_path / "l.json").read_text())
    assert found["stage"] in ("input", "load") and found["against"] == "pressure"
    assert "lag" in {one["form"] for one in found["further"]}
    assert found["rmse_after"] < found["rmse_before"] / 5.0
    assert found["rmse_after"] == pytest.approx(found["further"][-1]["rmse_after"])
    printed = capsys.readouterr().out
    assert "Beside it: a lag" in printed
    allow, model = "--allow-effect-files", "linear"
    for name in ("seen", "seen_2"):
        out = str(tmp_path / f"{name}.yaml")
        effects = ["--effects", str(tmp_path / f"{name}.py"), allow, "--out", out]
        assert main(["add", name, *given, model, *effects]) == 0
        model = out
    assert main(["compare", str(tmp_path / "set"), "--model", model, allow]) == 0


@pytest.mark.parametrize(
    ("answer", "stage"), [("flattens", "output"), ("sets_in", "input"), ("grows", "load")]
)
def test_of_what_a_blocked_tip_cannot_tell_apart_the_likeliest_comes_first(answer, stage):
    kinds = {"output": "output", "input": "pressure", "load": "pressure"}
    places = (0.0, 1.0)
    shapes = [
        Shape("blocked_tip", "pneuflex", at, "offset", kinds[at], places, "", "") for at in kinds
    ]
    assert [s.stage for s in shapes if s.surprise_of(answer) == 0.0] == [stage]


def test_an_answer_is_told_by_where_it_bends():
    plain = np.linspace(0.0, 1.0, 101)
    for changed, expected in (
        (np.minimum(plain, 0.7), "flattens"),
        (np.maximum(plain - 0.2, 0.0), "sets_in"),
        (plain + plain**6, "grows"),
    ):
        assert answer_of(changed, changed - plain, 0.0 * plain) == expected


def test_an_error_that_follows_no_axis_is_not_learned(tmp_path):
    hidden = [("interference", {"size": 0.1, "frequency": 1.1})]
    make_set(tmp_path, "free_bending", hidden, seed=8, samples=100)
    found = learn(load_measurements(tmp_path), load_model("base"))
    assert found.chosen is None
    assert "no curve" in found.reason


def test_drift_from_run_to_run_is_learned_against_their_order(tmp_path):
    hidden = [("fading_gain", {"loss": 0.3, "runs": 3.0})]
    make_set(tmp_path, "free_bending", hidden, seed=4, samples=60, adjacent=True)
    found = learn(load_measurements(tmp_path), load_model("base"))
    assert (found.chosen.shape.stage, found.chosen.shape.against) == ("output", "run_order")
