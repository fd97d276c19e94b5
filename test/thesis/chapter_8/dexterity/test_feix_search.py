"""The search for grasps of the Feix taxonomy: starts, variables, cost."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pneuflex_sim.scene.objects import load_object
from thesis.chapter_8.dexterity import feix_search
from thesis.chapter_8.dexterity.feix import grasp_types
from thesis.chapter_8.dexterity.feix_judge import Touch
from thesis.chapter_8.dexterity.feix_search import (
    MOST_OVERLAP,
    NOT_SHAKEN,
    Moved,
    cost,
    grasp,
    lacking,
    pattern_of,
    start_values,
    starts,
    values_of,
    variables,
)
from thesis.chapter_8.dexterity.grasping import FAR, Grasped
from thesis.chapter_8.dexterity.patterns import load_patterns

TYPES = grasp_types()
THUMB = Touch("thumb", 0.0, "pad", (-1.0, 0.0, 0.0), 1.0)
INDEX = Touch("index", 0.5, "pad", (1.0, 0.0, 0.0), 1.0)
PINCH = Grasped(0.0, [THUMB, INDEX], [THUMB, INDEX], 0.002, 0.0, {"thumb": 0.0, "index": 0.0})
STILL = Moved(0.0, 0.0)


@pytest.mark.parametrize("number", sorted(TYPES))
def test_each_type_starts_with_its_object_within_the_ranges(number):
    assert starts()[number].pattern.object == TYPES[number].object
    values = start_values(number)
    for variable in variables(number):
        assert variable.low <= values[variable.name] <= variable.high
        assert variable.low < variable.high
    again, start = pattern_of(number, values), starts()[number].pattern
    assert replace(again, orientation=start.orientation) == start
    turn = Rotation.from_quat(start.orientation).inv() * Rotation.from_quat(again.orientation)
    assert turn.magnitude() < 1e-9


def test_what_turns_nothing_is_not_searched_for():
    for kind in TYPES.values():
        turns = [v.name for v in variables(kind.number) if v.name.startswith("turn")]
        expected = {"sphere": 0, "cylinder": 2}.get(load_object(kind.object).shape, 3)
        assert len(turns) == expected, kind.object


def test_values_shift_and_turn_the_object_and_choose_the_order():
    values = {**start_values(16), "y": 0.01, "turn_z": 0.2, "palm_first": 0.51}
    found, start = pattern_of(16, values), starts()[16].pattern
    assert np.subtract(found.position, start.position) == pytest.approx([0.0, 0.01, 0.0])
    turn = Rotation.from_quat(start.orientation).inv() * Rotation.from_quat(found.orientation)
    assert turn.as_rotvec() == pytest.approx([0.0, 0.0, 0.2])
    assert found.palm_first and not pattern_of(16, start_values(16)).palm_first


def test_what_holds_still_costs_nothing_and_what_drifts_costs_its_way():
    still = replace(PINCH, drift=0.0)
    assert cost(TYPES[9], still, STILL) == 0.0
    assert cost(TYPES[9], still, Moved(0.004, math.radians(6.0))) == pytest.approx(7.0)


def test_what_the_judge_would_not_take_as_held_costs_more():
    moved = Moved(0.004, 0.0)
    lost = replace(moved, held_reason="loses palm")
    assert cost(TYPES[9], PINCH, lost) > cost(TYPES[9], PINCH, moved) + 10.0


def test_what_is_lost_costs_more_the_earlier_and_more_than_a_lost_contact():
    contact = Moved(0.010, math.radians(20.0), "loses palm")
    late, early = (Moved(0.011, 0.1, "drifts by 11 mm", kept) for kept in (0.9, 0.2))
    costs = [cost(TYPES[9], PINCH, moved) for moved in (contact, late, early, NOT_SHAKEN)]
    dropped = replace(PINCH, touches=[], dropped=True)
    costs += [cost(TYPES[9], dropped, STILL)]
    assert costs == sorted(costs) and costs[1] < costs[2]


def test_values_of_a_pattern_stand_for_it():
    for number, stored in load_patterns().grasps.items():
        again, known = pattern_of(number, values_of(number, stored.pattern)), stored.pattern
        assert again.final == pytest.approx(known.final) and again.pre == pytest.approx(known.pre)
        assert again.position == pytest.approx(known.position)
        assert again.palm_first == known.palm_first
        assert abs(np.dot(again.orientation, known.orientation)) == pytest.approx(1.0)
    far = replace(stored.pattern, position=(1.0, 0.0, 0.1))
    assert values_of(number, far)["x"] == max(v.high for v in variables(number) if v.name == "x")


def test_a_draw_after_a_failure_costs_as_much_and_is_not_run(monkeypatch):
    good = {"typed": "", "held_reason": "", "dropped": False}
    seen = []

    def tried(values, settings, seed):
        seen.append(seed)
        return {1: {**good, "cost": 4.0}, 2: {**good, "cost": 40.0, "held_reason": "lost"}}[seed]

    monkeypatch.setattr(feix_search, "_tried", tried)
    found = grasp(start_values(9), {"type": 9, "draws": [1, 2, 1]})
    assert seen == [1, 2]
    assert found["cost"] == pytest.approx((4.0 + 40.0 + 40.0) / 3) and found["held_reason"]
    assert grasp(start_values(9), {"type": 9, "draws": [1, 2], "draw": 1})["cost"] == 4.0


def test_costs_rise_from_held_over_the_wrong_type_and_dropped_to_what_does_not_fit():
    wrong = replace(PINCH, touches=[INDEX])
    dropped = replace(PINCH, touches=[], dropped=True)
    at_once = replace(dropped, stayed=0.3)
    further = replace(at_once, held_out=[INDEX])
    overlaps = Grasped(MOST_OVERLAP + 0.001)
    costs = [
        cost(TYPES[9], found, pulled)
        for found, pulled in (
            (PINCH, STILL),
            (wrong, STILL),
            (dropped, STILL),
            (at_once, STILL),
            (further, STILL),
            (overlaps, STILL),
            (Grasped(2 * MOST_OVERLAP), STILL),
        )
    ]
    assert costs == sorted(costs) and len(set(costs)) == len(costs)


def test_a_finger_that_is_nearer_lacks_less():
    near, far = ({"index": gap, "thumb": 0.0} for gap in (0.005, 0.020))
    assert lacking(TYPES[9], [THUMB], near) < lacking(TYPES[9], [THUMB], far)
    assert lacking(TYPES[9], [THUMB], {}) == lacking(TYPES[9], [THUMB], {"index": FAR})


def test_all_that_the_judge_asks_for_lacks_when_it_is_missing():
    middle = replace(INDEX, part="middle")
    palm = Touch("palm", 0.0, "", (-1.0, 0.0, 0.0), 0.2)
    both = [THUMB, INDEX]
    assert lacking(TYPES[9], both, {}) == 0.0
    assert lacking(TYPES[9], [*both, middle], {}) > 0.0
    assert lacking(TYPES[9], [*both, palm], {}) > 0.0
    assert lacking(TYPES[9], [THUMB, replace(INDEX, normal=(0.0, 1.0, 0.0))], {}) > 0.0
    assert lacking(TYPES[16], both, {}) > 0.0
    assert lacking(TYPES[16], [THUMB, replace(INDEX, side="+y")], {}) == 0.0


def test_the_objective_is_a_pure_function():
    settings = {"type": 9, "segments": 5}
    first = grasp(start_values(9), settings)
    values = {**start_values(9), "z": 0.010}
    other = grasp(values, settings)
    assert grasp(start_values(9), settings) == first != other
    assert math.isfinite(first["cost"]) and math.isfinite(other["cost"])
