"""The Feix experiment: what is said of made-up results, a person's verdict, and one small run."""

import csv
import shutil
from dataclasses import replace

import pytest

from softhand_trials.search import Tried
from softhand_trials.sweep.run import start_workers
from thesis.chapter_8 import feix
from thesis.chapter_8.dexterity import feix_search
from thesis.chapter_8.dexterity.feix_search import pattern_of, values_of
from thesis.chapter_8.dexterity.grasping import drawn
from thesis.chapter_8.dexterity.patterns import load_patterns
from thesis.chapter_8.feix import FOUR, UNTURNED, Parameters, problem, report
from thesis.chapter_8.feix_report import AGAIN, ALL, FINER, HALF, NOT_COUNTED, SLIPPERY
from thesis.chapter_8.feix_sheet import FILE, human_verdicts, write_verdicts
from thesis.frame import Job, save_figure


def trial(held=True, typed=True):
    reasons = {"held_reason": "" if held else "drifts by 30 mm", "typed_reason": ""}
    return {"key": "k", "held": held, "typed": typed, "robust": 3.0, "cpu_time": 2.0, **reasons}


def one(held=True, typed=True):
    return {"evaluations": 300, "cpu_time": 200.0, "trials": [trial(held, typed)] * 3}


def grasped(held=ALL, right=ALL):
    return {str(number): one(number in held, number in right) for number in ALL}


def checks(again=None, half=None, slippery=(), finer=()):
    found = grasped()
    return {
        AGAIN: {n: o["trials"][:1] for n, o in (again or found).items()},
        HALF: {n: o["trials"] for n, o in (half or found).items()},
        SLIPPERY: {n: [trial(int(n) in slippery)] for n in found},
        FINER: {n: [trial(int(n) in finer)] for n in found},
    }


def slow(found):
    for one_type in found.values():
        one_type["trials"] = [{**t, "cpu_time": 10.0} for t in one_type["trials"]]
    return found


def results(found=None, control=None, human=None, **other):
    cases = {FOUR: found or grasped(), UNTURNED: control or grasped(held=ALL[:20])}
    return {"cases": cases, "checks": checks(**other), "human": human or {}}


def row(found, what):
    return next(f for f in report(found, Parameters()).findings if f.what.startswith(what))


def test_a_hand_that_does_all_and_controls_that_fail_meet_all_criteria():
    told = report(results(), Parameters())
    assert told.judged == [True] * 8
    assert told.conclusion.startswith("32 of 32 types are held, 32 of them by the parts")


@pytest.mark.parametrize(
    ("given", "what"),
    [
        ({"found": grasped(held=ALL[:26])}, "held"),
        ({"found": grasped(right=ALL[:23])}, "held by the right parts"),
        ({"found": grasped(held=ALL[5:])}, "power grasps against the palm held"),
        ({"control": grasped(held=ALL[:26])}, "negative control: thumb unturned"),
        ({"again": grasped(held=ALL[1:])}, "run again from the file"),
        ({"again": slow(grasped())}, "time of that"),
        ({"half": grasped(held=ALL[4:])}, "shaken with half the strength"),
        ({"slippery": (1, 2, 3, 4)}, "negative control: no friction"),
    ],
)
def test_a_missed_criterion_is_said(given, what):
    assert row(results(**given), what).met is False


def test_verdicts_beside_the_one_that_counts_are_told_and_not_judged():
    found = grasped()
    for number in ("3", "14"):
        found[number]["trials"] = [{**trial(), "at_rest": True}] * 3
    beside = results(found=found, finer=(3, 4))
    more, rest = row(beside, "the same patterns"), row(beside, "held, by what is left")
    assert (more.ours, more.met) == ("2 held: 3, 4", None)
    beside["checks"] = {feix.STICKY: beside["checks"][FINER]}
    assert row(beside, "the same patterns with twice").ours == more.ours
    assert (rest.ours, rest.met) == ("2 of 32", None)


def test_scissors_do_not_count():
    but_scissors = tuple(number for number in ALL if number != NOT_COUNTED)
    assert row(results(found=grasped(held=but_scissors)), "held").ours == "32 of 32 (>= 27)"
    assert row(results(found=grasped(held=(*ALL[:23], 19))), "held").ours == "22 of 32 (>= 27)"


