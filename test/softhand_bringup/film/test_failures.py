"""Pictures of failures: which are typical, that they are run again as they were, the command."""

import json

import numpy as np
import pytest
from PIL import Image

from softhand_bringup.film import failures
from softhand_bringup.film.failures import FAILURE_SIZE, FRAME_OFFSETS, replay, typical
from softhand_trials.sweep import TrialTask, run_task
from softhand_trials.trials import Placement, TrialSettings

IN_THE_AIR = """
format: softhand-strategy/1
name: in_the_air
description: close and lift beside the object
hand: single_finger
phases:
  - {name: close, air_mass: {a: 1.0e-5}, duration: 0.3}
  - {name: lift, wrist: {frame: wrist_level, position: [0, 0, 0.02]}, duration: 0.2}
  - {name: hold, duration: 0.2}
"""


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    """A trial that failed, as a sweep writes it and a file gives it back."""
    path = tmp_path_factory.mktemp("strategy") / "in_the_air.yaml"
    path.write_text(IN_THE_AIR)
    settings = TrialSettings(strategy=str(path), object="ball", step=0.005, segments=3)
    line = TrialTask("air/ball/0,0/1", "ball", (0.0, 0.0), 1, settings, Placement((0.05, 0.02)))
    return json.loads(json.dumps(run_task(line)))


def failed(key, cause, x, y=0.0, phase="close"):
    return {
        "key": key,
        "cause": cause,
        "phase": phase,
        "failed_at": 1.0,
        "placement": {"offset": [x, y]},
    }


RECORDS = [
    *(failed(f"m{x}", "missed", 0.01 * x) for x in range(5)),
    *(failed(f"r{x}", "rolled away", 0.01 * x) for x in range(3)),
    failed("t", "tipped", 0.0),
    {"key": "held", "cause": "", "phase": "", "failed_at": None, "placement": {"offset": [0, 0]}},
    {"key": "lost worker", "error": "its worker was lost 3 times"},
]


def keys(records):
    return [record["key"] for record in records]


def test_typical_is_the_middle_one_of_each_cause_the_most_frequent_first():
    assert keys(typical(RECORDS)) == ["m2", "r1", "t"]
    assert keys(typical(RECORDS, 2)) == ["m2", "r1"]


def test_of_one_cause_alone_the_trials_are_far_apart():
    assert keys(typical(RECORDS[:5])) == ["m2", "m0", "m4"]
    assert keys(typical(RECORDS[:2])) == ["m0", "m1"]
    assert typical(RECORDS[-2:]) == []


def test_a_failure_that_is_run_again_fails_as_it_did(record):
    assert (record["cause"], record["phase"]) == ("missed", "close")
    again = replay(record)
    assert (again.result.cause, again.result.phase) == ("missed", "close")
    start = again.recording.states[0].object_position
    assert start[:2] == pytest.approx([0.05, 0.02], abs=1e-6)


def test_pictures_are_of_times_around_the_failure_and_none_of_before_the_start(record):
    again = replay(record)
    assert again.times[FRAME_OFFSETS.index(0.0)] == pytest.approx(record["failed_at"])
    assert again.times[0] == 0.0
    assert again.times[-1] == pytest.approx(record["failed_at"] + 0.4)
    assert again.result.reason.endswith("all states are recorded")
    joints = [state.joints for state in again.recording.states]
    assert not np.array_equal(joints[0], joints[2])


def test_the_command_draws_a_picture_an_object(record, tmp_path, capsys):
    others = [record | {"key": "air/ball/1,0/1"}, record | {"cause": "tipped", "key": "other"}]
    results = tmp_path / "results.jsonl"
    results.write_text("".join(json.dumps(line) + "\n" for line in [record, *others]))
    out = tmp_path / "pictures"
    assert failures.main([str(tmp_path), "-o", str(out), "--count", "2"]) == 0
    with Image.open(out / "ball.png") as picture:
        width, height = picture.size
    assert width == len(FRAME_OFFSETS) * FAILURE_SIZE[0] and height > 2 * FAILURE_SIZE[1]
    said = capsys.readouterr()
    assert "ball.png: missed, tipped" in said.out
    assert "other: tipped in the record, missed now" in said.err


def test_what_cannot_be_drawn_is_said_in_one_line(record, tmp_path, capsys):
    assert failures.main([str(tmp_path / "none"), "-o", str(tmp_path)]) == 2
    assert "expected results of a sweep, got none" in capsys.readouterr().err
    (tmp_path / "results.jsonl").write_text(json.dumps(record) + "\n")
    assert failures.main([str(tmp_path), "-o", str(tmp_path), "--object", "cup"]) == 2
    assert "--object: expected some of ball, got cup" in capsys.readouterr().err
    held = record | {"failed_at": None, "cause": "", "phase": ""}
    (tmp_path / "results.jsonl").write_text(json.dumps(held) + "\n")
    assert failures.main([str(tmp_path), "-o", str(tmp_path)]) == 0
    assert "ball: no trial failed" in capsys.readouterr().out
