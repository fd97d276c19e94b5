"""The experiment on posture and actuation: what is said of made-up results, what is refused, and
one small run.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from made_up_grasps import write_made_up

from bench.dexterity import posture as bench
from thesis.chapter_8 import posture
from thesis.chapter_8.dexterity.patterns import load_patterns
from thesis.chapter_8.human_postures import human_postures, read_postures
from thesis.chapter_8.posture import Parameters, held_types, report, trials
from thesis.chapter_8.posture_variance import INTERACTION, LINEAR, NONLINEAR, residual_variance
from thesis.frame import Job, save_figure

WITH, BEYOND = "with object more than in the empty hand", "postures beyond 4 components"


@cache
def results(kind):
    made_up = bench.made_up(kind, 1)
    return {
        "types": list(range(1, 31)),
        "left_out": {"31": "not held", "33": "the hand lost the object"},
        "actuation": made_up.actuation,
        "held": made_up.held,
        "empty": made_up.empty,
        "human": {"subject_1": residual_variance(made_up.empty[0]).tolist()},
        "resamples": 200,
        "seed": 0,
    }


@cache
def told(kind):
    return report(results(kind), Parameters())


def met(kind):
    return {f.what: f.met for f in told(kind).findings if f.met is not None}


def ours(kind, what):
    return next(f.ours for f in told(kind).findings if f.what == what)


def test_interaction_is_shown_when_postures_with_an_object_span_more_than_in_the_empty_hand():
    assert met(INTERACTION) == {BEYOND: True, WITH: True}
    assert "the object adds to them" in told(INTERACTION).conclusion


def test_a_map_that_is_not_linear_is_no_interaction_and_the_page_says_not_shown():
    assert met(NONLINEAR) == {BEYOND: True, WITH: False}
    assert ours(NONLINEAR, WITH).startswith("not shown")
    assert told(NONLINEAR).conclusion.endswith("is not shown.")


def test_postures_that_are_linear_in_actuation_are_not_beyond_it():
    assert met(LINEAR) == {BEYOND: False, WITH: False}
    assert "no more dimensions" in told(LINEAR).conclusion


def test_what_was_left_out_is_told_with_its_reason_and_people_stand_beside():
    assert "left out: 31 (not held); 33 (the hand lost the object)" in ours(LINEAR, "grasps")
    assert "components to 95 %" in ours(LINEAR, "people: subject_1")


def test_grasps_count_that_were_held_in_every_trial(tmp_path):
    patterns = load_patterns(write_made_up(tmp_path / "patterns.yaml"))
    assert held_types(patterns) == (2, 3)
    untried = {3: replace(patterns.grasps[3], trials=(), held=0)}
    assert held_types(replace(patterns, grasps=untried)) == ()


def test_a_trial_has_the_same_draw_with_object_and_without(tmp_path):
    patterns = load_patterns(write_made_up(tmp_path / "patterns.yaml"))
    lines = trials(Parameters(), patterns, (2, 3))
    assert len(lines) == len({line.key for line in lines}) == 8
    draws = {(line.number, line.trial): set() for line in lines}
    for line in lines:
        draws[line.number, line.trial].add(line.draw)
    assert all(len(found) == 1 for found in draws.values())
    assert len(set.union(*draws.values())) == 4


def test_too_few_grasps_are_refused_before_anything_is_run(tmp_path):
    given = Parameters(patterns=str(write_made_up(tmp_path / "patterns.yaml")))
    with pytest.raises(ValueError, match=r"expected 20 grasps or more that were held, got 2"):
        posture.run(given, Job(tmp_path, lambda what, share: None))
    assert not (tmp_path / "trials").exists()


def test_people_s_postures_are_averaged_over_the_repeats_of_a_grasp(tmp_path):
    lines = ["grasp,x,y", *(f"{n},{n},{n * n}" for n in range(5)), "4,6,18"]
    (tmp_path / "one.csv").write_text("\n".join(lines))
    (found,) = human_postures(tmp_path).values()
    assert found.tolist() == [[0, 0], [1, 1], [2, 4], [3, 9], [5, 17]]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a,x,y\n1,2,3\n", "one.csv:1: expected the column grasp and two or more coordinates"),
        ("grasp,x,y\n1,2\n", "one.csv:2: expected 3 values, got 2"),
        ("grasp,x,y\n1,2,up\n", "one.csv:2: expected numbers"),
        ("grasp,x,y\n1,2,nan\n", "one.csv:2: expected finite numbers"),
        ("grasp,x,y\n1,2,3\n", "one.csv: expected 5 grasps or more, got 1"),
    ],
)
def test_a_file_of_people_that_is_unusable_is_refused_with_its_place(tmp_path, text, expected):
    file = tmp_path / "one.csv"
    file.write_text(text)
    with pytest.raises(ValueError, match=expected):
        read_postures(file)


def test_a_small_run_is_taken_up_from_its_lines_with_the_same_outcome(tmp_path, monkeypatch):
    given = Parameters(**{**posture.SMALL, "most": 2})
    job = Job(tmp_path / "run", lambda what, share: None)
    first = posture.run(given, job)
    monkeypatch.setattr(posture.PosedTrial, "result", None)  # nothing is run again
    again = posture.run(given, job)
    assert first["types"] == again["types"] == [1, 2]
    for name, shape in {"held": (2, 2, 15), "empty": (2, 2, 15), "actuation": (2, 4)}.items():
        assert first[name].shape == shape
        assert (first[name] == again[name]).all()
    apart = np.linalg.norm((first["held"] - first["empty"]).reshape(-1, 3), axis=1)
    assert apart.max() > 0.005  # the object is in the way
    assert first["left_out"] == {"3": "not taken", "4": "not taken"}
    found = report(first, given)
    save_figure(posture, results(INTERACTION), found, tmp_path / "figure.png")
    assert (tmp_path / "figure.png").stat().st_size > 20_000
