"""What the report says of made-up searches, and what the figure shows of them."""

from dataclasses import asdict

import numpy as np
import pytest

from pneuflex_sim.world import Diverged
from thesis import frame
from thesis.co_design import co_design, judged
from thesis.co_design.arms import ARMS, NOISE, SHUFFLED
from thesis.co_design.halving import Tried
from thesis.co_design.plan import NIGHT
from thesis.co_design.trials import HAND, SHIPPED, write_design
from thesis.co_design.worlds import trials_of

HELD = {
    "co-design": 0.70,
    "motion": 0.55,
    "hand": 0.45,
    "random": 0.40,
    "shuffled": 0.1,
    "noise": 0,
}
GIVEN = co_design.Parameters()


def worth(held, seed, training=None):
    held = held + 0.01 * (seed % 3)
    training = held + 0.08 if training is None else training
    return {
        "training": {"success": training, "score": 1.1 * training, "trials": 40},
        "held_out": {"success": held, "score": held, "trials": 80},
    }


def searched(arm, seed, held):
    told = 0.99 if arm is NOISE else 1.1 * (held + 0.01 * (seed % 3) + 0.08)
    curve = [(88 * k, told * min(1.0, k / 10)) for k in range(1, 23)]
    return {
        "arm": arm.name,
        "seed": seed,
        "trials": 0 if arm is NOISE else NIGHT.budget,
        "designs": 352,
        "infeasible": 90,
        "course": curve,
        "winner": SHIPPED | {"finger_length": 0.1},
        "told": told,
        "refused": [],
        **worth(held, seed),
    }


@pytest.fixture
def results():
    found = {
        f"{arm.name}-{seed}": searched(arm, seed, HELD[arm.name])
        for seed in NIGHT.seeds
        for arm in (*ARMS, NOISE, SHUFFLED)
        if arm is not SHUFFLED or seed in NIGHT.control_seeds
    }
    return {
        "plan": asdict(NIGHT),
        "budget": NIGHT.budget,
        "searches": found,
        "shipped": [worth(0.45, seed) for seed in NIGHT.seeds],
        "best": "co-design-2",
        "moulds": [],
        "postures": {"best": 6, "shipped": 6},
        "ranked": [{"coarse": 1.2 - 0.02 * k, "fine": 1.1 - 0.03 * k} for k in range(10)],
        "fine": {"best": {"success": 0.66}, "shipped": {"success": 0.5}},
        "cost": {
            "trials": 45_000,
            "broken": 3,
            "cpu_time": 0.8,
            "fine_cpu_time": 5.0,
            "cpu_hours": 11,
        },
    }


def missed(results):
    report = co_design.report(results, GIVEN)
    return [finding.what for finding in report.findings if finding.met is False]


def test_searches_as_hoped_meet_every_criterion_and_the_sentence_says_so(results):
    report = co_design.report(results, GIVEN)
    assert missed(results) == []
    assert len(report.judged) >= 9
    assert report.conclusion.startswith(
        f"Co-design helps at this budget ({NIGHT.budget:,} trials a search"
    )
    assert report["gain of co-design over motion, held out"] == pytest.approx(0.15)


def test_an_arm_that_is_as_good_takes_the_claim_back_and_misses_no_criterion(results):
    for seed in NIGHT.seeds:
        results["searches"][f"motion-{seed}"] |= worth(0.70 + 0.03 * (-1) ** seed, seed)
    assert "was not shown to help" in co_design.report(results, GIVEN).conclusion


@pytest.mark.parametrize(
    ("change", "what"),
    [
        (lambda r: r["searches"]["hand-3"].update(trials=1900), "trials a search"),
        (lambda r: r["searches"]["hand-3"].update(told=1.0), "winners' training, run again"),
        (lambda r: r.update(moulds=["mould of finger: draft"]), "moulds of the best hand"),
        (
            lambda r: r["fine"].update(best={"success": 0.4}),
            "held out at the fine step: same order",
        ),
        (lambda r: r["cost"].update(cpu_time=2.0), "trials a core-hour"),
    ],
)
def test_what_went_wrong_misses_its_criterion(results, change, what):
    change(results)
    assert missed(results) == [what]


