"""Successive halving: equal budgets of trials, no place twice, and it goes on where it stopped."""

import json

import pytest

from grasp_strategies.search import SearchProblem, Variable
from grasp_strategies.search.codesign.halving import Halving, best_of, search_by_halving
from grasp_strategies.search.codesign.success import cost_of, draw, modulus_of
from grasp_strategies.sweep.run import workers

HALVING = Halving(rungs=(2, 6, 12), one_in=2, budget=300)
OBJECTS = ["ball", "tube"]


def problem(name="both", seed=1, sampler="tpe"):
    return SearchProblem(
        name,
        "search_objectives:coins",
        (Variable("x", -1.0, 1.0), Variable("y", -1.0, 1.0)),
        evaluations=1000,
        sampler=sampler,
        seed=seed,
        settings={"objects": OBJECTS},
        allow_any=True,
    )


def search(folder, **changes):
    with workers(0) as crew:
        return search_by_halving(crew, problem(**changes), HALVING, folder)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("halving")
    return folder, search(folder)


def test_the_best_half_of_a_generation_goes_on_to_more_places(found):
    generation = found[1][:8]
    feasible = [one for one in generation if not one.infeasible]
    places = sorted(one.trials // len(OBJECTS) for one in feasible)
    assert places == [2] * (len(feasible) - 4) + [6, 6, 12, 12]
    ranked = sorted(feasible, key=lambda one: cost_of({k: v[:2] for k, v in one.successes.items()}))
    at_least = {one.number for one in feasible if one.trials > 2 * len(OBJECTS)}
    assert at_least == {one.number for one in ranked[:4]}


def test_no_place_is_run_twice_and_the_budget_counts_trials(found):
    folder, tried = found
    lines = [json.loads(line) for line in (folder / "results.jsonl").read_text().splitlines()]
    run = [
        (line["key"].split("/")[1], name, place)
        for line in lines
        for name in line.get("successes", {})
        for place in range(*line["settings"]["places"])
    ]
    assert len(set(run)) == len(run) == sum(one.trials for one in tried)
    assert HALVING.budget <= len(run) < HALVING.budget + 8 * 2 * 12


def test_the_best_is_one_that_was_tried_at_all_places(found):
    best = best_of(found[1])
    assert best.trials == 12 * len(OBJECTS)
    assert best.cost < -0.8


def test_what_cannot_be_built_costs_no_trials_and_says_why(found):
    infeasible = [one for one in found[1] if one.infeasible]
    assert infeasible
    assert {one.infeasible for one in infeasible} == {"too far"}
    assert {one.trials for one in infeasible} == {0}
    assert min(one.cost for one in infeasible) > max(one.cost for one in found[1] if one.trials)


def test_a_search_that_was_cut_off_comes_to_the_same_end(found, tmp_path):
    folder, tried = found
    lines = (folder / "results.jsonl").read_text().splitlines(keepends=True)
    (tmp_path / "results.jsonl").write_text("".join(lines[:11]) + lines[11][:30])
    assert search(tmp_path) == tried
    again = (tmp_path / "results.jsonl").read_text().splitlines(keepends=True)
    assert [line.split('"digest"')[0] for line in again] == [
        line.split('"digest"')[0] for line in lines
    ]


def test_rungs_that_do_not_rise_are_refused():
    for rungs, one_in in (((8, 2), 4), ((), 4), ((2, 8), 1)):
        with pytest.raises(ValueError, match="halving: expected rising rungs"):
            Halving(rungs, one_in)


def test_first_places_of_a_longer_run_are_those_of_a_shorter_one():
    settings = {"mass": [0.5, 2.0]}
    assert draw(1, "ball", 3, settings) == draw(1, "ball", 3, settings)
    drawn = {
        draw(seed, name, place, settings) for seed in (1, 2) for name in OBJECTS for place in (0, 1)
    }
    assert len(drawn) == 8
    assert modulus_of(1, "ball", {}) == modulus_of(1, "ball", {}) != modulus_of(2, "ball", {})
    assert all(0.5 <= one.mass_scale <= 2.0 for one in drawn)
