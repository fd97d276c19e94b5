"""Diagnosis of sets in which an independent generator has hidden an effect, or none."""

import json
import shutil
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from bench import hidden
from bench.hidden.people import scarce
from bench.lab.store import first_seed
from model_lab.diagnosis.described import failing_axes
from model_lab.diagnosis.diagnose import candidates_of, diagnose, diagnose_folder
from model_lab.diagnosis.result import ADEQUATE
from model_lab.fitting.noise_floor import REPEATS
from model_lab.fitting.problem import pose_problem
from model_lab.measurements.load import load_measurements
from model_lab.rules import RULES
from softhand_model.effects import effect_classes
from softhand_model.model_file import load_model

KEYS = {
    "format",
    "experiment",
    "verdict",
    "holdout",
    "effects",
    "tied",
    "ranking",
    "not_visible",
    "detectable",
    "calibration",
    "noise_floor",
    "noise_floor_parts",
    "rmse_before",
    "rmse_after",
    "unit",
    "failures",
    "unexplained",
    "next_experiment",
}


SAMPLES = 60  # of a run: the verdicts of 200, in less than half the time


def make_set(folder, experiment, laws, samples=SAMPLES, **options):
    """As of the generator, with fewer samples."""
    return hidden.make_set(folder, experiment, laws, samples=samples, **options)


def diagnosed(folder, experiment, laws, **options):
    """What the lab says of a set, and what was hidden in it."""
    truth = make_set(folder, experiment, [(name, {}) for name in laws], **options)
    return diagnose_folder(folder), truth


def named(answer):
    """Each named effect with those tied with it."""
    return [
        {effect["name"], *tied}
        for effect, tied in zip(answer["effects"], answer["tied"], strict=True)
    ]


@pytest.mark.parametrize(
    ("experiment", "effect", "options"),
    [
        ("free_bending", "gent_stiffening", {}),
        ("free_bending", "viscoelasticity", {}),
        ("free_bending", "pressure_offset", {}),
        ("free_bending", "temperature_modulus", {"design": "temperatures"}),
        ("blocked_tip", "tip_friction", {}),
        ("uniaxial", "hysteresis", {}),
        ("uniaxial", "mooney_rivlin", {}),
        ("valve_pulse", "valve_delay", {}),
        ("valve_pulse", "switching_volume", {}),
    ],
)
def test_a_hidden_effect_is_named_and_the_error_falls_to_the_floor(
    tmp_path, experiment, effect, options
):
    answer, truth = diagnosed(tmp_path, experiment, [effect], seed=2, ratio=4.0, **options)
    assert answer["verdict"] == "effects_missing"
    assert len(answer["effects"]) == 1
    assert effect in named(answer)[0] and len(named(answer)[0]) <= 3
    assert answer["rmse_before"] > 3.0 * answer["noise_floor"]
    assert answer["rmse_after"] < 1.3 * answer["noise_floor"]
    (hidden,) = truth["hidden"]
    if answer["effects"][0]["name"] == effect:
        for name, value in hidden["parameters"].items():
            low, high = answer["effects"][0]["parameters"][name]["interval"]
            middle, reach = 0.5 * (low + high), 0.5 * (high - low)
            assert abs(value - middle) <= 2.0 * reach  # twice a 95 % interval


@pytest.mark.parametrize(
    ("law", "family"),
    [("ogden", {"gent_stiffening", "yeoh_stiffening"}), ("bouc_wen", {"hysteresis"})],
)
def test_an_effect_in_another_form_is_named_by_its_family(tmp_path, law, family):
    answer, _ = diagnosed(tmp_path, "free_bending", [law], seed=1, ratio=5.0)
    assert answer["verdict"] == "effects_missing"
    assert any(family & group for group in named(answer))
    assert answer["rmse_after"] < 2.0 * answer["noise_floor"]


def test_two_effects_are_both_named(tmp_path):
    hidden = ["gent_stiffening", "temperature_modulus"]
    answer, _ = diagnosed(tmp_path, "uniaxial", hidden, seed=1, ratio=3.0, design="temperatures")
    assert {effect["name"] for effect in answer["effects"]} == set(hidden)


def test_three_effects_are_named_and_their_story_is_told(tmp_path):
    hidden = ["gent_stiffening", "temperature_modulus", "hysteresis"]
    answer, _ = diagnosed(tmp_path, "uniaxial", hidden, seed=1, ratio=3.0, design="temperatures")
    assert {effect["name"] for effect in answer["effects"]} == set(hidden)
    story = answer["story"]
    assert [step["name"] for step in story] == [effect["name"] for effect in answer["effects"]]
    errors = [story[0]["rmse_before"], *(step["rmse_after"] for step in story)]
    assert errors == sorted(errors, reverse=True)
    assert (errors[0], errors[-1]) == (answer["rmse_before"], answer["rmse_after"])
    assert answer["unexplained"]["against"] == () and answer["helps"] == ()


