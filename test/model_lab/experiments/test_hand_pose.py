"""Poses of a hand in the lab: from a synthesised set to a verdict, a model file, the simulator."""

import re
from dataclasses import replace

import numpy as np
import pytest
import yaml
from held_hand import held, settled_tips
from tracked_body import freed, in_other_frame

from model_lab.bench.layouts import hand_pose_set
from model_lab.bench.synthesize import synthesize, write_synthesised
from model_lab.comparison.add import add_effect, write_model
from model_lab.comparison.compare import compare
from model_lab.diagnosis.diagnose import diagnose
from model_lab.experiments import hand_pose
from model_lab.experiments.forward import Forward
from model_lab.experiments.hand_pose import HandPose, own_error, with_weight
from model_lab.fitting.problem import FitProblem
from model_lab.measurements.hands import HandSpecimen, Marker
from model_lab.measurements.load import load_measurements
from model_lab.measurements.save import write_set
from model_lab.report.sentences import verdict_sentence
from model_lab.report.text import detectable_sentence, diagnosis_text
from model_lab.rules import RULES
from softhand_model.effects import effect_classes
from softhand_model.effects.hand import ActuatorScatter
from softhand_model.model_file import load_model

CLASSES = effect_classes()
SCATTER = {"actuator_scatter": CLASSES["actuator_scatter"]}
PRESSURES = [20e3, 20e3, 20e3, 20e3]


def test_from_a_synthesised_set_to_the_simulator(coarse_hands, tmp_path):
    made = synthesize("hand_pose", 4, True, SCATTER, noise=0.003)
    write_synthesised(made, tmp_path / "set")
    data = load_measurements(tmp_path / "set")
    (hidden,) = made.truth["effects"]

    answer = diagnose(data, load_model("base"), SCATTER).diagnosis.as_json()
    assert answer["verdict"] == "effects_missing"
    (named,) = answer["effects"]
    assert (named["name"], named["where"]) == ("actuator_scatter", hidden["where"])
    factor = named["parameters"]["modulus_factor"]
    truth = hidden["parameters"]["modulus_factor"]
    assert factor["interval"][0] < truth < factor["interval"][1]
    assert answer["rmse_after"] < 1.1 * answer["noise_floor"] < 0.6 * answer["rmse_before"]

    addition = add_effect("actuator_scatter", data, load_model("base"), CLASSES)
    write_model(tmp_path / "mended.yaml", addition.model)
    written = yaml.safe_load((tmp_path / "mended.yaml").read_text())
    assert written["effects"][0]["where"] == hidden["where"]
    assert {effect["name"] for effect in written["effects"]} == {"actuator_scatter", "gravity"}
    mended = load_model(tmp_path / "mended.yaml")
    errors = {
        name: compare(data, model).errors.held_out.rmse
        for name, model in (("before", load_model()), ("after", mended))
    }
    assert errors["after"] < 0.5 * errors["before"]

    finger = hidden["where"]["actuator"]
    with_it, without = (
        settled_tips(held(model), PRESSURES)
        for model in (mended, replace(mended, effects=load_model().effects))
    )
    moved = {tip: float(np.linalg.norm(with_it[tip] - without[tip])) for tip in with_it}
    assert moved.pop(finger) > 3e-3
    assert max(moved.values()) < 1e-9


def test_what_the_search_for_slips_fits_to_the_whole_set_is_not_fitted_again(
    coarse_hands, monkeypatch
):
    data = synthesize("hand_pose", 4, True, SCATTER, noise=0.003).data
    asked, once = [], FitProblem.once

    def counted(problem, make, *key):
        def told():
            asked.append((problem.data.table.value.tobytes(), key))
            return make()

        return once(problem, told, *key)

    monkeypatch.setattr(FitProblem, "once", counted)
    answer = diagnose(data, load_model("base"), SCATTER).diagnosis
    tried = [one for one in asked if one[1][0] == "signature"]
    assert answer.verdict == "effects_missing"
    assert len(tried) == len(set(tried)) > 3


def test_prediction_is_where_the_simulated_hand_rests():
    data = hand_pose_set()
    run = data.runs[4]
    model = load_model()
    predicted = HandPose(replace(data, runs=(run,)), segments=5).predict({}, model.effects)[0]
    places = predicted.reshape(len(data.markers), 3, run.samples)
    pressures = np.array([run.columns[name] for name in data.inputs])
    simulation = held(model, run.wrist_rpy)
    for pose in (0, 7):
        tips = settled_tips(simulation, pressures[:, pose])
        for name, found in zip(data.markers, places, strict=True):
            assert found[:, pose] == pytest.approx(tips[name.removesuffix("_tip")], abs=1e-7)