def test_a_type_counts_when_every_trial_is_good():
    found = grasped()
    found["7"]["trials"] = [trial(), trial(), trial(held=False)]
    assert row(results(found=found), "held").ours == "31 of 32 (>= 27)"
    assert row(results(found=found), "7 prismatic").ours == (
        "held 2 of 3; right 3 of 3; 3.0 N; drifts by 30 mm"
    )
    assert row(results(found=found), "5 light tool").thesis == "fails"


def test_a_trial_that_ended_in_an_error_is_not_good():
    found = grasped()
    found["7"]["trials"] = [{"key": "k", "error": "OSError: gone"}] * 3
    assert row(results(found=found), "held").ours == "31 of 32 (>= 27)"
    assert "OSError: gone" in row(results(found=found), "7 prismatic").ours


def test_criteria_are_not_judged_before_all_types_were_run():
    found = {number: one() for number in ("1", "2")}
    part = {"cases": {FOUR: found}, "checks": {}, "human": {}}
    assert report(part, Parameters(types=(1, 2), cases=(FOUR,))).judged == []


def test_what_a_person_says_stands_apart_and_is_kept(tmp_path):
    write_verdicts(tmp_path, grasped())
    told = row(results(human=human_verdicts(tmp_path)), "by a person")
    assert told.ours == "not judged" and told.met is None
    with (tmp_path / FILE).open(newline="") as file:
        rows = list(csv.DictReader(file))
    rows[0] |= {"human_good": "yes", "human_remark": "as in the picture"}
    rows[4] |= {"human_good": "no"}
    with (tmp_path / FILE).open("w", newline="") as file:
        table = csv.DictWriter(file, rows[0])
        table.writeheader()
        table.writerows(rows)
    write_verdicts(tmp_path, grasped(held=()))
    kept = human_verdicts(tmp_path)
    assert kept["1"] == {"human_good": "yes", "human_remark": "as in the picture"}
    assert row(results(human=kept), "by a person").ours == "1 of 2 good"
    assert "0/3" in (tmp_path / FILE).read_text()


def test_searches_have_the_budget_and_seeds_of_their_own():
    given = Parameters()
    first, other = problem(given, FOUR, 3), problem(given, FOUR, 4)
    assert (first.evaluations, first.sampler, first.generation) == (260, "cma", 10)
    assert given.evaluations + sum(given.tried) <= 300
    assert first.seed == 3003 != other.seed
    assert len(first.variables) == 8 + 1 + 3 + 2
    assert problem(given, UNTURNED, 3).settings["hand"] == UNTURNED
    assert {p.settings["step"] for p in (first, other)} == {feix._settings(given, FOUR, 3).step}


def test_a_search_around_a_known_grasp_begins_with_it_and_shakes_it_both_ways():
    known = load_patterns().grasps[3].pattern
    search = problem(Parameters(), FOUR, 3, known)
    begin = pattern_of(3, search.starts[0])
    assert begin.position == pytest.approx(known.position)
    assert search.spread == feix.SPREAD and search.evaluations == Parameters().around
    one, other = map(drawn, search.settings["draws"])
    assert one.shift == pytest.approx([-part for part in other.shift])


def tried(*costs, good=(True, True)):
    reasons = ["" if ok else "drifts by 12 mm" for ok in good]
    records = [
        {"cost": cost, "typed": "", "held_reason": reason, "dropped": False}
        for cost, reason in zip(costs, reasons, strict=True)
    ]
    return Tried({"cost": 1.0, "key": "k"}, records)


@pytest.mark.parametrize(
    ("found", "known", "which"),
    [
        (tried(9.0, 8.0), tried(9.0, 9.0), "found"),
        (tried(9.0, 9.0), tried(9.0, 8.0), "known"),
        (tried(12.0, 12.0), tried(1.0, 41.0, good=(True, False)), "found"),
        (tried(1.0, 41.0, good=(True, False)), tried(22.0, 24.0), "known"),
        (tried(41.0, 41.0, good=(False, False)), tried(50.0, 50.0, good=(False, False)), "known"),
        (Tried({"cost": 1.0}, [{"error": "diverged"}] * 2), tried(9.0, 9.0), "known"),
    ],
)
def test_a_known_grasp_stays_unless_another_is_better(found, known, which):
    assert feix.better(found, known) is {"found": found, "known": known}[which]


