"""The next experiment: how far apart explanations are in it, and whether it breaks the tie."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from lab_sets import measured, run

from bench.hidden.design import ExtraRun
from bench.hidden.sets.writing import append_runs
from bench.hidden.ties import tied
from model_lab.cli.main import main
from model_lab.diagnosis import next_experiment as module
from model_lab.diagnosis.diagnose import diagnose
from model_lab.diagnosis.next_experiment import (
    _separation,
    explanations,
    next_experiment,
    proposal,
)
from model_lab.measurements.load import load_measurements
from model_lab.report.text import diagnosis_json, plan_json, plan_text, write_template
from model_lab.rules import RULES
from softhand_model.model_file import load_model

CASES = {case.name: case for case in tied()}


def test_separation_is_that_of_the_full_covariance():
    """d**2 = D' (1 + J1 S1 J1' + J2 S2 J2')**-1 D, by the dense matrix."""
    random = np.random.default_rng(0)
    first, second = random.normal(size=(4, 30)), random.normal(size=(3, 30))
    difference = first[0] - second[0]
    dense = np.eye(30) + first[1:].T @ first[1:] + second[1:].T @ second[1:]
    expected = np.sqrt(difference @ np.linalg.solve(dense, difference))
    assert _separation(first, second) == pytest.approx(expected)


def test_what_an_explanation_can_give_way_counts_little():
    along = np.ones(50)
    stiff, loose = np.stack([along, 0.0 * along]), np.stack([along, 1e3 * along])
    other = np.zeros((1, 50))
    assert _separation(stiff, other) == pytest.approx(np.sqrt(50.0))
    assert _separation(loose, other) < 0.01


@pytest.fixture(scope="module")
def one_rate(tmp_path_factory):
    """Triangles of one rate of a finger behind a thin tube: its folder and how it was made."""
    folder = tmp_path_factory.mktemp("rate") / "set"
    case = CASES["plan/free_bending/one_rate/tube_lag/2"]
    case.make(folder, 0, 0.006)
    return folder, case


@pytest.fixture(scope="module")
def outcome(one_rate):
    return diagnose(load_measurements(one_rate[0]), load_model("base"))


@pytest.fixture(scope="module")
def planned(outcome):
    return outcome.diagnosis.next_experiment


def names_of(diagnosis):
    return {effect.name for effect in diagnosis.effects} | {
        name for names in diagnosis.tied for name in names
    }


def test_loops_of_one_rate_are_separated_by_another_rate(outcome, planned):
    assert len(names_of(outcome.diagnosis)) > 1
    assert planned["breaks"] and planned["separation"] > RULES.separation_breaks
    assert planned["changes"] == []
    rates = [
        np.abs(np.diff(run.columns["pressure"]) / np.diff(run.columns["time"])).max()
        for run in outcome.problem.data.runs
    ]
    rate = np.abs(np.diff(planned["inputs"]["pressure"]) / np.diff(planned["inputs"]["time"])).max()
    assert rate > 3.0 * max(rates)
    assert set(planned["separates"][0]) <= names_of(outcome.diagnosis)
    json.dumps(planned, allow_nan=False)


def test_done_and_added_it_breaks_the_tie(one_rate, outcome, planned, tmp_path):
    folder, case = one_rate
    extra = ExtraRun(
        planned["protocol"],
        planned["specimen"],
        planned["temperature"],
        np.array(planned["inputs"]["time"]),
        np.array(planned["inputs"]["pressure"]),
    )
    case.make(tmp_path / "longer", 0, 0.006, (extra, extra))
    append_runs(folder, tmp_path / "longer")
    data = load_measurements(folder)
    assert len(data.runs) == len(outcome.problem.data.runs) + 2
    after = names_of(diagnose(data, load_model("base")).diagnosis)
    assert "tube_lag" in after
    assert len(after) < len(names_of(outcome.diagnosis))


