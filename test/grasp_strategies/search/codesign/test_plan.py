"""A plan of co-design: what it says, what it refuses, and its negative control end to end."""

import json

import pytest

from grasp_strategies.search.codesign.command import main
from grasp_strategies.search.codesign.plan import SHIPPED_PLAN, load_plan
from grasp_strategies.search.codesign.run import Winner, gain_of, verdict


def winner(arm, seed, held_out):
    return Winner(arm, seed, {}, held_out + 0.1, held_out, 10, 2, 0)


def test_the_shipped_plan_has_three_arms_and_random_with_equal_budgets():
    plan = load_plan()
    assert set(plan.arms) == {"motion", "hand", "both", "random"} and len(plan.seeds) == 5
    names = {arm: {one.name for one in found.variables} for arm, found in plan.arms.items()}
    assert (len(names["hand"]), len(names["motion"])) == (7, 11)
    assert names["both"] == names["random"] == names["hand"] | names["motion"]
    assert not set(plan.training["objects"]) & set(plan.held_out["objects"])
    assert plan.problem("hand", 3).settings == plan.training
    assert load_plan(small=True).halving.budget < plan.halving.budget


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("spaces: [hand]", "spaces: [foot]", "arms.hand.spaces[0]: expected one of hand, motion"),
        ("rungs: [2, 8, 40]", "rungs: [8, 2]", "halving: expected rising rungs"),
        ("sampler: random", "sampler: grid", "arms.random.sampler: expected one of cma, tpe"),
        ("places: 10", "places: 0", "held_out.places: expected a whole number from 1"),
    ],
)
def test_a_plan_that_cannot_be_run_is_refused_in_a_line(tmp_path, capsys, old, new, words):
    path = tmp_path / "plan.yaml"
    path.write_text(SHIPPED_PLAN.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    assert main([str(path), "--out", str(tmp_path / "out")]) == 2
    assert words in capsys.readouterr().err


def test_co_design_helps_only_where_the_interval_of_its_gain_leaves_nothing_out():
    single = [winner(arm, seed, 0.5) for arm in ("motion", "hand") for seed in (1, 2, 3)]
    clear = gain_of([*single, *(winner("both", seed, 0.6 + seed / 100) for seed in (1, 2, 3))])
    assert verdict(clear).startswith("co-design helps: +12.0 points over motion")
    wide = gain_of(
        [*single, *(winner("both", seed, held) for seed, held in enumerate((0.4, 0.6, 0.9), 1))]
    )
    assert verdict(wide).startswith("co-design was not shown to help at this budget: +13.3 points")
    assert verdict(gain_of(single)) == "co-design was not judged: an arm is missing"


@pytest.fixture
def trials_of_the_held_out(monkeypatch):
    """Held-out grasps by chance as well: no physics in this test."""
    monkeypatch.setattr(
        "grasp_strategies.search.codesign.success._tried",
        lambda name, strategy, settings: [""] * (settings["places"][1] - settings["places"][0]),
    )


def test_of_noise_an_arm_makes_no_gain_and_the_budgets_are_equal(
    tmp_path, capsys, trials_of_the_held_out
):
    words = ["--small", "--noise", "--jobs", "0", "--out", str(tmp_path)]
    assert main(words) == 0
    shown = capsys.readouterr().out
    assert "co-design was not shown to help at this budget: +0.0 points" in shown
    found = json.loads((tmp_path / "codesign.json").read_text())
    assert {one["held_out"] for one in found["winners"]} == {found["shipped"]} == {1.0}
    budget = found["budget"]
    assert all(budget <= one["trials"] < budget + 24 for one in found["winners"])
    assert main(words) == 0
    assert capsys.readouterr().out == shown
