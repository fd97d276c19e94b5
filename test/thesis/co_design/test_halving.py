"""A search spends its budget to the trial, tries the better designs more often, and goes on."""

from collections import Counter
from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest
from made_up_designs import GOOD, PLAN, made_up, search

from softhand_trials.sweep import read_results
from softhand_trials.sweep.results import Results
from softhand_trials.sweep.run import finish
from thesis.co_design import motions
from thesis.co_design.arms import ARMS, CO_DESIGN, NOISE, RANDOM, SHUFFLED, SINGLE
from thesis.co_design.halving import best_first, learning_curve
from thesis.co_design.hands import broken
from thesis.co_design.trials import SHIPPED
from thesis.co_design.worlds import score


@pytest.mark.parametrize("arm", [*ARMS, SHUFFLED], ids=lambda arm: arm.name)
def test_every_arm_spends_the_same_trials(arm, tmp_path):
    tried = search(tmp_path, arm=arm)
    assert len(tried) == 18
    assert tried[-1].spent == len(read_results(tmp_path)) == PLAN.budget == 3 * (12 + 6 + 4)
    assert Counter(one.trials for one in tried) == {2: 9, 4: 6, 8: 3}


def test_what_is_tried_first_is_the_shipped_pair(tmp_path):
    first = search(tmp_path)[0].values
    assert first == pytest.approx(SHIPPED)


def test_single_arms_leave_the_other_side_as_shipped(tmp_path):
    for arm in SINGLE:
        names = {variable.name for variable in arm.variables}
        for one in search(tmp_path / arm.name, arm=arm):
            assert set(one.values) == names


def test_designs_with_the_better_first_trials_go_on_to_more(tmp_path):
    tried = search(tmp_path)
    records = {record["key"]: record for record in read_results(tmp_path)}
    for begin in range(0, 18, 6):
        first = {True: [], False: []}
        for one in tried[begin : begin + 6]:
            keys = [f"co-design-1/{one.number:04d}/{k:02d}" for k in range(2)]
            first[one.trials > 2].append(score([records[key] for key in keys]))
        assert (len(first[True]), len(first[False])) == (3, 3)
        assert min(first[True]) >= max(first[False])


def test_hands_that_cannot_be_built_cost_no_trial(tmp_path):
    tried = search(tmp_path, arm=RANDOM)
    assert not any(broken(SHIPPED | dict(one.values)) for one in tried)
    assert tried[-1].number + 1 > len(tried), "none of the asked ones was refused"


def test_a_cut_search_goes_on_as_if_it_had_not_been(tmp_path):
    notes = tmp_path / "notes"
    whole = search(tmp_path / "whole", make=made_up(notes))
    lines = (tmp_path / "whole/results.jsonl").read_bytes().splitlines(keepends=True)
    (tmp_path / "cut").mkdir()
    (tmp_path / "cut/results.jsonl").write_bytes(b"".join(lines[:40]) + lines[40][:-9])
    notes.unlink()
    assert search(tmp_path / "cut", make=made_up(notes)) == whole
    assert len(notes.read_text().splitlines()) == PLAN.budget - 40


def test_a_search_learns_and_one_with_shuffled_scores_does_not(tmp_path):
    plan, late = replace(PLAN, generations=12), {}
    few = tuple(v for v in motions.VARIABLES if v.name in ("touch_force", "pitch"))
    for whole in (CO_DESIGN, SHUFFLED):
        arm = replace(whole, variables=few)
        tried = search(tmp_path / arm.name, arm=arm, plan=plan)
        forces = [one.values["touch_force"] for one in tried[-24:]]
        late[arm.name] = np.mean(np.abs(np.array(forces) - GOOD["touch_force"][0]))
    assert late["co-design"] < 0.8 * late["shuffled"]


def test_shuffled_scores_are_those_of_the_generation(tmp_path):
    true, shuffled = search(tmp_path / "a")[:6], search(tmp_path / "b", arm=SHUFFLED)[:6]
    assert [one.values for one in true] == [one.values for one in shuffled]
    scores = [[(one.score, one.trials) for one in found] for found in (true, shuffled)]
    assert scores[0] != scores[1] and sorted(scores[0]) == sorted(scores[1])


def test_noise_needs_no_trial_and_tells_high_scores(tmp_path):
    tried = search(tmp_path, arm=NOISE)
    assert read_results(tmp_path) == [] and tried[-1].spent == 0
    assert 1.0 < best_first(tried, 8)[0].score < 1.25  # true scores reach 1.25


def test_the_course_never_falls_and_counts_whole_courses_alone(tmp_path):
    tried = search(tmp_path)
    found = learning_curve(tried, 8)
    assert [spent for spent, _ in found] == [22, 44, 66]
    scores = [score for _, score in found]
    assert scores == sorted(scores)
    assert (
        scores[-1] == best_first(tried, 8)[0].score == max(o.score for o in tried if o.trials == 8)
    )


def test_a_trial_that_ended_in_an_error_is_not_run_again(tmp_path):
    class Failing:
        key, digest, settings = "one", "d", None

    def run(lines):
        return [{"key": line.key, "digest": line.digest, "error": "lost"} for line in lines]

    workers, line = Mock(run=Mock(side_effect=run)), Failing()
    with Results(tmp_path) as results:
        first, second = (finish(workers, [line], results, again=False) for _ in range(2))
        assert first == second
    assert [len(call.args[0]) for call in workers.run.call_args_list] == [1, 0]


def test_results_of_another_seed_are_refused(tmp_path):
    search(tmp_path)
    lines = (tmp_path / "results.jsonl").read_text().replace('"digest": "', '"digest": "0')
    (tmp_path / "results.jsonl").write_text(lines)
    with pytest.raises(ValueError, match="expected results of this plan"):
        search(tmp_path)