@pytest.mark.parametrize(
    ("behind", "noise", "told"),
    [(7.0, False, [3.0, 9.0]), (9.0, True, [3.0, 6.0]), (9.0, False, [0.0, 0.0])],
)
def test_no_run_is_promised_to_part_what_the_diagnosis_would_leave_tied(
    monkeypatch, behind, noise, told
):
    """As other forms of one equation, which the fit has told apart, and ties nevertheless."""
    monkeypatch.setattr(module, "leaves_more_than_noise", lambda problem, scored: not noise)
    pair = [
        SimpleNamespace(fit=SimpleNamespace(deviance=one, values=()), unusual=0.0, rules=RULES)
        for one in (behind, 0.0)
    ]
    apart = np.array([3.0, 9.0]), np.array([2.0, 1.5])  # sigma and floors, of two trials
    found = module._telling(SimpleNamespace(rules=RULES), pair, *apart)
    assert found.tolist() == told


def test_nothing_is_proposed_where_nothing_is_tied(outcome):
    final = outcome.selection.final
    assert proposal(outcome.problem, final, ((),)) is None
    assert proposal(outcome.problem, final, ()) is None


def tied_above(folder, name, **options):
    """A set whose pressure never falls below 0.3 of its peak, and what is said of it."""
    case = CASES[name]
    replace(case, options={**case.options, **options}).make(folder, 4712 * 2**31, 0.006)
    return diagnose(load_measurements(folder), load_model("base"))


def measured_too(folder, name, planned, place):
    """What is said of the set when the proposed experiment has been done twice."""
    changes = {key: planned[key] for key in ("mount", "wall", "length")}
    course = [np.array(planned["inputs"][column]) for column in ("time", "pressure")]
    about = (planned["protocol"], planned["specimen"], planned["temperature"])
    extra = ExtraRun(*about, *course, changes)
    CASES[name].make(place, 4712 * 2**31, 0.006, (extra, extra))
    append_runs(folder, place)
    return diagnose(load_measurements(folder), load_model("base"))


def test_a_blocked_tip_tells_a_gauges_zero_by_an_open_chamber_and_a_shorter_finger(tmp_path):
    """A zero of either gauge shifts the same force; a finger of another length pushes otherwise."""
    name = "plan/blocked_tip/above/pressure_offset/4"
    found = tied_above(tmp_path / "set", name)
    assert names_of(found.diagnosis) == {"pressure_offset", "force_offset"}
    best = found.diagnosis.next_experiment
    assert best["breaks"] and best["floors"] > 1.0
    assert best["length"] < 0.09 and "mm long" in best["changes"][0]
    [offset] = found.diagnosis.effects
    assert best["at_rest"]["force_offset"] == 0.0
    read = offset.parameters["offset"].value
    assert best["at_rest"]["pressure_offset"] == pytest.approx(read, rel=0.2)
    assert "with the chamber open: the gauge reads" in plan_text(
        diagnosis_json(found.diagnosis, "")
    )
    after = measured_too(tmp_path / "set", name, best, tmp_path / "longer")
    assert names_of(after.diagnosis) == {"pressure_offset"}


def test_an_open_chamber_that_has_been_read_tells_nothing_more(tmp_path):
    """Readings that an offset rules out separate nothing, if what is read of an open chamber has
    not parted it from a dead zone either.
    """
    found = tied_above(tmp_path / "set", "plan/free_bending/above/pressure_offset/4", samples=80)
    assert names_of(found.diagnosis) >= {"pressure_offset", "dead_zone"}
    groups = explanations(found.problem, found.selection.final, found.selection.ties)
    best = next_experiment(found.problem, groups)
    assert best.separation > RULES.separation_breaks and best.at_rest["dead_zone"] == 0.0
    first = found.problem.data.runs[0]
    first.columns["pressure"][0] = best.at_rest["pressure_offset"]
    known = next_experiment(found.problem, groups)
    assert known.separation < RULES.separation_breaks and known.at_rest == {}


