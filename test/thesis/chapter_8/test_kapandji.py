"""The Kapandji experiment: what is said of made-up results, and one small run."""

from dataclasses import replace

import numpy as np
import pytest

from softhand_trials.search import Tried
from thesis.chapter_8 import kapandji
from thesis.chapter_8.dexterity.posture import FOUR, RIGID, SEVEN, THUMB_FIRST, hand_variant
from thesis.chapter_8.kapandji import (
    CASES,
    FAR,
    LEAST,
    NO_INDEX,
    Found,
    Parameters,
    Searches,
    by_actuator,
    by_channel,
    problem,
    report,
)


def one(distance, pressure=40e3, touched=None):
    touched = distance <= 0.008 if touched is None else touched
    repeat = {
        "touched": touched,
        "reason": "" if touched else "not within the radius",
        "distance": distance,
        "gap": distance,
        "others": [],
        "at_radius": {"5": distance <= 0.005, "8": touched, "12": distance <= 0.012},
    }
    return {
        "values": {**dict.fromkeys("abcd", pressure), THUMB_FIRST: 1.0},
        "statics": 0.5 * distance,
        "longer": False,
        "runs": 30,
        "minutes": 0.5,
        "repeats": [repeat] * 3,
    }


def results(**cases):
    line = {"twists": np.array([-0.5, 0.0]), "places": np.zeros((2, 3))}
    axes = {f"{name}_{key}": v for name in ("equal", "differing") for key, v in line.items()}
    found = {n: {str(p): o for p, o in c.items()} for n, c in cases.items()}
    fine = {name: places for name, places in found.items() if name in LEAST}
    return {"cases": found, "fine": fine, **axes}


def seven(found):
    """With a channel for each actuator."""
    values = {**dict.fromkeys(hand_variant(SEVEN).channels, 40e3), THUMB_FIRST: 0.0}
    return {place: {**one, "values": values} for place, one in found.items()}


def reached(*far, near=0.004):
    return {place: one(0.02 if place in far else near) for place in range(1, 9)}


def met(found):
    return {finding.what: finding.met for finding in found.findings if finding.met is not None}


def test_seven_of_eight_with_place_one_missed_is_what_the_thesis_found():
    good = {
        FOUR: reached(1),
        SEVEN: seven(reached(1)),
        RIGID: reached(1, 2, 4, 5, 6),
        NO_INDEX: {place: one(0.03) for place in (1, 2, 3)},
    }
    found = met(report(results(**good), Parameters()))
    assert len(found) == 6 and all(found.values())


@pytest.mark.parametrize(
    ("case", "places", "what"),
    [
        (FOUR, reached(1, 2, 3), "places reached within 8 mm, four channels"),
        (SEVEN, seven(reached(1, 2)), "places reached within 8 mm, seven channels"),
        (FOUR, {**reached(4), 2: one(0.004, 70e3)}, "place 1 is the hardest, four channels"),
        (RIGID, reached(1, 2, 3, 4), "negative control: palm rigid"),
        (NO_INDEX, {2: one(0.001)}, "negative control: index empty, places 1 to 3"),
    ],
)
def test_a_missed_criterion_is_said(case, places, what):
    assert met(report(results(**{case: places}), Parameters()))[what] is False


def test_a_place_counts_when_every_repeat_touches():
    twice = reached(1)
    twice[5]["repeats"] = [*twice[5]["repeats"][:2], one(0.03)["repeats"][0]]
    table = report(results(**{FOUR: twice}), Parameters()).table
    assert "6 of 8: 2, 3, 4, 6, 7, 8" in table
    assert "place 5: ring, tip, four channels | reached | 2 of 3" in table
    assert "winners at steps of 1 ms, four channels | - | 6 of 8" in table


def test_places_within_other_radii_are_listed():
    mixed = reached(1)
    mixed[6] = one(0.007)
    table = report(results(**{FOUR: mixed}), Parameters()).table
    assert "| within 5 mm, four channels | - | 6 of 8: 2, 3, 4, 5, 7, 8" in table
    assert "| within 12 mm, four channels | - | 7 of 8" in table


def test_searches_leave_out_what_is_to_stay_empty_and_have_seeds_of_their_own():
    given = Parameters()
    four = problem(given, FOUR, 3)
    assert [(v.name, v.high) for v in four.variables] == [
        ("a", 80e3),
        ("b", 80e3),
        ("c", 105e3),
        ("d", 160e3),
        (THUMB_FIRST, 1.0),
    ]
    assert len(problem(given, SEVEN, 3).variables) == 7 + 1
    assert [v.name for v in problem(given, NO_INDEX, 2).variables] == ["a", "c", "d", THUMB_FIRST]
    assert four.seed != problem(given, FOUR, 4).seed
    assert all(set(places) <= set(range(1, 9)) for _, _, places in CASES.values())


