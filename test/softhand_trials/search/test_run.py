"""Searches find the least cost by a fixed budget, the same on any number of workers."""

from dataclasses import replace

import numpy as np
import pytest

from softhand_trials.search import SearchProblem, Variable, run_search
from softhand_trials.sweep import read_results

BOWL = SearchProblem(
    "bowl",
    "search_objectives:bowl",
    (Variable("x", -1.0, 1.0), Variable("y", -5.0, 5.0)),
    evaluations=40,
    sampler="cma",
    seed=3,
    allow_any=True,
)
TIMES = ("wall_time", "cpu_time", "versions", "process")


def lasting(records):
    return [{k: v for k, v in record.items() if k not in TIMES} for record in records]


def run_counting(problem, folder, notes):
    """The search, and how often its objective has been run."""
    notes.mkdir(exist_ok=True)
    counted = replace(problem, settings={**problem.settings, "runs": str(notes)})
    result = run_search(counted, folder, jobs=0)
    return result, len((notes / "notes").read_text().splitlines())


@pytest.mark.parametrize("sampler", ["cma", "tpe"])
def test_a_search_stays_where_the_cost_is_low_and_chance_does_not(sampler, tmp_path):
    found = run_search(replace(BOWL, evaluations=120, sampler=sampler), tmp_path / "a", jobs=0)
    chance = run_search(replace(BOWL, evaluations=120, sampler="random"), tmp_path / "b", jobs=0)
    assert len(found.records) == len(chance.records) == 120
    late, any_time = (
        np.median([record["cost"] for record in result.records[-40:]]) for result in (found, chance)
    )
    assert late < 0.1 * any_time
    assert found.best["cost"] < 2e-3


def test_one_and_two_workers_and_none_give_the_same_evaluations(tmp_path):
    alone = run_search(BOWL, tmp_path / "0", jobs=0)
    one = run_search(BOWL, tmp_path / "1", jobs=1)
    two = run_search(replace(BOWL, settings={}), tmp_path / "2", jobs=2)
    assert lasting(alone.records) == lasting(one.records) == lasting(two.records)
    assert len({record["process"] for record in two.records}) == 2


def test_another_seed_asks_for_other_values(tmp_path):
    first = run_search(BOWL, tmp_path / "3", jobs=0)
    second = run_search(replace(BOWL, seed=4), tmp_path / "4", jobs=0)
    assert first.records[0]["values"] != second.records[0]["values"]


@pytest.mark.parametrize("kept", [0, 1, 11, 16])
def test_a_search_that_was_cut_goes_on_as_if_it_had_not_been(kept, tmp_path):
    notes = tmp_path / "notes"
    whole, count = run_counting(BOWL, tmp_path / "whole", notes)
    assert count == 40
    cut = tmp_path / "cut"
    cut.mkdir()
    lines = (tmp_path / "whole/results.jsonl").read_bytes().splitlines(keepends=True)
    (cut / "results.jsonl").write_bytes(b"".join(lines[:kept]) + lines[kept][:-9])
    again, count = run_counting(BOWL, cut, notes)
    assert count == 40 + 40 - kept
    assert lasting(again.records) == lasting(whole.records)


def test_a_larger_budget_goes_on_from_where_the_smaller_one_ended(tmp_path):
    notes = tmp_path / "notes"
    run_counting(replace(BOWL, evaluations=21), tmp_path / "out", notes)
    grown, count = run_counting(BOWL, tmp_path / "out", notes)
    assert count == 40
    assert lasting(grown.records) == lasting(run_counting(BOWL, tmp_path / "b", notes)[0].records)


def test_results_of_another_problem_are_refused(tmp_path):
    run_search(BOWL, tmp_path, jobs=0)
    for changed in ({"seed": 4}, {"settings": {"wait": 0.001}}, {"objective": "other:bowl"}):
        with pytest.raises(ValueError, match="got one of the trial bowl/0000"):
            run_search(replace(BOWL, **changed), tmp_path, jobs=0)


