"""Adding the generic term where no effect of the catalogue explains the error."""

import numpy as np
import pytest

from bench.hidden import make_set
from model_lab.cli.main import main
from model_lab.comparison.add import add_effect
from model_lab.experiments.forward import Forward
from model_lab.measurements.load import load_measurements
from softhand_model.chain.chain import discretise
from softhand_model.effects import effect_classes
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model

COMMAND = ["add", "discrepancy", "--model", "base", "--data"]


@pytest.fixture(scope="module")
def saturated(tmp_path_factory):
    """Free bending under a sensor that stops at an angle: no effect of the catalogue does that."""
    folder = tmp_path_factory.mktemp("saturated") / "set"
    make_set(folder, "free_bending", [("hard_saturation", {})], seed=4, ratio=5.0, noise=0.006)
    return folder


def test_the_generic_term_takes_off_much_of_an_error_that_no_effect_explains(saturated):
    data = load_measurements(saturated)
    addition = add_effect("discrepancy", data, load_model("base"), effect_classes())
    floor = addition.problem.floor.total
    assert addition.before.held_out.rmse > 3.0 * floor
    assert addition.after.held_out.rmse < 0.6 * addition.before.held_out.rmse
    forward = Forward(
        data, effects=(), fixed=addition.model.effects, calibration=addition.model.calibration
    )
    left = forward.measured - forward.predict(forward.start()[None])[0]
    assert np.sqrt(np.mean(left**2)) == pytest.approx(addition.after.fit.rmse, rel=1e-6)


def test_the_model_file_and_the_text_say_that_it_is_no_physics(saturated, tmp_path, capsys):
    out = tmp_path / "m.yaml"
    assert main([*COMMAND, str(saturated), "--out", str(out)]) == 0
    assert "a generic term, not physics" in capsys.readouterr().out
    (line,) = (line for line in out.read_text().splitlines() if "name: discrepancy" in line)
    assert line.endswith("# a generic term, not physics")
    (effect,) = load_model(out).effects
    assert effect.name == "discrepancy"
    finger = load_hand("single_finger").chain("finger")
    bend = discretise(finger, 5, load_model(out)).step(1e-3, [40e3], np.zeros((5, 3)))
    assert np.isfinite(bend).all()


def test_what_the_data_do_not_show_of_it_stays_at_nothing(saturated):
    """No actuator is stretched by more than 2 in these runs."""
    data = load_measurements(saturated)
    addition = add_effect("discrepancy", data, load_model("base"), effect_classes())
    assert addition.model.effects[0].values["a7"] == 0.0
    assert "discrepancy" not in addition.model.std


def test_valve_pulses_have_no_generic_term_and_say_so_in_one_line(tmp_path, capsys):
    make_set(tmp_path / "set", "valve_pulse", [("leakage", {})], seed=1, ratio=4.0, samples=40)
    assert main([*COMMAND, str(tmp_path / "set"), "--out", str(tmp_path / "m.yaml")]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "no rubber is strained" in said and "pulse_bias" in said