@pytest.mark.parametrize("experiment", ["free_bending", "uniaxial", "valve_pulse"])
@pytest.mark.parametrize("seed", [0, 1])
def test_nothing_is_named_in_noise(tmp_path, experiment, seed):
    answer, _ = diagnosed(tmp_path, experiment, [], seed=seed)
    assert answer["verdict"] == "adequate"
    assert not answer["effects"]
    assert not answer["helps"] and not answer["notices"]
    assert answer["detectable"]


@pytest.mark.parametrize("law", ["stuck_encoder", "gain_step", "clamp_slip", "two_leaks"])
def test_what_no_effect_explains_is_called_so_with_what_it_depends_on(tmp_path, law):
    answer, _ = diagnosed(tmp_path, "free_bending", [law], seed=1, ratio=5.0)
    assert answer["verdict"] == "unexplained"
    assert not answer["effects"] and not answer["story"] and not answer["helps"]
    assert answer["unexplained"]["against"]
    assert answer["unexplained"]["rms"] > 2.0 * answer["noise_floor"]


def of_two_runs(folder, law, seed):
    """What the lab says of two runs of one finger without repeats or a stated noise."""
    case = next(case for case in scarce() if case.name == f"two_runs/free_bending/{law}")
    case.make(folder, first_seed(seed), 0.006)
    return diagnose_folder(folder)


def test_of_two_runs_no_effect_is_named_that_does_not_predict_the_other(tmp_path):
    """A zero that steps in one of two runs, to which a drift fits and says nothing of the other."""
    answer = of_two_runs(tmp_path, "clamp_slip", 118)
    assert answer["verdict"] == "unexplained"
    assert answer["effects"] == ()


def test_of_two_runs_what_leaves_much_of_the_other_is_not_said_as_sure(tmp_path):
    answer = of_two_runs(tmp_path, "sensor_drift", 4711)
    assert [effect["name"] for effect in answer["effects"]] == ["sensor_drift"]
    assert 2.0 < answer["rmse_after"] / answer["noise_floor"] < 3.0  # by one step from all: 4.2
    assert answer["guess"] and answer["confidence"] <= RULES.rest_confidence


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    """A small set with an effect that memory does not slow down."""
    folder = tmp_path_factory.mktemp("measured") / "set"
    make_set(folder, "free_bending", [("gent_stiffening", {})], seed=3, ratio=4.0)
    return folder


@pytest.fixture(scope="module")
def answer(measured):
    """What the lab says of it."""
    return diagnose_folder(measured)


def test_the_answer_is_as_the_contract_has_it_and_can_be_written(answer):
    assert answer.keys() >= KEYS
    assert json.loads(json.dumps(answer)) is not None
    estimate = answer["effects"][0]["parameters"]["jm"]
    assert set(estimate) == {"value", "std", "interval", "unit", "undetermined"}
    assert answer["effects"][0]["class"] == "stiffening" and not estimate["undetermined"]
    assert estimate["interval"][0] < estimate["value"] < estimate["interval"][1]
    assert "mooney_rivlin" in {entry["name"] for entry in answer["not_visible"]}


def test_effects_of_hands_and_valves_are_not_listed_for_a_finger_but_ones_own_are(measured, answer):
    listed = {entry["name"] for entry in answer["not_visible"]}
    elsewhere = {"crosstalk", "mount_tilt", "marker_offset", "valve_delay", "wrench_bias"}
    assert not listed & elsewhere
    own = type("Own", (effect_classes()["valve_delay"],), {"name": "own"})
    problem, _ = pose_problem(load_measurements(measured), load_model("base"), {"own": own})
    searched, absent = candidates_of(problem, load_model("base"))
    assert not searched and [entry.name for entry in absent] == ["own"]


def test_the_answer_is_the_same_again_in_two_processes_and_without_other_files(
    measured, answer, tmp_path
):
    copy = shutil.copytree(measured, tmp_path / "copy")
    (copy / ".seal").write_text("anything")
    assert diagnose_folder(copy, jobs=2) == answer