@pytest.mark.parametrize("toward", [1.0, -1.0])
def test_a_search_from_a_known_grasp_keeps_it_with_its_origin_or_finds_another(
    tmp_path, monkeypatch, toward
):
    """The cost rises or falls with the distance from the known grasp."""
    stored = load_patterns().grasps[9]
    begin = values_of(9, stored.pattern)

    def tried(values, settings, seed):
        away = sum(abs(values[name] - begin[name]) for name in "xyz")
        cost = 20.0 + toward * 100.0 * away
        return {"cost": cost, "typed": "", "held_reason": "", "dropped": False}

    monkeypatch.setattr(feix_search, "_tried", tried)
    given = replace(Parameters(**feix.SMALL), known=feix.SHIPPED, around=9)
    with start_workers(0) as workers:
        winner = feix._searched(workers, given, tmp_path, FOUR, 9)
    assert winner["evaluations"] == given.around + 2 * len(given.tried)
    kept = (winner["pattern"], winner["seed"], winner["evaluation"], winner["cost"]) == (
        (stored.pattern, stored.seed, stored.evaluation, stored.cost)
    )
    assert kept == (toward > 0.0)
    assert kept or winner["evaluation"].startswith("four_channels_9/")


def test_a_known_grasp_that_cannot_be_simulated_gives_way(tmp_path, monkeypatch):
    begin = values_of(9, load_patterns().grasps[9].pattern)

    def tried(values, settings, seed):
        if all(values[name] == begin[name] for name in "xyz"):
            raise RuntimeError("diverged")
        return {"cost": 20.0, "typed": "", "held_reason": "", "dropped": False}

    monkeypatch.setattr(feix_search, "_tried", tried)
    given = replace(Parameters(**feix.SMALL), known=feix.SHIPPED, around=9)
    with start_workers(0) as workers:
        winner = feix._searched(workers, given, tmp_path, FOUR, 9)
    assert winner["failed"] == 1
    assert winner["evaluation"] not in ("four_channels_9/0000", "")


@pytest.mark.parametrize(
    "given",
    [
        {"types": (34,)},
        {"types": ()},
        {"cases": (UNTURNED,)},
        {"checks": ("twice",)},
        {"cases": ("x",)},
    ],
)
def test_what_there_is_not_is_refused(given):
    with pytest.raises(ValueError, match="expected"):
        Parameters(**given)


@pytest.fixture(scope="module")
def searched(tmp_path_factory):
    """Folder and results of a small run."""
    folder = tmp_path_factory.mktemp("searched")
    return folder, feix.run(Parameters(**feix.SMALL), Job(folder, lambda what, share: None))


def test_a_small_run_is_taken_up_with_the_same_outcome_and_another_type_added(searched, tmp_path):
    folder, first = searched
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    given, job = Parameters(**feix.SMALL), Job(tmp_path, lambda what, share: None)
    again = feix.run(given, job)
    assert first["cases"] == again["cases"] and first["checks"] == again["checks"]
    assert (first["joints"] == again["joints"]).all()
    stored = load_patterns(tmp_path / feix.PATTERNS)
    assert list(stored.grasps) == [9] and stored.segments == given.segments
    assert stored.grasps[9].pattern.final["b"] == first["cases"][FOUR]["9"]["final"]["b"]
    more = feix.run(replace(given, evaluations=8), job)
    assert more["cases"][FOUR]["9"]["evaluations"] == 8 + 1
    assert replace(given, types=(2,)).continued(tmp_path).types == (2, 9)
    save_figure(feix, first, report(first, given), tmp_path / "figure.png")
    assert (tmp_path / "figure.png").stat().st_size > 20_000


def test_winners_come_from_a_file_with_the_same_trials_and_without_a_search(searched, tmp_path):
    folder, first = searched
    stored, path = Job(tmp_path, lambda what, share: None), str(folder / feix.PATTERNS)
    given = Parameters(**feix.SMALL, patterns=path)
    found = feix.run(given, stored)
    taken, own = (one["cases"][FOUR]["9"] for one in (found, first))
    assert taken["final"] == own["final"] and taken["evaluations"] == 0
    assert without_times(taken["trials"]) == without_times(own["trials"])
    assert "searches" not in [finding.what for finding in report(found, given).findings]
    with pytest.raises(ValueError, match=r"expected a grasp of type 3, got \[9\]"):
        feix.run(replace(given, types=(3,)), stored)


def without_times(trials):
    return [{k: v for k, v in trial.items() if not k.endswith("_time")} for trial in trials]
