"""Seeds of the blind benchmark, what its table counts, and what it keeps to itself."""

import json
from dataclasses import replace

import numpy as np
import pytest
import yaml

from bench.hidden.case import seed_of, visible
from bench.hidden.cases import all_cases
from bench.hidden.reserved import RESERVED, is_reserved
from bench.hidden.sets import recording
from bench.lab import __main__ as lab
from bench.lab import store
from bench.lab.notes import misses_of, notes_of
from bench.lab.reliability import calibration_error, error_by_chance, error_interval
from bench.lab.scoring import refused, right, wrong_alone, wrong_name
from bench.lab.table import ROWS, rows_of, text_of
from bench.lab.work import chosen, jobs_of, smaller
from model_lab.diagnosis.diagnose import diagnose
from model_lab.measurements.load import load_measurements
from softhand_model.model_file import load_model


def record(row, names, said, *, tied=None, case="a/b/c", ratio=4.0, **answer):
    """A finished set: hidden names, and what was said."""
    verdict = {(): "adequate"}.get(tuple(said), "effects_missing")
    expected = "effects_missing" if names else "adequate"
    return {
        "key": f"{case}{said}{answer}", "row": row, "case": case, "experiment": "uniaxial",
        "noise": 0.006, "seed": 7, "ratio": ratio, "visible": True, "seconds": 1.0,
        "expected": {"verdict": expected, "names": [[n] for n in names], "tied": [], "besides": []},
        "truth": {"hidden": [], "floor": 1.0, "ratio": ratio},
        "answer": {
            "verdict": verdict, "effects": [{"name": n, "parameters": {}} for n in said],
            "tied": tied or [[] for _ in said], "noise_floor": 1.0, "rmse_before": 4.0,
            "rmse_after": 1.0, "confidence": None, "guess": False, **answer,
        },
    }  # fmt: skip


@pytest.fixture
def place(tmp_path, monkeypatch):
    """The store in an empty folder, and diagnoses that take no time."""
    for name in ("LINES", "UNDER_WAY"):
        monkeypatch.setattr(store, name, tmp_path / getattr(store, name).name)
    monkeypatch.setattr(store, "OUT", tmp_path)

    def finished(jobs, workers, until):
        for job in jobs:
            made = record("nothing", [], [], case=job.case)
            yield {**made, "key": job.key, "seed": job.seed}

    monkeypatch.setattr(lab, "finished", finished)
    return tmp_path


def test_loops_of_one_rate_are_right_if_all_are_tied_and_nothing_but_lags_besides():
    expected = next(case.expected for case in all_cases() if case.row == "one rate")
    words = {name: sorted(getattr(expected, name)) for name in ("tied", "besides")}

    def is_right(first, *others):
        made = record("one rate", ["a"], [first], tied=[others])
        return right({**made, "expected": {**made["expected"], **words}})

    loops = ("viscoelasticity", "hysteresis")
    assert is_right("tube_lag", *loops)
    assert is_right("tube_lag", *loops, "clock_offset", "angle_sensor_lag")
    assert not is_right("tube_lag", "hysteresis", "clock_offset")
    assert not is_right("tube_lag", *loops, "creep")


def run(place, *arguments):
    assert lab.main(["--rows", "nothing", "--revision", "r", *arguments]) == 0
    return json.loads((place / "bench-lab.json").read_text())


def seeds(place):
    lines = (place / store.LINES.name).read_text().splitlines()
    return {json.loads(line)["seed"] for line in lines}


def test_every_run_draws_seeds_that_no_other_has(place):
    one, other = run(place)["seed"], run(place)["seed"]
    assert one != other and min(one, other) >= 1
    assert len(seeds(place)) == 2 and min(seeds(place)) >= store.SPAN


def test_a_run_that_was_stopped_goes_on_with_its_seed(place, monkeypatch):
    whole = lab.finished
    monkeypatch.setattr(lab, "finished", lambda jobs, *rest: whole(jobs[:5], *rest))
    first = run(place)
    monkeypatch.setattr(lab, "finished", whole)
    again = run(place)
    assert (first["sets"], first["seed"]) == (5, again["seed"])
    assert again["sets"] == again["planned"] > 5


def test_a_run_is_done_again_with_its_seed(place):
    first = run(place)
    again = run(place, "--seed", str(first["seed"]))
    assert again["rows"] == first["rows"] and len(seeds(place)) == 1


def test_figures_of_development_seeds_are_no_results(place, capsys):
    assert lab.main(["--rows", "nothing", "--revision", "r", "--development"]) == 0
    assert not (place / "bench-lab.json").exists()
    assert lab.WARNING in capsys.readouterr().out
    assert max(seeds(place)) < 1000


