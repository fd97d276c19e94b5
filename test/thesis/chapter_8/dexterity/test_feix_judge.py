"""The judge of the grasps of the Feix taxonomy, on made-up contacts and courses."""

import math
from dataclasses import replace

import pytest

from thesis.chapter_8.dexterity.feix import grasp_types
from thesis.chapter_8.dexterity.feix_judge import (
    Shaken,
    Touch,
    judge_held,
    judge_type,
    opposition,
    regions,
)

FORWARD, BACKWARD = (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)
PALM = Touch("palm", 0.0, "", BACKWARD, 4.0)
THUMB = Touch("thumb", 0.0, "pad", BACKWARD, 1.0)
INDEX = Touch("index", 0.5, "pad", FORWARD, 1.0)
MIDDLE, RING, LITTLE = (replace(INDEX, part=part) for part in ("middle", "ring", "little"))
WRAP = [PALM, INDEX, MIDDLE, RING, LITTLE]
PINCH = [THUMB, INDEX]
SIDE = replace(INDEX, side="+y")


def at(degrees, touch=INDEX):
    """A contact whose normal is at this angle against that of the palm and the thumb."""
    angle = math.radians(180.0 - degrees)
    return replace(touch, normal=(math.cos(angle), math.sin(angle), 0.0))


def shaken(before=WRAP, after=WRAP, drift=0.0, turn=0.0):
    return Shaken(before, after, drift, turn)


def typed(number, *touches):
    return judge_type(grasp_types()[number], touches)


# ---------------------------------------------------------------- held
def test_what_does_not_move_is_held():
    assert judge_held(shaken()).good
    assert judge_held(shaken()).reason == ""


@pytest.mark.parametrize(
    ("seen", "reason"),
    [
        (shaken(before=[], after=[]), "nothing touches the object"),
        (shaken(drift=0.01001), "drifts by 10 mm"),
        (shaken(turn=math.radians(20.1)), "turns by 20 deg"),
        (shaken(after=[PALM, INDEX, MIDDLE, RING]), "loses little's middle third"),
        (shaken(after=[]), "loses index's middle third, little's middle third"),
        (shaken(after=[*WRAP[:4], replace(LITTLE, along=0.9)]), "loses little's middle third"),
        (shaken(after=[INDEX, MIDDLE, RING, LITTLE]), "loses palm"),
    ],
)
def test_what_moves_or_loses_contacts_is_not_held(seen, reason):
    verdict = judge_held(seen)
    assert not verdict.good and reason in verdict.reason


def test_what_yields_and_springs_back_is_held_by_what_is_left_alone():
    seen = replace(shaken(turn=0.6), left=(0.001, 0.1))
    assert not judge_held(seen).good and judge_held(seen.at_rest).good
    assert not judge_held(replace(seen, left=(0.001, 0.5)).at_rest).good
    assert not judge_held(replace(seen, after=[]).at_rest).good
    assert not judge_held(shaken(drift=0.1).at_rest).good, "lost on the way"


def test_a_contact_may_pass_the_border_of_its_third_by_the_resolution_of_its_place():
    near, far = (replace(LITTLE, along=2.0 / 3.0 + past) for past in (0.16, 0.17))
    assert judge_held(shaken(after=[*WRAP[:4], near])).good
    assert not judge_held(shaken(after=[*WRAP[:4], near]), resolution=0.0).good
    assert not judge_held(shaken(after=[*WRAP[:4], far])).good


def test_just_within_the_limits_is_held():
    assert judge_held(shaken(drift=0.00999, turn=math.radians(19.9))).good


def test_a_light_touch_need_not_stay_and_new_ones_may_come():
    light = replace(LITTLE, force=0.049 * 7.0 / 0.951)  # 4.9 % of all
    assert judge_held(shaken([*WRAP[:4], light], WRAP[:4])).good
    firm = replace(LITTLE, force=0.051 * 7.0 / 0.949)
    assert not judge_held(shaken([*WRAP[:4], firm], WRAP[:4])).good
    assert judge_held(shaken(WRAP[:4], [*WRAP, THUMB])).good


def test_points_of_one_region_add_up():
    parts = [replace(INDEX, force=0.3), replace(INDEX, force=0.7, side="+y"), PALM]
    assert regions(parts, 0.19) == {("index", 1), ("palm", 0)}


# ---------------------------------------------------------------- type
def test_fingers_against_the_palm_are_a_power_grasp_with_or_without_the_thumb():
    assert typed(3, *WRAP).good
    assert typed(3, *WRAP, THUMB).good


@pytest.mark.parametrize(
    ("number", "touches", "reason"),
    [
        (3, WRAP[1:], "not touched by palm"),
        (3, WRAP[:4], "not touched by little"),
        (9, [*PINCH, PALM], "touched by the palm"),
        (9, [*PINCH, replace(MIDDLE, force=0.51)], "middle carries 20 %"),
        (9, [INDEX], "not touched by thumb"),
        (17, [*WRAP, replace(INDEX, force=1.0)], "index carries 25 %"),
        (9, [THUMB, at(119.9)], "virtual fingers at 120 deg"),
        (9, [THUMB, at(60.0)], "virtual fingers at 60 deg"),
        (16, PINCH, "index not with its side"),
        (3, [], "not touched by"),
    ],
)
def test_the_wrong_parts_are_said(number, touches, reason):
    if number == 17:
        touches = [PALM, MIDDLE, RING, LITTLE, replace(INDEX, force=7.0 / 3.0)]
    verdict = typed(number, *touches)
    assert not verdict.good and reason in verdict.reason


def test_opposition_counts_from_120_deg_on():
    assert typed(9, THUMB, at(120.1)).good
    assert opposition(grasp_types()[9], [THUMB, at(150.0)]) == pytest.approx(math.radians(150.0))


def test_normals_are_weighted_by_their_forces():
    strong, weak = replace(at(170.0), force=9.0), at(80.0)
    assert opposition(grasp_types()[9], [THUMB, strong, weak]) > math.radians(150.0)


def test_an_excluded_finger_may_help_a_little():
    assert typed(9, *PINCH, replace(MIDDLE, force=0.49)).good


def test_a_trace_of_the_palm_is_no_touch():
    assert typed(9, *PINCH, replace(PALM, force=0.02)).good
    assert not typed(9, *PINCH, replace(PALM, force=0.021)).good


def test_most_of_the_force_has_to_be_on_the_flank_in_side_types():
    flat = replace(INDEX, force=0.9)
    assert typed(16, THUMB, SIDE, flat).good
    assert not typed(16, THUMB, SIDE, replace(flat, force=1.1)).good
    assert typed(16, THUMB, replace(SIDE, side="-y")).good
    assert not typed(16, THUMB, replace(SIDE, side="back")).good


def test_adduction_is_between_the_flanks_of_two_fingers_without_the_thumb():
    index = replace(INDEX, side="-y", normal=(0.0, 1.0, 0.0))
    middle = replace(MIDDLE, side="+y", normal=(0.0, -1.0, 0.0))
    assert typed(23, index, middle).good
    assert not typed(23, index, replace(middle, side="pad")).good
    assert not typed(23, index, middle, THUMB).good


def test_held_and_type_do_not_depend_on_each_other():
    assert judge_held(shaken(PINCH, PINCH)).good and not typed(3, *PINCH).good
    assert typed(3, *WRAP).good and not judge_held(shaken(drift=0.02)).good
