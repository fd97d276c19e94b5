"""A hand in motion in the lab: from a synthesised set to a verdict, a model file, the simulator."""

from dataclasses import replace

import numpy as np
import pytest

from model_lab.bench.hand_motion_set import hand_motion_set
from model_lab.bench.synthesize import synthesize, write_synthesised
from model_lab.comparison.add import add_effect, write_model
from model_lab.comparison.compare import compare
from model_lab.diagnosis.diagnose import diagnose
from model_lab.experiments.hand_motion import HandMotion, own_errors
from model_lab.experiments.hand_pose import with_weight
from model_lab.measurements.hands import WRIST_POSE
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import down_of
from softhand_model.effects import effect_classes
from softhand_model.effects.hand_motion import ChannelLag, JointDamping
from softhand_model.effects.load import Gravity
from softhand_model.model_file import load_model

CLASSES = effect_classes()
MOVING = {name: CLASSES[name] for name in ("joint_damping", "channel_lag")}
WEIGHT = Gravity(mass_scale=1.0)


def single(protocols):
    """Runs of a hand of one finger."""
    data = hand_motion_set("single_finger")
    chosen = tuple(run for run in data.runs if run.protocol in protocols)
    return replace(data, runs=chosen)


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def test_from_a_synthesised_set_to_a_model_file(monkeypatch, tmp_path):
    monkeypatch.setattr(
        "model_lab.bench.synthesize.hand_motion_set", lambda: hand_motion_set("single_finger")
    )
    made = synthesize("hand_motion", 1, True, {"channel_lag": CLASSES["channel_lag"]}, noise=0.003)
    write_synthesised(made, tmp_path / "set")
    data = load_measurements(tmp_path / "set")
    (hidden,) = made.truth["effects"]

    answer = diagnose(data, load_model("base"), MOVING).diagnosis.as_json()
    assert answer["verdict"] == "effects_missing"
    (named,) = answer["effects"]
    assert (named["name"], named["where"]) == ("channel_lag", hidden["where"])
    found = named["parameters"]["time_constant"]
    low, high = found["interval"]
    assert low < hidden["parameters"]["time_constant"] < high
    assert answer["rmse_after"] < 1.2 * answer["noise_floor"] < 0.6 * answer["rmse_before"]

    addition = add_effect("channel_lag", data, load_model("base"), CLASSES)
    write_model(tmp_path / "mended.yaml", addition.model)
    mended = load_model(tmp_path / "mended.yaml")
    errors = [compare(data, model).errors.held_out.rmse for model in (load_model(), mended)]
    assert errors[1] < 0.6 * errors[0]


def test_what_few_segments_and_long_steps_are_off_by_is_taken_off():
    data = single(["step_palm_down", "turned_palm_up"])
    exact = HandMotion(data, 40, 5e-4).predict({}, [WEIGHT])
    error = rms(HandMotion(data).predict({}, [WEIGHT]) - exact)
    assert error < 0.5 * rms(HandMotion(data, 8, 0.005).predict({}, [WEIGHT]) - exact)
    stated = rms(own_errors(data, load_model()).whole[-1])
    assert 0.5 * error < stated < 2.0 * error
    calibration = {"modulus_scale[A]": np.array([1.1])}
    softer = [
        m.predict(calibration, [WEIGHT]) for m in (HandMotion(data), HandMotion(data, 40, 5e-4))
    ]
    assert rms(softer[0] - softer[1]) < 1.5 * error


def test_a_lagging_channel_is_a_pressure_that_lags():
    data = single(["step_fingers_up"])
    (run, *_), lag = data.runs, 0.05
    time, pressure = run.columns["time"], run.columns["pressure.a"]
    fine = np.linspace(0.0, time[-1], 100 * (len(time) - 1) + 1)
    course, slow = np.interp(fine, time, pressure), np.zeros(len(fine))
    for k in range(1, len(fine)):
        slow[k] = slow[k - 1] + (fine[k] - fine[k - 1]) / lag * (course[k] - slow[k - 1])
    lagged = replace(run, columns={**run.columns, "pressure.a": np.interp(time, fine, slow)})
    data = replace(data, runs=(run,))
    model = HandMotion(data, 6, 0.005)
    found = model.predict({}, [WEIGHT, ChannelLag.at(channel="a")(time_constant=lag)])
    expected = HandMotion(replace(data, runs=(lagged,)), 6, 0.005).predict({}, [WEIGHT])
    assert rms(found - expected) < 0.03 * rms(found - model.predict({}, [WEIGHT]))


def test_a_swing_dies_with_the_damping():
    data = single(["shaken_fingers_up"])
    model = HandMotion(data, 6, 0.002)
    ways = [
        np.abs(np.diff(model.predict({}, [WEIGHT, JointDamping(time=time)])[0])).sum()
        for time in (0.002, 0.01, 0.05)
    ]
    assert ways[0] > ways[1] > ways[2]


def test_the_weight_is_where_the_wrist_says():
    run = next(run for run in hand_motion_set("single_finger").runs if "palm_down" in run.protocol)
    assert down_of(run) == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)


def without(run, names):
    return replace(run, columns={k: v for k, v in run.columns.items() if k not in names})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda run: without(run, ["time"]), "expected the column time"),
        (
            lambda run: without(run, [WRIST_POSE[4]]),
            "expected all columns wrist.x.*without wrist.qy",
        ),
        (lambda run: replace(run, wrist_rpy=(0.1, 0.0, 0.0)), "wrist_rpy: expected either"),
        (
            lambda run: replace(run, columns={k: v[::2] for k, v in run.columns.items()}),
            "at 100 Hz or more, got 61 samples up to 0.02 s apart",
        ),
    ],
)
def test_what_cannot_be_followed_is_refused(change, message):
    data = hand_motion_set("single_finger")
    data = replace(data, runs=tuple(change(run) for run in data.runs))
    with pytest.raises(ValueError, match=message):
        HandMotion(data)


def test_effects_that_do_not_act_in_motion_are_refused():
    data = single(["step_fingers_up"])
    slow = replace(load_model(), effects=(CLASSES["tube_lag"](time_constant=0.1),))
    with pytest.raises(ValueError, match="expected effects that act in hand_motion, got tube_lag"):
        with_weight(data, slow)
