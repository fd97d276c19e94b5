"""The best evaluations are tried again with jitter, and what can be repeated wins."""

import pytest

from softhand_trials.search import SearchProblem, Tried, Variable, search_with, try_again
from softhand_trials.sweep.run import start_workers

LEDGE = SearchProblem(  # the cost falls towards x = 1, beyond which it is high
    "ledge",
    "search_objectives:ledge",
    (Variable("x", 0.0, 2.0),),
    evaluations=100,
    sampler="random",
    seed=1,
    allow_any=True,
)


def test_what_can_be_repeated_wins_over_what_was_best_once(tmp_path):
    draws = {"left": (-100,), "right": (100,)}  # thousandths that x is moved by
    with start_workers(0) as workers:
        result = search_with(workers, LEDGE, tmp_path)
        tried = try_again(workers, LEDGE, result, draws, (10, 10), tmp_path / "again")
        taken_up = try_again(workers, LEDGE, result, draws, (10, 10), tmp_path / "again")
    assert result.values["x"] > 0.9  # too near to the ledge
    best = tried[0]
    assert 0.7 < best.record["values"]["x"] < 0.9
    assert best.worst == pytest.approx(1.0 - best.record["values"]["x"] + 0.1)
    assert [one.worst for one in tried] == sorted(one.worst for one in tried)
    assert taken_up == tried
    assert len((tmp_path / "again" / "results.jsonl").read_text().splitlines()) == 20


def test_only_the_best_go_into_the_next_round_and_each_is_of_another_generation(tmp_path):
    draws = {"right": (100,), "left": (-100,)}
    with start_workers(0) as workers:
        result = search_with(workers, LEDGE, tmp_path)
        tried = try_again(workers, LEDGE, result, draws, (10, 3), tmp_path / "again")
    assert [len(one.records) for one in tried] == [2] * 3 + [1] * 7
    first = [one.records[0]["cost"] for one in tried]
    assert max(first[:3]) <= min(first[3:])
    assert max(one.record["values"]["x"] for one in tried[:3]) < 0.9  # none near to the ledge
    generations = {int(one.record["key"].rpartition("/")[2]) // 8 for one in tried}
    assert len(generations) == 10


def test_of_the_tries_the_worst_counts():
    tried = Tried({"cost": 1.0}, [{"cost": 2.0}, {"cost": 70.0}])
    assert tried.worst == 70.0
    assert Tried({"cost": 1.0}, [{"cost": 2.0}, {"error": "diverged"}]).worst == 1e3
    assert Tried({"cost": 1.0}, []).worst == 1.0