def test_an_effect_of_the_model_file_is_not_named_again(measured, answer):
    data, base = load_measurements(measured), load_model("base")
    jm = answer["effects"][0]["parameters"]["jm"]["value"]
    known = replace(base, effects=(effect_classes()["gent_stiffening"](jm=jm),))
    again = diagnose(data, known).diagnosis
    assert again.verdict == "adequate"
    assert again.rmse_before < 1.3 * again.noise_floor


def test_what_is_said_to_be_detectable_would_have_been_named(tmp_path):
    quiet, _ = diagnosed(tmp_path / "quiet", "free_bending", [], seed=5)
    smallest = next(d["smallest"] for d in quiet["detectable"] if d["name"] == "pressure_offset")
    make_set(
        tmp_path / "loud",
        "free_bending",
        [("pressure_offset", {"offset": 3.0 * abs(smallest)})],
        seed=5,
    )
    loud = diagnose_folder(tmp_path / "loud")
    assert any("pressure_offset" in group for group in named(loud))


def test_a_set_in_which_no_noise_can_be_known_is_refused(tmp_path):
    make_set(tmp_path, "free_bending", [], seed=0, runs=2, repeats=1, samples=12, with_noise=False)
    with pytest.raises(ValueError, match="noise floor: expected repeated runs"):
        diagnose_folder(tmp_path)


def test_noise_of_the_input_is_not_called_an_effect(tmp_path):
    make_set(tmp_path, "free_bending", [], seed=1, noise=0.0005, scatter=0.0005)
    data = load_measurements(tmp_path)
    random = np.random.default_rng(0)
    for run in data.runs:
        run.columns["pressure"] += 150.0 * random.standard_normal(run.samples)
    assert diagnose(data, load_model("base")).diagnosis.effects == ()


@pytest.mark.parametrize(
    ("law", "ratio", "tied"),
    [
        ("pressure_offset", 1.6, {"pressure_offset"}),  # and no dead zone
        ("curved_zero", 2.0, {"pressure_offset"}),  # and no offset of the angle
        ("dead_zone", 1.6, {"dead_zone"}),
        ("second_order_tube", 1.4, {"clock_offset", "tube_lag", "angle_sensor_lag"}),
    ],
)
def test_neighbours_of_a_weak_effect_are_tied_unless_gauges_at_rest_part_them(
    tmp_path, law, ratio, tied
):
    make_set(tmp_path, "free_bending", [(law, {})], ratio=ratio, seed=777)
    alike = ("angle_offset", "section_rounding", *tied, "dead_zone", "pressure_offset")
    known = {name: kind for name, kind in effect_classes().items() if name in alike}
    said = diagnose(load_measurements(tmp_path), load_model("base"), known).diagnosis
    assert named(said.as_json()) == [tied]


def test_the_floor_of_pulses_without_repeats_is_what_the_found_effects_leave(tmp_path):
    """Pulses follow in no order, so to splines all that a model misses looks like noise."""
    hidden = [("injector_flow", {}), ("valve_delay", {})]
    make_set(tmp_path, "valve_pulse", hidden, seed=3, repeats=1, with_noise=False, ratio=8.0)
    said = diagnose_folder(tmp_path)
    assert {name for group in named(said) for name in group} == {"injector_flow", "valve_delay"}
    assert said["noise_floor"] == pytest.approx(said["rmse_after"], rel=0.15)


@pytest.mark.parametrize(
    ("floor", "failing"), [(0.1, ()), (0.8, ("run_order",)), (5.0, ("run_order",))]
)
def test_no_model_is_adequate_within_a_floor_as_large_as_the_readings(floor, failing):
    """Also one that is far larger: in a wrong pose the predictions of repeats scatter, not they."""
    table = SimpleNamespace(value=np.array([-1.0, 1.0]))
    problem = SimpleNamespace(
        floor=SimpleNamespace(source=REPEATS, total=floor), data=SimpleNamespace(table=table)
    )
    judged = SimpleNamespace(verdict=ADEQUATE, problem=problem, named=None)
    assert failing_axes(judged, SimpleNamespace(certain_failures=()), None, False, ()) == failing


def test_an_error_that_oscillates_is_no_noise(tmp_path):
    """It raises the floor of runs without repeats, within which any model would be adequate."""
    options = {"runs": 3, "repeats": 1, "with_noise": False, "noise": 0.006}
    make_set(tmp_path, "uniaxial", [("interference", {})], 200, seed=6, ratio=5.0, **options)
    said = diagnose_folder(tmp_path)
    assert [one["kind"] for one in said["notices"]] == ["line"]
    assert said["rmse_before"] < 1.5 * said["noise_floor"]
    assert (said["verdict"], said["unexplained"]["against"]) == (
        "unexplained",
        ("time_since_step",),
    )
