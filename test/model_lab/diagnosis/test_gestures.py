"""Gestures of a hand that tell tied explanations apart: proposed, written as a strategy, made."""

from dataclasses import replace

import numpy as np
import pytest

from grasp_strategies.strategy import load_strategy
from model_lab.bench.layouts import hand_pose_set
from model_lab.bench.trial_runs import TrialRun, run_of, trial_runs
from model_lab.diagnosis.diagnose import diagnose
from model_lab.experiments.hand_pose import HandPose
from model_lab.measurements.measurement_set import down_of
from model_lab.report.text import GESTURE, diagnosis_json, plan_text, write_template
from softhand_model.effects import effect_classes
from softhand_model.effects.hand import Crosstalk
from softhand_model.model_file import load_model

NOISE = 5e-4  # [m]
CLASSES = {"crosstalk": effect_classes()["crosstalk"]}
HIDDEN = Crosstalk.at(**{"from": "d", "to": "a"})(share=0.08)


def measured(runs):
    """The runs of a hand in which a channel leaks into another, cut otherwise than the lab's."""
    data = replace(hand_pose_set(), runs=tuple(runs))
    weight = effect_classes()["gravity"](mass_scale=1.0)
    truth = HandPose(data, segments=7).predict({}, [weight, HIDDEN])[0]
    random = np.random.default_rng(1)
    of_run = np.split(truth, np.flatnonzero(np.diff(data.table.run)) + 1)
    filled = []
    for run, rows in zip(data.runs, of_run, strict=True):
        noisy = rows.reshape(len(data.outputs), run.samples)
        noisy = noisy + NOISE * random.standard_normal(noisy.shape)
        columns = {**run.columns, **dict(zip(data.outputs, noisy, strict=True))}
        filled.append(replace(run, columns=columns))
    return replace(data, runs=tuple(filled))


@pytest.fixture(scope="module")
def together(coarse_hands):
    """Runs in which all channels rise together: which of them leaks does not show."""
    return [r for r in hand_pose_set().runs if r.protocol == "together_fingers_up"]


@pytest.fixture(scope="module")
def outcome(together):
    return diagnose(measured(together), load_model("gravity"), CLASSES)


def test_each_channel_alone_tells_which_one_leaks(outcome, together, tmp_path):
    diagnosis = outcome.diagnosis
    [effect] = diagnosis.effects
    tied = {effect.name, *diagnosis.tied[0]}
    assert tied == {"crosstalk[b>a]", "crosstalk[c>a]", "crosstalk[d>a]"}
    planned = diagnosis.next_experiment
    assert planned["breaks"] and planned["floors"] > 1.0
    assert planned["changes"] == [] and set(planned["separates"][0]) == tied
    said = plan_text(diagnosis_json(diagnosis, ""))
    assert "each channel alone" in said and "roll, pitch, yaw 0, 0, 0 deg" in said

    data = outcome.problem.data
    columns = {name: np.array(course) for name, course in planned["inputs"].items()}
    place = planned["protocol"], "", data.specimens["h1"], planned["temperature"]
    trial = TrialRun(*place, columns, wrist_rpy=tuple(planned["wrist_rpy"]))
    made = [replace(run_of(trial, trial.protocol, data.outputs), name=n) for n in ("a", "b")]
    after = diagnose(measured([*together, *made]), load_model("gravity"), CLASSES).diagnosis
    assert [e.name for e in after.effects] == ["crosstalk[d>a]"] and not any(after.tied)
    low, high = after.effects[0].parameters["share"].interval
    assert low < HIDDEN.values["share"] < high

    write_template(planned, data, tmp_path)
    strategy = load_strategy(str(tmp_path / GESTURE))
    poses = [list(p.pressure.values()) for p in strategy.phases if p.name.startswith("next_a_")]
    poses = [pose for pose in poses if any(pose)]
    assert np.array(poses) == pytest.approx(np.array([*columns.values()]).T[1:], abs=1.0)


def test_gestures_stay_within_the_pressures_so_far_and_count_a_new_attitude(together):
    data = replace(hand_pose_set(), runs=tuple(together))
    highest = max(run.columns["pressure.d"].max() for run in data.runs)
    trials = trial_runs(data, "pneuflex")
    attitudes = set()
    for trial in trials:
        assert max(trial.columns["pressure.d"]) <= highest + 1e-6
        run = run_of(trial, "r", data.outputs)
        attitudes.add(tuple(np.round(down_of(run), 6)))
        assert bool(trial.changes) == (abs(down_of(run) - down_of(together[0])).max() > 0.1)
    assert len(attitudes) == 6 and len({t.protocol for t in trials}) == len(trials)


def test_none_is_proposed_where_the_frame_of_the_markers_is_free():
    data = hand_pose_set()
    hand = replace(data.specimens["h1"].hand, free_frame=True)
    specimens = {"h1": replace(data.specimens["h1"], hand=hand)}
    assert trial_runs(replace(data, specimens=specimens), "pneuflex") == []
