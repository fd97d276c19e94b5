"""What a verdict rests on, and how sure it is."""

import math

import pytest

from bench.hidden import make_set
from model_lab.diagnosis import confidence
from model_lab.diagnosis.confidence import Confidence, calibration, confidence_of, probability
from model_lab.diagnosis.diagnose import diagnose_folder


@pytest.fixture(scope="module")
def answers(tmp_path_factory):
    """Diagnoses of strips: one with stiff chains, the same with nothing hidden."""
    made = {}
    for hidden in ("gent_stiffening", None):
        folder = tmp_path_factory.mktemp("set")
        laws, more = ([(hidden, {})], {"ratio": 6.0}) if hidden else ([], {})
        make_set(folder, "uniaxial", laws, seed=11, samples=60, **more)
        made[hidden] = diagnose_folder(folder)
    return made


def test_a_diagnosis_says_how_sure_it_is_and_what_that_follows_from(answers):
    for answer in answers.values():
        sure = confidence_of("uniaxial", answer["verdict"], answer["evidence"])
        assert (answer["confidence"], answer["guess"]) == (sure.value, sure.guess)
        assert sure.value is None or 0.0 < sure.value < 1.0
        assert all(math.isfinite(value) for value in answer["evidence"].values())


def test_every_number_that_confidence_needs_is_in_the_evidence(answers):
    known = set(answers[None]["evidence"])
    for model in calibration()["verdicts"].values():
        assert set(model["terms"]) <= known


def test_evidence_tells_an_explained_error_from_none(answers):
    named, nothing = answers["gent_stiffening"]["evidence"], answers[None]["evidence"]
    assert named["effects"] == 1 and nothing["effects"] == 0
    assert named["before"] > 1.0 > named["after"] and named["left"] < 0.2
    assert nothing["before"] == nothing["after"] and nothing["left"] == 1.0
    assert named["proof"] > 0.0 > nothing["proof"]
    assert named["folds_helped"] > 0.8 and named["known"] > 1.0
    assert named["margin"] <= 1.0 and named["lead"] > 0.0


def test_below_the_limit_a_verdict_is_a_guess_and_of_too_few_sets_nothing_is_said(monkeypatch):
    term = {"mean": 0.0, "scale": 1.0, "weight": -2.0, "low": -1.0, "high": 1.0}
    model = {"intercept": 1.0, "most": 0.95, "terms": {"left": term}, "sets": 200}
    verdicts = {"effects_missing": model, "adequate": model | {"sets": 9}}
    shipped = {"limit": 0.8, "verdicts": verdicts, "experiments": {"uniaxial": 200}}
    monkeypatch.setattr(confidence, "calibration", lambda: shipped)
    sure, unsure = (
        confidence_of("uniaxial", "effects_missing", {"left": left}) for left in (-1.0, 1.0)
    )
    assert confidence_of("blocked_tip", "effects_missing", {"left": 0.0}) == Confidence(None)
    assert confidence_of("uniaxial", "adequate", {"left": 0.0}) == Confidence(None)
    assert not sure.guess and sure.value == 0.95
    assert unsure.guess and unsure.value == pytest.approx(1 / (1 + math.e), abs=1e-3)


def test_what_is_not_known_is_a_guess_where_the_calibration_stays_on_a_bound(monkeypatch):
    term = {"mean": 0.0, "scale": 1.0, "weight": 2.0, "low": -1.0, "high": 1.0}
    verdicts = {"slip": {"intercept": 5.0, "most": 0.95, "terms": {"left": term}, "sets": 200}}
    shipped = {"limit": 0.8, "verdicts": verdicts, "experiments": {"uniaxial": 200}}
    monkeypatch.setattr(confidence, "calibration", lambda: shipped)

    def verdict(left, at_bound):
        return confidence_of("uniaxial", "slip", {"left": left}, at_bound=at_bound)

    assert verdict(9.0, at_bound=True) == Confidence(None, True, ("left",))
    assert verdict(9.0, at_bound=False) == Confidence(None, False, ("left",))
    assert verdict(0.5, at_bound=True) == Confidence(0.95, False)


def test_nothing_is_extrapolated_beyond_what_was_seen():
    term = {"mean": 0.0, "scale": 1.0, "weight": 3.0, "low": -0.2, "high": 0.2}
    model = {"intercept": 0.0, "most": 0.999, "terms": {"left": term}}
    assert probability(model, {"left": 9.0}) == probability(model, {"left": 0.2})