def test_evaluations_that_fail_are_kept_told_and_not_tried_again(tmp_path):
    problem = replace(BOWL, objective="search_objectives:half_failing")
    result = run_search(problem, tmp_path, jobs=0)
    assert 0 < result.failed < 40
    assert all(r["values"]["x"] < 0 for r in result.records if "error" in r)
    assert result.best["cost"] < 0.05
    before = (tmp_path / "results.jsonl").read_bytes()
    assert run_search(problem, tmp_path, jobs=0).records == result.records
    assert (tmp_path / "results.jsonl").read_bytes() == before


def test_a_cost_that_is_no_number_is_an_error_of_the_evaluation(tmp_path):
    problem = replace(BOWL, objective="search_objectives:without_cost", evaluations=8)
    result = run_search(problem, tmp_path, jobs=0)
    assert result.failed == 8
    assert "cost: expected a finite number, got nan" in result.records[0]["error"]
    with pytest.raises(ValueError, match="all evaluations ended in errors"):
        _ = result.best


def test_what_is_tried_first_can_be_given(tmp_path):
    problem = replace(BOWL, evaluations=10, start={"x": 0.25, "y": -0.25})
    result = run_search(problem, tmp_path, jobs=0)
    assert result.records[0]["values"] == {"x": 0.25, "y": -0.25}
    assert len(result.records) == len(read_results(tmp_path)) == 10


def test_several_postures_are_tried_first_in_their_order(tmp_path):
    starts = [{"x": 0.1 * k, "y": -0.2 * k} for k in range(6)]
    problem = replace(BOWL, evaluations=9, generation=4, start=starts, sampler="tpe")
    records = run_search(problem, tmp_path, jobs=0).records
    assert [record["values"] for record in records[:6]] == starts
    assert len(records) == 9 and len({str(record["values"]) for record in records}) == 9


def test_a_search_ends_with_the_generation_that_is_good_enough(tmp_path):
    whole = run_search(replace(BOWL, generation=8), tmp_path / "a", jobs=0)
    costs = [record["cost"] for record in whole.records]
    enough = min(costs[8:16])
    first = next(k for k, cost in enumerate(costs) if cost <= enough)
    problem = replace(BOWL, generation=8, enough=enough)
    ended = run_search(problem, tmp_path / "b", jobs=0)
    assert len(ended.records) == 8 * (first // 8 + 1) < len(costs)
    again = run_search(problem, tmp_path / "b", jobs=0)
    assert (
        lasting(again.records)
        == lasting(ended.records)
        == lasting(whole.records[: len(again.records)])
    )


def test_a_search_goes_on_around_its_start_where_a_spread_is_given(tmp_path):
    start = {"x": -0.6, "y": 3.0}
    problem = replace(BOWL, evaluations=12, generation=6, start=start, spread=0.05)
    first, *others = run_search(problem, tmp_path, jobs=0).records
    assert first["values"] == start and len(others) == 11
    away = [abs(r["values"]["x"] + 0.6) / 2 + abs(r["values"]["y"] - 3.0) / 10 for r in others]
    assert max(away) < 0.5 and np.median(away) < 0.15
    for wrong in ({"start": {}}, {"start": {"x": 0.0}}, {"start": [start] * 2}, {"sampler": "tpe"}):
        with pytest.raises(ValueError, match="spread"):
            replace(problem, **wrong)


def test_the_study_is_left_for_optunas_own_tools(tmp_path):
    import optuna
    from optuna.storages import JournalStorage
    from optuna.storages.journal import JournalFileBackend

    result = run_search(BOWL, tmp_path, jobs=0)
    run_search(BOWL, tmp_path, jobs=0)  # writes it anew
    storage = JournalStorage(JournalFileBackend(str(tmp_path / "study.log")))
    study = optuna.load_study(study_name="bowl", storage=storage)
    assert [trial.value for trial in study.trials] == [r["cost"] for r in result.records]
    assert study.best_params == result.values


def test_the_least_cost_never_rises_on_its_course(tmp_path):
    result = run_search(BOWL, tmp_path, jobs=0)
    course = result.least_costs()
    assert course == sorted(course, reverse=True)
    assert course[-1] == result.best["cost"]
