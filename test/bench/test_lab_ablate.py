"""Dropping rules: what is drawn, what is counted, and that kept fits change no verdict."""

import pytest

from bench.hidden.cases import all_cases
from bench.lab import ablate
from model_lab.diagnosis.diagnose import diagnose
from model_lab.measurements.load import load_measurements
from model_lab.rules import neutral_rules
from softhand_model.model_file import load_model

MISSING, ADEQUATE = "effects_missing", "adequate"


def answer(verdict, *names):
    effects = [{"name": name} for name in names]
    return {"verdict": verdict, "effects": effects, "tied": [[] for _ in names], "helps": []}


def record(without, expected=MISSING, names=(("gent_stiffening",),)):
    said = answer(MISSING, "gent_stiffening")
    truth = {"verdict": expected, "names": [list(n) for n in names], "tied": []}
    return {"row": "weak", "expected": truth, "answer": said, "without": without}


def test_every_row_is_drawn_in_turn_and_the_same_seed_draws_the_same_sets():
    first = ablate.drawn(7, 30)
    assert [case.name for case, _ in first] == [case.name for case, _ in ablate.drawn(7, 30)]
    assert [case.name for case, _ in first] != [case.name for case, _ in ablate.drawn(8, 30)]
    rows = {case.row for case in all_cases()} - set(ablate.LEFT_OUT)
    assert {case.row for case, _ in first} == rows
    assert all(noise in case.noises for case, noise in first)


def test_the_table_counts_changes_and_what_becomes_right_or_wrong():
    lost = {"material_error": answer(ADEQUATE)}
    gained = record({"material_error": answer(ADEQUATE)}, ADEQUATE, ())
    of_others = {"row": "real", "answer": answer(ADEQUATE), "without": lost}
    text = ablate.table_of([record(lost), record({}), gained, of_others, {"visible": False}])
    rows = {line.split()[0]: line.split()[1:] for line in text.splitlines()}
    assert rows["material_error"] == ["3", "2", "1", "1"]
    assert rows["beam_gain"] == ["0", "0", "0", "0"]
    assert "4 sets: 1 real, 3 weak" in text
    assert "right with all rules: 2 of 3" in text


@pytest.fixture(scope="module")
def stiffening(tmp_path_factory):
    folder = tmp_path_factory.mktemp("set")
    [case] = [c for c in all_cases() if c.name == "uniaxial/gent_stiffening/medium"]
    case.make(folder, 5001, 0.006)
    return load_measurements(folder)


def test_a_rule_that_is_dropped_changes_what_hangs_on_it_alone(stiffening):
    found = ablate.ablated(stiffening, load_model("base"), 1)
    plain = diagnose(stiffening, load_model("base"), seed=1).diagnosis
    assert found["answer"]["verdict"] == plain.verdict
    assert [e["name"] for e in found["answer"]["effects"]] == [e.name for e in plain.effects]
    assert found["answer"]["tied"] == [list(names) for names in plain.tied]
    assert "tie_deviance" in found["without"]
    assert "line_share" not in neutral_rules()
    assert len(found["without"]) < len(neutral_rules())


def test_a_group_is_dropped_at_once_and_its_rules_alone_only_if_that_changes_something(stiffening):
    base, lost = load_model("base"), ["beam_gain", "tie_deviance"]
    found = ablate.ablated(stiffening, base, 1, names=(), group=lost)["without"]
    assert set(found) == {ablate.TOGETHER, "tie_deviance"}
    assert ablate.ablated(stiffening, base, 1, names=(), group=lost[:1])["without"] == {}


def test_kept_fits_are_those_that_would_be_made_anew(stiffening, monkeypatch):
    """The rules that change a verdict are the same whether fits are kept or not."""
    chosen = ("tie_deviance", "material_error", "significance")
    some = {name: rules for name, rules in neutral_rules().items() if name in chosen}
    monkeypatch.setattr("model_lab.rules.neutral_rules", lambda: some)
    kept = ablate.ablated(stiffening, load_model("base"), 1)
    monkeypatch.setattr(
        "model_lab.fitting.problem.FitProblem.once", lambda self, make, *key: make()
    )
    assert ablate.ablated(stiffening, load_model("base"), 1) == kept
