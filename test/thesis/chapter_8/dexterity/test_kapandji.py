"""The judge of the Kapandji test, on made-up contacts."""

from dataclasses import replace

import pytest

from grasp_strategies.in_process_scene import SkinContact, SkinPlace
from thesis.chapter_8.dexterity.kapandji import TARGETS, Snapshot, judge

THUMB_END = SkinPlace("thumb", 0.080, 0.025, "back", 0.085, 0.060, 0.012)
PAD_75 = SkinPlace("little", 0.069, 0.001, "pad", 0.090, 0.070, 0.016)
SEVEN = next(target for target in TARGETS if target.number == 7)


def seen(*places, force=0.2, speed=0.01, thumb=THUMB_END):
    return Snapshot([SkinContact((thumb, place), force) for place in places], speed)


def judged(closed, later, target=SEVEN, **given):
    return judge(target, closed, later, **given)


def test_a_lasting_touch_within_the_radius_counts():
    verdict = judged(seen(PAD_75), seen(PAD_75))
    assert verdict.touched and verdict.reason == ""
    assert verdict.distance == pytest.approx(0.0018, abs=1e-4)
    assert verdict.force == pytest.approx(0.2)
    assert verdict.others == ()


def test_it_does_not_matter_which_of_the_two_stands_first():
    turned = Snapshot([SkinContact((PAD_75, THUMB_END), 0.2)], 0.01)
    assert judged(turned, turned) == judged(seen(PAD_75), seen(PAD_75))


@pytest.mark.parametrize(
    ("closed", "later", "reason"),
    [
        (seen(), seen(), "no contact"),
        (seen(PAD_75), seen(), "no contact"),
        (seen(), seen(PAD_75), "not touched when the valves closed"),
        (seen(PAD_75), seen(PAD_75, force=0.02), "force of 0.02 N"),
        (seen(PAD_75), seen(PAD_75, force=2.1), "force of 2.1 N"),
        (seen(PAD_75), seen(PAD_75, PAD_75, force=1.5), "force of 3 N"),
        (seen(PAD_75), seen(PAD_75, speed=0.06), "joints at 0.06 rad/s"),
    ],
)
def test_a_touch_that_does_not_last_or_is_too_light_or_hard_or_moves_does_not(
    closed, later, reason
):
    verdict = judged(closed, later)
    assert not verdict.touched and verdict.reason == reason


def test_two_light_points_of_one_touch_add_up():
    light = seen(PAD_75, PAD_75, force=0.03)
    assert judged(light, light).touched


@pytest.mark.parametrize(
    "place",
    [
        replace(PAD_75, along=0.0590),  # 8.5 mm short of 75 %
        replace(PAD_75, around=0.0085),  # towards the flank
        replace(PAD_75, side="back", around=0.034),  # the other side of the finger
        replace(PAD_75, chain="ring"),
    ],
)
def test_a_touch_elsewhere_does_not_count(place):
    assert not judged(seen(place), seen(place)).touched


def test_the_radius_is_that_which_is_given():
    far = seen(replace(PAD_75, along=0.0675 + 0.010))
    assert not judged(far, far).touched
    assert judged(far, far).reason == "not within the radius"
    assert judged(far, far, radius=0.012).touched
    assert not judged(far, far, radius=0.005).touched


def test_only_the_end_of_the_thumb_counts_on_any_of_its_sides():
    for side, around in (("pad", 0.0), ("back", 0.03), ("+y", 0.012), ("-y", -0.012)):
        thumb = replace(THUMB_END, side=side, around=around)
        assert judged(seen(PAD_75, thumb=thumb), seen(PAD_75, thumb=thumb)).touched
    base = replace(THUMB_END, along=0.064)
    verdict = judged(seen(PAD_75, thumb=base), seen(PAD_75, thumb=base))
    assert verdict.reason == "no contact" and verdict.others == ()


def test_other_contacts_of_the_thumb_are_allowed_and_listed():
    ring = replace(PAD_75, chain="ring")
    verdict = judged(seen(PAD_75, ring), seen(PAD_75, ring))
    assert verdict.touched and verdict.others == ("ring",)


def test_contacts_of_other_fingers_with_each_other_are_none_of_the_thumb():
    between = Snapshot([SkinContact((replace(PAD_75, chain="ring"), PAD_75), 0.3)], 0.0)
    assert judged(between, between).reason == "no contact"
    assert judged(between, between).others == ()


def test_a_tip_is_touched_from_either_face_but_not_from_far_down():
    tip = TARGETS[2]
    for around in (0.001, 0.019):
        end = SkinPlace("index", 0.088, around, "pad", 0.090, 0.040, 0.008)
        assert judged(seen(end), seen(end), target=tip).touched
    low = SkinPlace("index", 0.080, 0.0, "pad", 0.090, 0.040, 0.008)
    assert not judged(seen(low), seen(low), target=tip).touched


def test_the_radial_side_of_the_index_is_that_towards_the_thumb():
    one = TARGETS[0]
    radial = SkinPlace("index", 0.045, 0.016, "+y", 0.090, 0.070, 0.016)
    ulnar = replace(radial, around=-0.016, side="-y")
    assert judged(seen(radial), seen(radial), target=one).touched
    assert not judged(seen(ulnar), seen(ulnar), target=one).touched