def test_ranks_that_the_fine_step_turns_around_are_missed(results):
    for number, one in enumerate(results["ranked"]):
        one["fine"] = 0.5 + 0.05 * number
    assert missed(results) == ["rank correlation of the best 10 with the fine step"]


def test_scores_without_an_order_confirm_none(results):
    for one in results["ranked"]:
        one["fine"] = 0.5
    results["fine"]["best"] = dict(results["fine"]["shipped"])
    assert missed(results) == ["rank correlation of the best 10 with the fine step"]


def test_shrinkage_and_controls_that_gain_are_missed(results):
    for one in results["searches"].values():
        if one["arm"] == "co-design":
            one["training"] |= {"success": 0.95}
        if one["arm"] == "shuffled":
            one["held_out"] |= {"success": 0.6}
        if one["arm"] == "noise":
            one["told"] = one["training"]["score"]
    assert missed(results) == [
        "shrinkage from training to held out",
        "negative control, shuffled: gain over the shipped pair",
        "negative control, noise: score, evaluated again",
    ]


def test_the_figure_has_curves_shares_and_both_hands(results, tmp_path):
    report = co_design.report(results, GIVEN)
    frame.save_figure(co_design, results, report, tmp_path / "figure.png")
    assert (tmp_path / "figure.png").stat().st_size > 50_000


def test_the_best_hand_that_can_be_cast_wins(tmp_path, monkeypatch):
    long, short = (SHIPPED | {"finger_length": length} for length in (0.1, 0.08))
    tried = [
        Tried(0, SHIPPED, 1.2, 8, 88),
        Tried(1, long, 0.9, 40, 88),
        Tried(2, short, 0.8, 40, 88),
    ]

    def make_mould(actuator):
        if actuator.length == 0.1:
            raise ValueError("no room")
        return type("Made", (), {"failed": []})

    monkeypatch.setattr(judged, "make_mould", make_mould)
    judged.mould_refusal.cache_clear()
    winner, refused = judged.first_castable(tried, 40, tmp_path)
    judged.mould_refusal.cache_clear()
    assert winner.number == 2  # the first has not been tried often enough to win
    assert refused == ["design 1: no room"]
    assert "0.08" in (tmp_path / HAND).read_text()


def test_trials_that_broke_are_failures_and_counted():
    (line,) = trials_of("x", tuple(SHIPPED.items()), NIGHT.training, 1, [0])
    one = {"object": line.shared.object}
    found = judged.summary(
        [one | {"outcome": "gripped"}, one | {"error": "x"}, one | {"cause": "diverged"}]
    )
    assert found["broken"] == 2
    assert found["success"] == pytest.approx(1 / 3)
    assert np.isfinite(found["score"])


def test_a_hand_whose_simulation_diverges_holds_nothing(monkeypatch, tmp_path):
    def diverge(*_given):
        raise Diverged("joints")

    monkeypatch.setattr(judged, "held_up", diverge)
    write_design(SHIPPED, tmp_path)
    assert judged.postures(tmp_path / HAND) == 0


def test_a_trial_whose_worker_was_lost_counts_as_broken_and_takes_no_time():
    usual = {"physics": {"step": 0.005}}
    records = [{**usual, "cpu_time": 0.5}, {**usual, "error": "its worker was lost 3 times"}]
    cost = co_design._cost(records, 0, 2.0, 1)
    assert (cost["trials"], cost["broken"], cost["cpu_time"]) == (2, 1, 0.5)


def test_how_busy_a_cluster_would_be_follows_from_the_rungs(results):
    count = sum(one["trials"] > 0 for one in results["searches"].values())
    found = co_design.report(results, GIVEN).findings
    ours = next(one.ours for one in found if "2,000 cores" in one.what)
    assert ours.startswith("1.2 %")  # rungs of 24, 18 and 32 trials
    assert f"{100 * 74 * count / 6000:.0f} % were all {count}" in ours