@pytest.mark.parametrize("seed", ["0", "-3"])
def test_the_seed_of_a_run_cannot_be_one_of_development(seed):
    with pytest.raises(SystemExit):
        lab.options(["--seed", seed])


def test_runs_share_no_seed_of_the_generator():
    names = [case.name for case in all_cases()]
    known = {seed_of(name, number) for name in names for number in range(1000)}
    blind = {seed_of(name, store.first_seed(1) + number) for name in names for number in range(9)}
    assert not known & blind


def test_the_whole_run_is_large_enough_and_a_small_one_has_every_row():
    jobs = jobs_of(chosen([], []), 1, "r", [])
    few = smaller(jobs, seed=3)
    rows = {case.name: case.row for case in chosen([], [])}
    assert len(jobs) >= 800 and len(few) < len(jobs) / 6
    assert {rows[job.case] for job in few} == set(ROWS)
    assert [job.key for job in few] == [job.key for job in smaller(jobs, seed=3)]


def test_six_families_outside_the_catalogue_are_left_to_blind_runs():
    assert len(RESERVED.split()) >= 6
    assert any(is_reserved(case.name) for case in chosen([], []))
    assert not any(is_reserved(case.name) for case in chosen([], [], development=True))


def test_what_is_said_of_the_families_kept_for_blind_runs_is_counted_and_not_listed():
    kept = record("outside", ["x"], ["tube_lag"], case="reserved/uniaxial/secret/5")
    other = record("outside", ["x"], ["tube_lag"], case="outside/uniaxial/known/5")
    lines = misses_of([kept, other])
    assert len(lines) == 2 and lines[0].startswith("1 sets") and "known" in lines[1]
    assert "secret" not in "".join(lines)


def test_wrong_verdicts_that_are_no_guess_and_slips_where_none_is_are_counted():
    right = record("catalogue", ["a"], ["a"])
    sure = record("catalogue", ["a"], ["b"], confidence=0.95)
    guess = record("catalogue", ["a"], ["b"], confidence=0.5, guess=True)
    unknown = record("catalogue", ["a"], [], verdict="unexplained")
    slip = record("nothing", [], [], verdict="slip")
    lines = notes_of([right, sure, guess, unknown, slip])
    assert "wrong and sure: 2 of 5, 1 with a confidence" in lines
    assert "slips told where none is: 1 of 5" in lines


def test_refusals_that_tell_the_family_as_helping_are_counted():
    told, other = ([{"name": name, "rmse_after": 1.0}] for name in ("a", "c"))
    refusals = [
        record("other form", ["a", "b"], [], verdict="unexplained", helps=helps)
        for helps in (told, other, [], None)
    ]
    assert "unexplained, though known: 4; its family helps in 1" in notes_of(refusals)


@pytest.mark.parametrize("law", RESERVED.split())
def test_a_family_kept_for_blind_runs_shows_as_much_as_asked(law, tmp_path):
    case = next(c for c in all_cases() if c.name == f"reserved/free_bending/{law}/3")
    truth = case.make(tmp_path, 1, 0.006)
    assert visible(truth) and truth["ratios"][0] == pytest.approx(3.0, rel=0.25)


@pytest.mark.parametrize(("seed", "stiffens"), [(2, False), (3, True)])
def test_a_law_that_stiffens_is_left_out_where_only_its_other_term_shows(seed, stiffens, tmp_path):
    case = next(c for c in all_cases() if c.name == "form/rubber/three_terms/repeats/strong")
    truth = case.make(tmp_path, seed, 0.002)
    data = load_measurements(tmp_path)
    fitted = diagnose(data, load_model("base")).diagnosis
    assert visible(truth) == stiffens
    assert (fitted.effects[0].name == "mooney_rivlin") != stiffens


def test_cases_have_names_of_their_own():
    names = [case.name for case in chosen([], [])]
    assert len(set(names)) == len(names)


# ---------------------------------------------------------------------- how sets are recorded
def test_scarce_sets_have_a_few_runs_of_one_finger_and_nothing_to_take_the_noise_from(tmp_path):
    case = next(c for c in all_cases() if c.name == "two_runs/free_bending/tube_lag")
    assert visible(case.make(tmp_path, 1, 0.006))
    written = yaml.safe_load((tmp_path / "experiment.yaml").read_text())
    assert len(written["runs"]) == 2 and len(written["specimens"]) == 1
    assert len({run["protocol"] for run in written["runs"].values()}) == 2
    assert "noise" not in written