def test_errors_of_few_segments_and_of_the_sensors_zeros_are_known(monkeypatch):
    data, model = hand_pose_set(), load_model()
    cut, fine = (HandPose(data, n).predict({}, model.effects)[0] for n in (None, 80))
    error = np.sqrt(np.mean((cut - fine) ** 2))
    monkeypatch.setattr(hand_pose, "RULES", replace(RULES, pressure_zero=0.0))
    assert own_error(data, model) == pytest.approx(error, rel=0.2)

    specimens = {"h1": replace(data.specimens["h1"], hand=HandSpecimen("rbo_hand_2", data.hand, 5))}
    simulated = replace(data, specimens=specimens)
    assert own_error(simulated, model) == 0.0
    zeros = 200.0 * np.random.default_rng(6).standard_normal((40, 4))  # [Pa], far above rounding
    monkeypatch.setattr(hand_pose, "RULES", replace(RULES, pressure_zero=200.0))
    run = simulated.runs[4]
    one = replace(simulated, runs=(run,))
    read = HandPose(one).predict({}, model.effects)[0]
    moved = []
    for zero in zeros:
        shifts = dict(zip(simulated.inputs, zero, strict=True))
        columns = {key: column + shifts.get(key, 0.0) for key, column in run.columns.items()}
        off = replace(one, runs=(replace(run, columns=columns),))
        moved.append(HandPose(off).predict({}, model.effects)[0] - read)
    assert own_error(one, model) == pytest.approx(np.sqrt(np.mean(np.square(moved))), rel=0.25)
    five = HandPose(data, 5).predict({}, model.effects)
    assert np.array_equal(HandPose(simulated).predict({}, model.effects), five)


def test_lanes_are_those_of_single_predictions():
    data = hand_pose_set("single_finger")
    data = replace(data, runs=data.runs[:2])
    scatter = ActuatorScatter.at(actuator="finger")
    forward = Forward(data, effects=[scatter])
    lanes = np.array([[1.0, 0.8], [1.1, 1.0], [0.9, 1.2]])
    together = forward.predict(lanes)
    for lane, found in zip(lanes, together, strict=True):
        assert np.array_equal(Forward(data, effects=[scatter]).predict(lane[None])[0], found)
    assert np.abs(np.diff(together, axis=0)).max() > 1e-3


def test_modulus_scale_and_scatter_of_the_only_actuator_are_one():
    data = hand_pose_set("single_finger")
    scatter = ActuatorScatter.at(actuator="finger")
    found = Forward(data, effects=[scatter]).predict(np.array([[1.2, 1.0], [1.0, 1.2]]))
    assert found[0] == pytest.approx(found[1], abs=1e-9)


def test_a_set_is_read_as_it_was_written(tmp_path):
    data = hand_pose_set()
    markers = {"knuckle": Marker("index", 0.4, (0.01, 0.0, 0.0)), "end": Marker("thumb")}
    runs = []
    for number, run in enumerate(data.runs[:2]):
        columns = {name: run.columns[name] for name in data.inputs}
        columns |= {f"{m}.{a}": np.full(run.samples, 0.01 * number) for m in markers for a in "xyz"}
        runs.append(replace(run, columns=columns, wrist_rpy=(0.1, 0.2 * number, 0.0)))
    data = replace(data, runs=tuple(runs), markers=markers)
    write_set(data, tmp_path / "set")
    read = load_measurements(tmp_path / "set")
    assert read.markers == markers
    assert read.outputs[:3] == ("knuckle.x", "knuckle.y", "knuckle.z")
    assert read.inputs == ("pressure.a", "pressure.b", "pressure.c", "pressure.d")
    assert [run.wrist_rpy for run in read.runs] == [(0.1, 0.0, 0.0), (0.1, 0.2, 0.0)]
    assert read.table.value == pytest.approx(data.table.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"markers": {"m": {"actuator": "palm_inner"}}}, "markers.m.actuator: expected one of "),
        ({"markers": {"m": {"actuator": "index", "at": 2.0}}}, "markers.m.at: expected "),
        ({"specimens": {"h1": {"hand": "rbo_hand_9"}}}, "specimens.h1.hand: "),
        ({"specimens": {"h1": {}}}, "specimens.h1: "),
        (
            {"columns": {f"pressure.{channel}": {"unit": "kPa"} for channel in "abcd"}},
            "expected the column .*, or name under `markers` only those that were tracked",
        ),
        (
            {"columns": {"pressure.a": {"unit": "mm"}}},
            "columns.pressure.a.unit: expected a unit of the same ",
        ),
    ],
)
def test_what_is_stated_wrongly_is_named(tmp_path, change, message):
    write_set(hand_pose_set(), tmp_path / "set")
    path = tmp_path / "set" / "experiment.yaml"
    path.write_text(yaml.safe_dump({**yaml.safe_load(path.read_text()), **change}))
    with pytest.raises(ValueError, match=message):
        load_measurements(tmp_path / "set")