def test_seven_channels_contain_each_posture_of_four():
    values = by_actuator({"a": 1.0, "b": 2.0, "c": 3.0, "d": 4.0, THUMB_FIRST: 0.0})
    assert set(values) == {*hand_variant(SEVEN).channels, THUMB_FIRST}
    assert values[THUMB_FIRST] == 0.0
    assert [values[name] for name in ("little", "ring", "middle", "index")] == [1.0, 1.0, 1.0, 2.0]
    assert [values[name] for name in ("thumb", "palm_inner", "palm_outer")] == [3.0, 3.0, 4.0]


def test_four_channels_come_near_a_posture_of_seven():
    four = {"a": 10e3, "b": 20e3, "c": 30e3, "d": 40e3, THUMB_FIRST: 1.0}
    assert by_channel(by_actuator(four), "little") == pytest.approx(four)
    seven = {**by_actuator(four), "little": 60e3, "thumb": 50e3}
    assert by_channel(seven, "little") == pytest.approx({**four, "a": 60e3, "c": 40e3})


def test_a_longer_search_knows_winners_with_other_channels_and_of_the_places_beside_it(
    monkeypatch, tmp_path
):
    asked = []

    def short(_workers, _given, case, place, known, _folder):
        channels = hand_variant(CASES[case][0]).channels
        values = {**dict.fromkeys(channels, 1e3 * place), THUMB_FIRST: 0.0}
        touched = (case, place) != (FOUR, 6)
        assert len(known) == (case == SEVEN)
        return Found(Tried({"values": values, "cost": 9.0}, [{"cost": 9.0, "touched": touched}]), 0)

    def longer(_workers, _given, case, place, one, known, _folder):
        asked.append((case, place, [posture["a"] for posture in known]))
        return replace(one, longer=True)

    monkeypatch.setattr(kapandji, "_searched", short)
    monkeypatch.setattr(kapandji, "_longer", longer)
    searches = Searches(None, Parameters(), tmp_path)
    assert searches.whole(FOUR, 6).longer and searches.whole(FOUR, 6).longer
    assert not searches.whole(FOUR, 5).longer and not searches.whole(SEVEN, 6).longer
    assert asked == [(FOUR, 6, [6e3, 5e3, 7e3])]
    one = Searches(None, Parameters(longer=("seven_channels_6",)), tmp_path)
    assert not one.whole(FOUR, 6).longer


def test_a_place_far_away_by_statics_is_judged_and_not_searched(tmp_path):
    from thesis.frame import Job

    few = {"cases": (NO_INDEX,), "places": (2,), "repeats": 1}
    given = Parameters(**{**kapandji.SMALL, **few})
    one = kapandji.run(given, Job(tmp_path, lambda what, share: None))["cases"][NO_INDEX]["2"]
    assert one["statics"] > FAR and "evaluations" not in one
    assert not kapandji.reached(one)
    assert not (tmp_path / NO_INDEX / "2" / "statics").exists()


def test_a_small_run_is_taken_up_from_its_lines_with_the_same_outcome(tmp_path):
    from thesis.frame import Job, save_figure

    given = Parameters(**{**kapandji.SMALL, "places": (1, 4), "repeats": 1})
    job = Job(tmp_path, lambda what, share: None)
    first = kapandji.run(given, job)
    again = kapandji.run(given, job)
    assert first["cases"] == again["cases"]
    assert (first["joints"] == again["joints"]).all()
    lines = (tmp_path / FOUR / "4" / "statics" / "results.jsonl").read_text().splitlines()
    assert len(lines) == kapandji.SMALL["starts"]
    lines = (tmp_path / FOUR / "4" / "around" / "results.jsonl").read_text().splitlines()
    assert len(lines) == kapandji.SMALL["around"]
    longer = tmp_path / FOUR / "1" / "longer"
    for name, count in (("local", "local"), ("wide", "wide"), ("again", "local")):
        lines = (longer / name / "results.jsonl").read_text().splitlines()
        assert len(lines) == kapandji.SMALL[count]
    said = report(first, given)
    save_figure(kapandji, first, said, tmp_path / "figure.png")
    assert (tmp_path / "figure.png").stat().st_size > 20_000
