"""The calibration of confidences, on verdicts whose chance of being right is known."""

import json

import numpy as np
import pytest

from bench.hidden.reserved import is_reserved
from bench.lab import calibrate, gather
from bench.lab.calibrate import TERMS, fitted, limit_of, shown
from bench.lab.scoring import SECOND_AUTHOR, right
from model_lab.diagnosis.confidence import probability


def gathered(count, first, verdict="effects_missing", steepness=8.0):
    """Sets of which the share right falls with what is left, from 1 to nearly 0."""
    random = np.random.default_rng(first)
    made = []
    for number in range(count):
        left = float(random.uniform())
        fine = random.random() < 1.0 / (1.0 + np.exp(steepness * (left - 0.6)))
        evidence = dict.fromkeys({name for terms in TERMS.values() for name in terms}, 0.0)
        made.append({
            "key": f"{verdict}{first}{number}", "row": "catalogue", "seed": first,
            "experiment": "uniaxial",
            "expected": {"verdict": verdict, "names": [["a"]], "tied": []}, "revision": "r",
            "answer": {"verdict": verdict, "effects": [{"name": "a" if fine else "b"}],
                       "tied": [[]], "evidence": evidence | {"left": left}},
        })  # fmt: skip
    return made


@pytest.fixture(scope="module")
def found():
    return fitted(gathered(300, 600))


def test_the_model_finds_how_the_share_of_right_verdicts_depends_on_the_evidence(found):
    model = found["verdicts"]["effects_missing"]
    for left in (0.2, 0.6, 0.9):
        said = probability(model, dict.fromkeys(TERMS["effects_missing"], 0.0) | {"left": left})
        assert said == pytest.approx(1.0 / (1.0 + np.exp(8.0 * (left - 0.6))), abs=0.12)


def test_more_error_left_never_makes_a_verdict_surer():
    """Also where by chance the verdicts with the larger error were the right ones."""
    records = gathered(300, 603)
    for one in records:
        one["answer"]["evidence"]["after"] = 1.0 - one["answer"]["evidence"]["left"]
        one["answer"]["evidence"]["left"] = 0.0
    model = fitted(records)["verdicts"]["effects_missing"]
    assert model["terms"]["after"]["weight"] == 0.0
    free = calibrate.model_of(records, dict.fromkeys(TERMS["effects_missing"], 0), 0.3)
    assert free["terms"]["after"]["weight"] > 1.0  # which the data alone would give


def test_what_is_stated_holds_on_other_sets(found):
    proof = shown(gathered(300, 601), found)
    assert proof["error"] < 2.0 * proof["by_chance"] + 0.02
    assert proof["interval"][0] <= proof["error"] <= proof["interval"][1]
    assert sum(each["count"] for each in proof["bins"]) == 300
    refused, wrong = proof["refused_of_wrong"]
    assert refused / wrong > 0.7


def test_sets_of_the_second_author_count_as_they_were_judged(found):
    records = gathered(40, 605)
    for number, one in enumerate(records):
        del one["expected"]
        one |= {"row": f"{SECOND_AUTHOR}, slips", "right": number < 30}
    assert fitted(records)["verdicts"]["effects_missing"]["right"] == 30
    assert shown(records, found)["right"] == 30


def test_a_slip_that_is_told_where_none_is_counts_as_wrong(found):
    records = gathered(40, 606)
    fine = sum(map(right, records))
    told = next(one["answer"] for one in records if right(one))
    told |= {"verdict": "slip", "verdict_mended": "effects_missing"}
    assert fitted(records)["verdicts"]["effects_missing"]["sets"] == 40
    assert shown(records, found)["right"] == fine - 1


def test_no_more_is_stated_than_so_many_sets_can_show(found):
    certain = gathered(30, 602)
    for one in certain:
        one["answer"]["effects"] = [{"name": "a"}]
    model = fitted(certain)["verdicts"]["effects_missing"]
    assert probability(model, certain[0]["answer"]["evidence"]) <= 31 / 32 + 1e-4


def test_a_verdict_that_was_never_gathered_is_even_chance(found):
    evidence = dict.fromkeys(TERMS["adequate"], 0.0)
    assert probability(found["verdicts"]["adequate"], evidence) == 0.5


@pytest.mark.parametrize(("steepness", "enough"), [(8.0, False), (80.0, True)])
def test_the_limit_refuses_most_of_the_wrong_verdicts_unless_too_many_right_ones(steepness, enough):
    sets = gathered(200, 603, steepness=steepness)
    said = np.array([1.0 - 0.5 * one["answer"]["evidence"]["left"] for one in sets])
    fine = np.array([right(one) for one in sets])
    limit = limit_of(sets, said)
    assert (np.mean(said[~fine] < limit) >= calibrate.REFUSED) == enough
    assert np.mean(said[fine] < limit) <= calibrate.GUESSED
    assert enough or np.mean(said[fine] < limit + 0.05) > calibrate.GUESSED


def test_what_was_a_guess_by_the_coefficients_of_then_is_not_refused_by_new_ones(found):
    others = gathered(100, 609)
    before = shown(others, found)
    for one in others:
        one["answer"]["guess"] = True
    said = np.zeros(len(others)) + 0.99
    assert shown(others, found) == before
    assert before["refused_of_wrong"][1] > 0 and limit_of(others, said) == limit_of(
        gathered(100, 609), said
    )