def test_the_template_becomes_runs_of_the_set(one_rate, outcome, planned, tmp_path):
    place = tmp_path / "set"
    one_rate[1].make(place, 0, 0.006)
    files = write_template(planned, outcome.problem.data, tmp_path)
    course = np.genfromtxt(files[0], delimiter=",", names=True)
    np.testing.assert_allclose(course["pressure"] * 1e3, planned["inputs"]["pressure"], rtol=1e-6)
    np.testing.assert_allclose(course["time"], planned["inputs"]["time"], rtol=1e-6)
    part = yaml.safe_load(files[1].read_text())
    document = yaml.safe_load((place / "experiment.yaml").read_text())
    assert {name: entry["unit"] for name, entry in part["columns"].items()} == {
        name: entry["unit"] for name, entry in document["columns"].items()
    }
    document["runs"] |= part["runs"]
    (place / "experiment.yaml").write_text(yaml.safe_dump(document, sort_keys=False))
    rows = np.column_stack([course["time"], course["pressure"], 0.0 * course["time"]])
    head = "time,pressure,tip_angle"
    for name in part["runs"]:
        np.savetxt(place / f"{name}.csv", rows, delimiter=",", header=head, comments="")
    groups = load_measurements(place).groups()
    assert [len(group) for group in groups] == [2] * 7


def test_the_template_has_the_units_of_the_set(outcome, planned, tmp_path):
    data = replace(outcome.problem.data, units={"time": "ms", "pressure": "psi", "tip_angle": "°"})
    files = write_template(planned, data, tmp_path)
    course = np.genfromtxt(files[0], delimiter=",", names=True)
    psi = np.array(planned["inputs"]["pressure"]) / 6894.757
    np.testing.assert_allclose(course["pressure"], psi, rtol=1e-6)
    columns = yaml.safe_load(files[1].read_text())["columns"]
    assert columns == {name: {"unit": unit} for name, unit in data.units.items()}


def test_it_is_told_in_the_units_of_the_bench(outcome):
    answer = diagnosis_json(outcome.diagnosis, "")
    text = plan_text(answer)
    assert "temperature      20 degC" in text
    assert "peak pressure" in text and "kPa" in text
    assert "so tells them apart" in text
    content = plan_json(answer, [])
    assert content["next_experiment"]["peak"] > 1e4
    assert content["tied"] == [list(names) for names in outcome.diagnosis.tied]


def test_a_new_specimen_is_entered_like_the_first(outcome, planned, tmp_path):
    new = {**planned, "specimen": "finger_base_up", "mount": "base_up", "wall": 0.004}
    files = write_template(new, outcome.problem.data, tmp_path)
    part = yaml.safe_load(files[1].read_text())
    entry = part["specimens"]["finger_base_up"]
    assert (entry["mount"], entry["wall"], entry["length"]) == ("base_up", 0.004, 0.09)
    assert part["runs"]["next_b"]["specimen"] == "finger_base_up"


def test_a_folder_with_files_is_not_written_into(one_rate, tmp_path, capsys):
    (tmp_path / "mine").write_text("mine")
    assert main(["plan", str(one_rate[0]), "--out", str(tmp_path)]) == 2
    assert "--force" in capsys.readouterr().err


def test_a_set_of_inflations_alone_gets_a_proposal():
    """The model of a trial that deflates has a coefficient that such a set does not show."""
    durations = [287, 56, 29, 252, 243, 47, 187, 79, 35, 41, 69, 138, 37, 61, 28]  # [ms]
    masses = [7.1, 0.9, 0.8, 6.4, 6.4, 1.0, 4.6, 1.9, 0.4, 0.5, 1.5, 3.2, 0.4, 1.5, 0.4]  # [mg]
    columns = {
        "direction": np.ones(15),
        "duration": 1e-3 * np.array(durations),
        "p_in": np.full(15, 350e3),
        "p_out": np.linspace(106e3, 112e3, 15),
        "mass": 1e-6 * np.array(masses),
    }
    data = measured("valve_pulse", [run("r1", **columns)])
    found = diagnose(replace(data, noise={"mass": 2e-7}), load_model("base")).diagnosis
    assert "valve_delay" in names_of(found) and found.next_experiment is not None
