"""Hands of soft and stiff rubber that close alike hard, and what is said of them."""

from dataclasses import asdict

import numpy as np
import pytest

from pneuflex_sim.simulation import Simulation, SimulationConfig
from thesis import frame
from thesis.chapter_3_and_5.stand import fill
from thesis.chapter_8 import shape_adaptability as experiment
from thesis.chapter_8.closing_hand import LOST_WAY, ClosingHand, Draw, Held, stiffened
from thesis.chapter_8.shape_adaptability import CLOSINGS, SAME, SOFT, STIFF

NO_DRAW = Draw(np.zeros(3), np.zeros(3), 1.0, 1.0)
BOOTSTRAPS = experiment.BOOTSTRAPS


@pytest.fixture(autouse=True)
def few_bootstraps(monkeypatch):
    """Enough for two or three objects."""
    monkeypatch.setattr(experiment, "BOOTSTRAPS", 1_000)


def test_the_small_run_gives_finite_figures_a_verdict_and_a_picture(check_small_run):
    check_small_run("shape_adaptability")


# ---------------------------------------------------------------- the hands
def test_a_stiff_hand_with_as_much_more_pressure_bends_as_the_soft_one_does():
    """Free and without weight, the bend is a function of pressure over modulus (eq. 3.21)."""
    bends = []
    for factor in (1.0, 20.0):
        hand = stiffened("rbo_hand_2", factor)
        simulation = Simulation(SimulationConfig(hand=hand, modulus_scale=factor, scene="stand"))
        fill(simulation, factor * np.array(CLOSINGS["rbo_hand_2"].pressures))
        bends.append(
            simulation.air.rest_bend(
                0.001,
                factor * np.array([60e3, 60e3, 60e3, 90e3]),
                simulation.bodies.rotations,
                293.0,
            )
        )
        simulation.close()
    assert np.abs(bends[0]).max() > 0.1
    assert bends[1] == pytest.approx(bends[0], abs=1e-3)


def test_a_stiff_hand_presses_as_asked_and_yields_less(small):
    results, report = small("shape_adaptability")
    for trial in results["trials"]:
        soft, same, stiff = (trial["arms"][arm] for arm in (SOFT, SAME, STIFF))
        assert same["force"] == pytest.approx(soft["force"], rel=0.1)
        assert stiff["force"] == pytest.approx(soft["force"], rel=0.1)
        assert stiff["yielding"] < 0.3 * soft["yielding"]
        assert soft["air"] == 1.0 and stiff["air"] < 1.0
    assert len(report.judged) == 3


def test_a_hand_without_air_lets_the_object_fall():
    closing = CLOSINGS["rbo_hand_2"]
    empty = type(closing)(closing.hand, closing.model, (0.0,) * 4, closing.place)
    hand = ClosingHand(empty, "cylinder", NO_DRAW, 1.0, 5)
    held = hand.hold()
    hand.close()
    assert held.lost and held.way > LOST_WAY


# ---------------------------------------------------------------- the verdict
def held(links, way=0.0):
    contacts = {"points": links, "links": links, "parts": 3, "area": 1e-4 * links}
    return asdict(Held(10.0, 1.0, 0.1, way, **contacts, redundancy=3 * links, margin=0.1))


def trial(name, soft, same, stiff):
    arms = dict(zip((SOFT, SAME, STIFF), (soft, same, stiff), strict=True))
    return {"hand": "rbo_hand_2", "object": name, "arms": arms}


def judged(*trials):
    given = experiment.Parameters(hands=("rbo_hand_2",))
    report = experiment.report({"trials": list(trials)}, given)
    return {row.what.partition(": ")[2]: row for row in report.findings}


def test_more_links_on_every_object_show_the_claim_and_as_many_do_not():
    more = judged(trial("cup", held(9), held(9), held(4)), trial("tube", held(8), held(8), held(5)))
    assert more["links that touch"].met and more["redundancy of the forces"].met
    assert "8.5 against 4.5: +4.0 (+3.0 to +5.0), 2 pairs" in more["links that touch"].ours
    mixed = judged(
        trial("cup", held(9), held(9), held(4)), trial("tube", held(4), held(4), held(9))
    )
    assert not mixed["links that touch"].met


def test_the_control_fails_where_closing_by_force_alone_takes_contacts_away():
    found = judged(
        trial("cup", held(9), held(6), held(4)), trial("tube", held(8), held(6), held(5))
    )
    (control,) = (row for what, row in found.items() if what.startswith("negative control"))
    assert control.met is False and "+2.5" in control.ours


def test_what_is_lost_has_no_links_and_what_diverged_is_no_pair():
    lost, diverged = held(7, way=2 * LOST_WAY), {"error": "the simulation diverged"}
    found = judged(trial("cup", held(9), held(9), lost), trial("tube", held(5), held(5), diverged))
    assert "9.0 against 0.0: +9.0 (+9.0 to +9.0), 1 pairs" in found["links that touch"].ours
    assert found["links, pairs in which both hold the object"].ours == "-, 0 pairs"


def test_a_run_goes_on_where_it_was_and_keeps_the_hands_that_are_there(tmp_path, monkeypatch):
    done = []

    def made_up(trial):
        done.append(trial.key)
        return {arm: held(5) for arm in (SOFT, SAME, STIFF)}

    monkeypatch.setattr(experiment, "compared", made_up)
    job = frame.Job(tmp_path, lambda what, share: None)
    few = {"objects": ("cylinder", "tube"), "trials": 2, "jobs": 0}
    first = experiment.Parameters(hands=("rbo_hand_1",), **few)
    experiment.run(first, job)
    both = experiment.Parameters(hands=("rbo_hand_2",), **few).continued(tmp_path)
    assert set(both.hands) == {"rbo_hand_1", "rbo_hand_2"}
    results = experiment.run(both, job)
    assert len(done) == len(set(done)) == len(results["trials"]) == 8


def test_the_interval_draws_objects_and_their_trials(monkeypatch):
    """Against the standard error of a mean of objects that each have one trial."""
    monkeypatch.setattr(experiment, "BOOTSTRAPS", BOOTSTRAPS)
    rng = np.random.default_rng(3)
    values = rng.normal(2.0, 1.0, 40)
    mean, low, high = experiment.interval({str(k): np.array([v]) for k, v in enumerate(values)})
    error = values.std() / np.sqrt(len(values))
    assert mean == pytest.approx(values.mean())
    assert (mean - low, high - mean) == pytest.approx((1.96 * error, 1.96 * error), rel=0.08)


def test_a_sheet_is_refused_by_name():
    with pytest.raises(ValueError, match="objects: expected some of cylinder.*got tissue"):
        experiment.Parameters(objects=("tissue",))