@pytest.mark.parametrize("way", ["wild_1_%", "wild_3_%", "quantised", "two_rates"])
def test_disturbed_sets_have_what_they_are_named_for_and_load(way, tmp_path):
    case = next(c for c in all_cases() if c.name == f"{way}/uniaxial/nothing")
    truth = case.make(tmp_path / "set", 1, 0.006)
    plain = {**case.options, **dict.fromkeys(("wild", "output_steps", "drive_steps"), 0)}
    dull = {"drive_rate": 0.0} if way == "two_rates" else {}
    replace(case, options=plain | dull).make(tmp_path / "clean", 1, 0.006)
    disturbed, clean = (load_measurements(tmp_path / name) for name in ("set", "clean"))
    assert [run.samples for run in disturbed.runs] == [run.samples for run in clean.runs]
    change = np.abs(disturbed.table.value - clean.table.value)
    wild = np.mean(change > 20 * truth["noise"])
    assert wild == pytest.approx(case.options.get("wild", 0.0), abs=0.008)
    if way == "quantised":
        assert len(np.unique(disturbed.table.value.round(3))) <= 101


def test_a_share_of_the_samples_goes_wild_and_the_others_stay():
    clean = np.random.default_rng(0).normal(size=(4, 5000))
    wild = recording.gone_wild(clean, 0.03, np.random.default_rng(1))
    assert np.mean(wild != clean) == pytest.approx(0.03, abs=0.006)


def test_a_coarse_sensor_knows_few_values():
    fine = np.random.default_rng(0).uniform(2.0, 9.0, (3, 400))
    coarse = recording.in_steps(fine, 20)
    assert len(np.unique(coarse.round(9))) <= 21
    assert np.abs(coarse - fine).max() <= np.ptp(fine) / 20 / 2 + 1e-12


def test_the_latest_reading_is_late_by_less_than_the_time_between_readings():
    time = np.linspace(0.0, 20.0, 601)[None]
    read = recording.latest(time, time, 100 / 30, np.random.default_rng(2))
    late = (time - read)[0, 1:]
    assert late.min() >= -1e-9 and 0.0066 < late.max() <= 0.01


# ---------------------------------------------------------------------- what the table counts
def test_a_wrong_name_alone_is_told_from_one_in_a_tie():
    alone = record("weak", ["tube_lag"], ["dead_zone"])
    in_a_tie = record("weak", ["tube_lag"], ["dead_zone"], tied=[["gravity"]])
    fine = record("weak", ["tube_lag"], ["dead_zone"], tied=[["tube_lag"]])
    assert [wrong_alone(r) for r in (alone, in_a_tie, fine)] == [True, False, False]
    assert [wrong_name(r) for r in (alone, in_a_tie, fine)] == [True, True, False]


def test_a_guess_refuses_and_so_does_what_nothing_explains():
    sure = record("scarce", ["tube_lag"], ["dead_zone"])
    guess = record("scarce", ["tube_lag"], ["dead_zone"], guess=True)
    nothing = record("scarce", ["tube_lag"], [], verdict="unexplained")
    assert [refused(r) for r in (sure, guess, nothing)] == [False, True, True]
    rows = {row["name"]: row for row in rows_of([sure, guess, nothing])}
    assert rows["scarce: right, or refused"]["value"] == pytest.approx(2 / 3)
    assert rows["scarce: a wrong name that is not said as a guess"]["value"] == pytest.approx(1 / 3)
    assert rows["scarce: a wrong name that is not said as a guess"]["met"] is False


def test_disturbed_sets_are_compared_with_the_same_effects_undisturbed():
    clean = [record("catalogue", ["tube_lag"], ["tube_lag"], case="free_bending/tube_lag/medium")]
    wild = [record("wild 1 %", ["tube_lag"], ["dead_zone"], case="wild_1_%/free_bending/tube_lag")]
    rows = {row["name"]: row for row in rows_of(clean + wild)}
    assert rows["wild 1 %: right"]["target"] == pytest.approx(0.97)
    assert rows["wild 1 %: right"]["met"] is False


def test_confidence_is_held_against_what_is_right():
    fine = [record("nothing", [], [], confidence=0.9, case=f"c{k}") for k in range(9)]
    wrong = record("nothing", [], ["tube_lag"], confidence=0.9, guess=True)
    rows = {row["name"]: row for row in rows_of([*fine, wrong])}
    assert rows["confidence: expected calibration error"]["value"] == pytest.approx(0.0, abs=1e-9)
    assert rows["confidence: refused among the wrong ones"]["value"] == 1.0
    assert rows["  confidence: said as a guess among the right ones"]["value"] == 0.0
    assert "<= 4 %" in text_of(list(rows.values()))


def test_confidences_that_hold_have_the_error_of_chance_and_others_a_larger_one():
    random = np.random.default_rng(3)
    said = random.uniform(0.5, 1.0, 400)
    true = random.random(400) < said
    assert calibration_error(said, true) < 2.0 * error_by_chance(said)
    boastful = calibration_error(np.full(400, 0.99), true)
    assert boastful == pytest.approx(0.99 - true.mean(), abs=1e-9)
    low, high = error_interval(np.full(400, 0.99), true)
    assert low < boastful < high
