"""Benches of whole hands: what is hidden, slips, scores, and cases that are kept."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from bench.hands import verdicts
from bench.hands.cases import HIGHEST, PLAN, SENSOR, SIZES, hidden_in
from bench.hands.drawn import DRAWN, PLANS, drawn
from bench.hands.slips import SLIPS, with_slip
from bench.hands.verdicts import judge, scored
from model_lab.bench.hand_motion_set import hand_motion_set
from model_lab.measurements.hands import default_markers
from model_lab.slips.of_hand import candidates_of_hand
from softhand_model.effects import effect_classes
from softhand_model.effects.hand import HandEffect
from softhand_model.hand.hand import load_hand

MOVING = [
    one
    for one in effect_classes().values()
    if issubclass(one, HandEffect) and "hand_motion" in one.experiments
]


TWO = [n for n, (kind, group) in enumerate(PLAN) if group == "two" and kind != SENSOR]


@pytest.mark.parametrize("number", TWO)
def test_two_effects_act_in_one_hand_as_each_alone(number):
    hand, kind = load_hand("rbo_hand_2"), PLAN[number][0]
    both = hidden_in(hand, *PLAN[number], np.random.default_rng(number))
    random = np.random.default_rng(number)
    one, other = (hidden_in(hand, name, "strong", random) for name in kind.split(" and "))
    assert both.both == ((one.name, one.where), (other.name, other.where))
    assert {effect.name for effect in both.effects} == {
        effect.name for effect in (*one.effects, *other.effects)
    }
    pressures, at = np.array(HIGHEST), np.arange(15.0).reshape(5, 3)
    frames, down = np.broadcast_to(np.eye(3), (5, 3, 3)), np.array([0.0, 0.0, -1.0])
    assert np.allclose(both.acting(pressures), other.acting(one.acting(pressures)))
    moved = other.seen(at, frames, down) + one.seen(at, frames, down) - at
    assert np.allclose(both.seen(at, frames, down), moved)


def test_one_sensor_is_off_in_scale_and_zero():
    hand = load_hand("rbo_hand_2")
    hidden = hidden_in(hand, SENSOR, "two", np.random.default_rng(1))
    ((gain, where), (offset, same)) = hidden.both
    assert (gain, offset) == ("channel_gain", "channel_offset") and where == same == hidden.where
    read = hidden.read(np.array([0.0, 10e3])[:, None] * np.ones(len(hand.channels)))
    here = hand.channels.index(where["channel"])
    assert read[:, here] == pytest.approx([2e3, 14e3])
    assert np.delete(read, here, axis=1).tolist() == [[0.0] * 3, [10e3] * 3]


@pytest.mark.parametrize("experiment", PLANS)
def test_a_seed_draws_all_kinds(experiment):
    cases, plan = [drawn(5, number, experiment) for number in range(DRAWN)], PLANS[experiment]
    assert [drawn(5, 3, experiment)] == cases[3:4] != [drawn(6, 3, experiment)]
    for group in {group for group in plan.round if group != "nothing"}:
        kinds = {one.kind for one in cases if one.group == group}
        assert kinds <= set(plan.groups[group])
        assert group in ("two", "weak") or kinds == set(plan.groups[group])
    assert len(cases) % len(plan.round) == 0


def test_sizes_lie_between_strong_and_weak():
    hand = load_hand("rbo_hand_2")
    for kind in ("dead_zone", "actuator_scatter"):
        strong, weak = SIZES[kind]
        values = [
            hidden_in(hand, kind, "strong", np.random.default_rng(1), share).value
            for share in (None, 0.0, 0.4, 1.0)
        ]
        values = [min(value, 1.0 / value) if weak < 1.0 else value for value in values]
        assert values[0] == values[1] == strong
        assert values[3] == pytest.approx(weak)
        assert min(strong, weak) < values[2] < max(strong, weak)


@pytest.mark.parametrize("kind", PLANS["hand_motion"].sizes)
def test_what_is_hidden_in_a_motion_has_its_size_and_place(kind):
    hand, sizes = load_hand("rbo_hand_2"), PLANS["hand_motion"].sizes
    hidden = hidden_in(hand, kind, "strong", np.random.default_rng(2), 0.0, sizes)
    (mine,) = [one for one in MOVING if one.kind == kind]
    if hidden.value is not None:
        assert sizes[kind][0] in (hidden.value, pytest.approx(1.0 / hidden.value))
    assert hidden.where in mine.places(hand, default_markers(hand))


@pytest.mark.parametrize("kind", SLIPS)
def test_a_slip_is_undone_by_the_mend_of_its_name(kind):
    random = np.random.default_rng(1)
    empty = hand_motion_set()
    true = filled(empty, random)
    wrong, (name, column) = with_slip(true, kind, random)
    columns = (*true.outputs, *true.pressures)
    assert any(
        all(np.allclose(mended.columns[key], run.columns[key], rtol=1e-6) for key in columns)
        for candidate in candidates_of_hand(wrong)
        if (candidate.name, candidate.column) == (name, column)
        for mended, run in [(candidate.mended.runs[0], true.runs[0])]
    )


def filled(empty, random):
    """The set with numbers in all its columns."""
    runs = [
        replace(
            run,
            columns={
                **run.columns,
                **{name: random.uniform(size=run.samples) for name in empty.outputs},
            },
        )
        for run in empty.runs
    ]
    return replace(empty, runs=tuple(runs))


def answer_of(*effects, verdict="effects_missing", slips=()):
    named = [{"name": name, "where": where, "parameters": {}} for name, where in effects]
    return {"verdict": verdict, "effects": named, "tied": [], "slips": list(slips)}


INDEX, LEAK = ("actuator_scatter", {"actuator": "index"}), ("crosstalk", {"from": "a", "to": "b"})


def test_of_two_effects_both_and_nothing_else_must_be_named():
    hidden = SimpleNamespace(name="", strength="two", both=(INDEX, LEAK))
    assert scored(hidden, answer_of(LEAK, INDEX)) == "right"
    assert scored(hidden, answer_of(LEAK)) == "one of two"
    assert scored(hidden, answer_of(LEAK, ("dead_zone", {}))) == "wrong"
    assert scored(hidden, answer_of(verdict="unexplained")) == "unexplained"


def test_a_slip_must_be_named_with_its_columns():
    hidden = SimpleNamespace(name="", strength="slip", slip=("exchanged", "a, b"))
    mine = {"name": "exchanged", "column": "a, b"}
    assert scored(hidden, answer_of(verdict="slip", slips=[mine])) == "right"
    other = mine | {"column": "a, c"}
    assert scored(hidden, answer_of(verdict="slip", slips=[other])) == "wrong"
    assert scored(hidden, answer_of(INDEX, verdict="slip", slips=[mine])) == "wrong"
    assert scored(hidden, answer_of(verdict="adequate")) == "wrong"


def test_a_case_is_kept_as_it_ends_and_not_run_again(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    made = []

    def make(number):
        if number in made:
            raise AssertionError(f"case {number} was kept")
        made.append(number)
        if number == 1:
            raise KeyboardInterrupt
        hidden = SimpleNamespace(name="crosstalk", strength="strong", where=LEAK[1], value=0.2)
        return hidden, "data"

    answer = answer_of(LEAK) | {"confidence": None, "evidence": {}, "ranking": [], "helps": []}
    answer |= {"rmse_before": 3e-3, "rmse_after": 1e-3, "noise_floor": 1e-3}
    answer["effects"][0]["parameters"] = {"share": {"value": 0.19, "interval": (0.18, 0.21)}}
    found = SimpleNamespace(as_json=lambda: answer | {"noise_floor_parts": {}})
    monkeypatch.setattr(verdicts, "diagnose", lambda *_: SimpleNamespace(diagnosis=found))
    with pytest.raises(KeyboardInterrupt):
        judge("hands", [0, 1], make, "mm")
    capsys.readouterr()
    judge("hands", [0], make, "mm")
    printed = capsys.readouterr().out
    assert made == [0, 1]
    assert "| strong | 1 | 1 right | 0.21 to 1.00 |" in printed
    assert "intervals that hold the truth: 1 of 1" in printed