def test_coefficients_and_figure_are_written_with_where_they_come_from(tmp_path, monkeypatch):
    monkeypatch.setattr(calibrate, "OUT", tmp_path / "confidence.json")
    monkeypatch.setattr(calibrate, "FIGURE", tmp_path / "confidence.png")
    lines = tmp_path / "lines.jsonl"
    sets = gathered(40, 603) + gathered(40, 604)
    lines.write_text("".join(json.dumps(one) + "\n" for one in sets))
    assert calibrate.main(["--lines", str(lines)]) == 0
    written = json.loads((tmp_path / "confidence.json").read_text())
    fitted_to, others = written["fitted_to"]["sets"], written["shown_on"]["sets"]
    assert fitted_to + others == 80 and 10 < others < 36
    assert written["fitted_to"]["rows"] == {"catalogue": fitted_to}
    assert written["revisions"] == {"r": 80}
    assert (tmp_path / "confidence.png").stat().st_size > 5000


def test_fit_and_proof_get_sets_of_every_case_that_no_threshold_has_seen():
    jobs = gather.jobs("r")
    halves = [
        {job.case for job in jobs if calibrate.for_the_fit(gather.name_of(job)) == fit}
        for fit in (True, False)
    ]
    assert len(halves[0] & halves[1]) > 300 and len(halves[0] ^ halves[1]) < 10
    assert min(job.seed for job in jobs) >= gather.FIRST_SEED
    assert max(job.seed for job in jobs) < 1000
    assert not any(is_reserved(job.case) for job in jobs)
    first = jobs[: len(halves[0] | halves[1])]
    assert len({gather.name_of(job) for job in first}) == len(first)


def test_sets_of_the_blind_bench_are_taken_without_what_is_kept_for_it(tmp_path):
    own, blind = tmp_path / "own.jsonl", tmp_path / "blind.jsonl"
    sets = gathered(5, 607)
    sets[1]["case"], sets[2]["row"], sets[3]["answer"] = "reserved/uniaxial/x/5", "plan", None
    own.write_text(json.dumps(sets[0]) + "\n")
    blind.write_text("".join(json.dumps(one) + "\n" for one in sets[1:]))
    kept = calibrate.answered([own, blind])
    assert {one["key"] for one in kept} == {sets[0]["key"], sets[4]["key"]}


def test_coefficients_are_compared_on_the_same_sets(found):
    others = gathered(200, 608)
    never = {**found, "limit": 1.0}  # all verdicts are guesses
    sure = {**found, "limit": 0.0}
    wrong = sum(not right(one) for one in others)
    assert f"wrong and sure 0 of 200, right ones called a guess {200 - wrong}" in (
        calibrate.compared(others, never)
    )
    assert f"wrong and sure {wrong} of 200, right ones called a guess 0" in (
        calibrate.compared(others, sure)
    )
    unknown = fitted([])  # even chance for each
    lower, low, high = calibrate.gain(others, found, unknown)
    assert 0.05 < low < lower < high < 0.25
    assert calibrate.gain(others, unknown, found)[0] == -lower
    assert calibrate.compared(others, unknown).startswith("Brier score 0.2500")
    assert float(calibrate.compared(others, found).split()[2].rstrip(",")) < 0.2


def test_measurements_of_which_the_worst_fits_are_the_surest_are_told(found):
    real = [one | {"row": "real"} for one in gathered(30, 606)]
    for one in real:
        one["answer"]["evidence"]["after"] = one["answer"]["evidence"]["left"]
    assert calibrate.rank_of_measurements(real, found) == [pytest.approx(-1.0, abs=0.05), 30]
    for one in real:
        one["answer"]["evidence"]["after"] *= -1.0
    assert calibrate.rank_of_measurements(real, found) == [pytest.approx(1.0, abs=0.05), 30]


def test_what_is_shipped_says_where_it_comes_from():
    shipped = json.loads(calibrate.OUT.read_text())
    assert shipped["format"] == calibrate.FORMAT and set(shipped["verdicts"]) == set(TERMS)
    rows = shipped["fitted_to"]["rows"]
    assert sum(rows.values()) == shipped["fitted_to"]["sets"]
    for author in ("catalogue", "second author, forms", "second author, slips", "real"):
        assert rows[author]
    for verdict, terms in TERMS.items():
        assert 0.0 < probability(shipped["verdicts"][verdict], dict.fromkeys(terms, 0.0)) < 1.0


def test_coefficients_are_shown_on_sets_of_another_file_and_fitted_to_all_of_the_first(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(calibrate, "OUT", tmp_path / "confidence.json")
    monkeypatch.setattr(calibrate, "FIGURE", tmp_path / "confidence.png")
    files = [tmp_path / "fit.jsonl", tmp_path / "on.jsonl"]
    for number, (path, count) in enumerate(zip(files, (40, 30), strict=True)):
        sets = gathered(count, 610 + number)
        path.write_text("".join(json.dumps(one) + "\n" for one in sets))
    assert calibrate.main(["--lines", str(files[0]), "--on", str(files[1])]) == 0
    written = json.loads((tmp_path / "confidence.json").read_text())
    assert (written["fitted_to"]["sets"], written["shown_on"]["sets"]) == (40, 30)
