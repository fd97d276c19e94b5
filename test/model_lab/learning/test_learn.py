"""`model-lab learn` on sets whose effect is outside of the catalogue, from set to simulator."""

import json
import re

import numpy as np
import pytest
from browser import overlapping, printed, render

from bench.hidden import make_set
from model_lab.cli.main import main
from model_lab.learning.learn import learn
from model_lab.live.prediction import ChainPrediction
from model_lab.measurements.load import load_measurements
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
    titles = re.findall(r'<p class="title">(.*?)</p>', page.read_text())
    assert titles == ["Learned curve", "Residual before and after", "Error by candidate"]
    assert (figure["panels"], figure["empty"]) == (3, 0)
    assert "The band holds 95 %." in figure["caption"]
    assert rendered.width == [390, 390] and rendered.smallest >= 14.0
    assert overlapping(figure["plots"]) == []
    _, found = printed(page, told)
    assert (found["pictures"], found["plots"]) == (1, 0)
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