def test_how_the_wrist_was_held_must_be_stated(tmp_path):
    write_set(hand_pose_set(), tmp_path / "set")
    path = tmp_path / "set" / "experiment.yaml"
    document = yaml.safe_load(path.read_text())
    first = next(iter(document["runs"]))
    document["runs"][first]["wrist_rpy"] = [0.0, 0.0, 0.0]
    path.write_text(yaml.safe_dump(document))
    assert load_measurements(tmp_path / "set").runs[0].wrist_rpy == (0.0, 0.0, 0.0)
    del document["runs"][first]["wrist_rpy"]
    path.write_text(yaml.safe_dump(document))
    with pytest.raises(ValueError, match=f"runs.{first}: expected the key wrist_rpy, .* got none"):
        load_measurements(tmp_path / "set")


def test_all_actuators_of_one_channel_may_be_a_wrong_sensor(coarse_hands):
    data = synthesize("hand_pose", 4, False, noise=0.0005).data
    runs = (
        replace(run, columns={**run.columns, "pressure.b": 1.25 * run.columns["pressure.b"]})
        for run in data.runs
    )
    found = diagnose(replace(data, runs=tuple(runs)), load_model("gravity"), SCATTER).diagnosis
    assert [effect.name for effect in found.effects] == ["actuator_scatter[index]"]
    assert found.channel == "b"
    assert "all that channel b feeds, its pressure may be wrong" in verdict_sentence(found)
    apart = replace(found, channel=None)
    assert "channel b" not in verdict_sentence(apart)


def test_models_that_statics_of_hands_do_not_have_are_refused():
    data = hand_pose_set()
    assert with_weight(data, load_model("base")).gravity_scale == 1.0
    own = load_model()
    assert with_weight(data, own) is own
    slippery = replace(own, effects=(*own.effects, CLASSES["friction"](factor=0.7)))
    assert with_weight(data, slippery) is slippery  # a hand that touches nothing has it unseen
    slow = replace(own, effects=(*own.effects, CLASSES["tube_lag"](time_constant=0.1)))
    with pytest.raises(ValueError, match="expected effects that act in hand_pose, got tube_lag"):
        diagnose(data, slow)
    with pytest.raises(ValueError, match="base: expected pneuflex for a hand, got linear"):
        compare(data, load_model("linear"))


def test_a_free_frame_leaves_the_same_residual_wherever_the_places_were_tracked(coarse_hands):
    data = synthesize("hand_pose", 3, False, noise=0.003).data
    given = freed(data)
    moved = freed(in_other_frame(data, (0.1, -0.2, 1.5), (0.03, 0.01, -0.02)))
    left = [one.table.value - HandPose(one).predict({}, ())[0] for one in (given, moved)]
    sizes = [np.sqrt(np.mean(residual**2)) for residual in left]
    # the frame is found by the hand as described, by which its weight is turned back, too
    assert sizes[1] == pytest.approx(sizes[0], rel=0.02)


def test_a_hand_that_weighs_more_than_stated_is_named_so_and_the_weight_can_be_added(coarse_hands):
    """The weight that every model of a hand has, 1.4 times as large in the set."""
    made = synthesize("hand_pose", 3, False, noise=1e-3).data
    heavy = Forward(made, fixed=[CLASSES["gravity"](mass_scale=1.4)])
    stated = Forward(made, fixed=[CLASSES["gravity"](mass_scale=1.0)])
    at = np.ones((1, 1))
    more = heavy.predict(at)[0] - stated.predict(at)[0]
    runs = []
    for index, run in enumerate(made.runs):
        columns = dict(run.columns)
        for output, name in enumerate(made.outputs):
            here = (made.table.run == index) & (made.table.output == output)
            columns[name] = columns[name] + more[here]
        runs.append(replace(run, columns=columns))
    data = replace(made, runs=tuple(runs))
    classes = {**SCATTER, "gravity": CLASSES["gravity"]}
    found = diagnose(data, load_model(), classes).diagnosis
    (named,) = found.effects
    low, high = named.parameters["mass_scale"].interval
    assert named.name == "gravity" and low <= 1.4 <= high and high - low < 0.3
    assert "times their nominal mass" in verdict_sentence(found)
    added = add_effect("gravity", data, load_model(), classes)
    assert added.effect.parameters["mass_scale"].value == pytest.approx(1.4, abs=0.05)
    known = [effect for effect in added.model.effects if effect.name == "gravity"]
    assert len(known) == 1


def test_an_adequate_hand_is_told_with_what_would_have_been_found(coarse_hands):
    made = synthesize("hand_pose", 3, False, noise=1e-3).data
    found = diagnose(made, load_model(), SCATTER).diagnosis
    said = detectable_sentence(found)
    assert found.verdict == "adequate" and said in diagnosis_text(found)
    (factor,) = re.findall(r"actuator_scatter from ([0-9.]+[0-9])", said)
    far = {abs(np.log(one.smallest)) for one in found.detectable}
    assert abs(np.log(float(factor))) == pytest.approx(max(far), abs=0.01)
