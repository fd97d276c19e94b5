"""Statics of thumb and fingers without contact, against the simulation at rest."""

import numpy as np
import pytest

from thesis.chapter_8.dexterity.kapandji import TARGETS
from thesis.chapter_8.dexterity.posture import FOUR, SEVEN, PosedHand, hand_variant
from thesis.chapter_8.dexterity.reach import APART, StaticReach

TWO, FOURTH = TARGETS[1], TARGETS[3]
SEGMENTS = 5


@pytest.fixture(scope="module")
def reach():
    return StaticReach(hand_variant(FOUR), SEGMENTS)


def test_a_posture_without_contact_is_that_of_the_simulation(reach):
    hand = PosedHand(segments=SEGMENTS)
    pressures = np.array([30e3, 40e3, 20e3, 60e3])
    _, later = hand.take(pressures)
    assert not later.contacts
    shape = hand.scene.simulation.shape
    places, frames, _ = shape.frames(hand.joints())
    posed = reach.posed(pressures[None])
    assert np.abs(posed.places[0] - places).max() < 1e-4
    assert np.abs(posed.frames[0] - frames).max() < 1e-3
    assert reach.distance(FOURTH, pressures) == pytest.approx(hand.gap(FOURTH), abs=1e-4)
    hand.close()


def test_starting_points_are_the_nearest_first_and_differ(reach):
    limits = hand_variant(FOUR).max_pressures()
    found = reach.starts(TWO, 6)
    distances = [one.distance for one in found]
    assert distances == sorted(distances) and len(found) == 6
    for number, one in enumerate(found):
        assert reach.distance(TWO, one.pressures) == pytest.approx(one.distance)
        for other in found[:number]:
            assert np.abs((one.pressures - other.pressures) / limits).max() >= APART
        assert one.pressures[0] == 0.0  # the fingers beside the index


def test_no_random_posture_is_nearer_than_the_nearest(reach):
    nearest = reach.nearest(TWO)
    assert nearest.distance <= reach.starts(TWO, 1)[0].distance
    shares = np.random.default_rng(5).uniform(size=(50, 4))
    least = min(reach.distance(TWO, share * hand_variant(FOUR).max_pressures()) for share in shares)
    assert nearest.distance <= least


def test_more_channels_reach_no_less(reach):
    seven = StaticReach(hand_variant(SEVEN), SEGMENTS)
    assert seven.nearest(TARGETS[0]).distance < reach.nearest(TARGETS[0]).distance


def test_a_channel_that_stays_empty_is_not_used():
    without = StaticReach(hand_variant(FOUR), SEGMENTS, ("b",))
    assert without.nearest(TWO).distance > 0.03
    assert all(one.pressures[1] == 0.0 for one in without.starts(TWO, 3))


def test_a_thumb_that_lies_within_a_finger_is_farther_by_the_overlap(reach):
    fingers = reach.posed(np.zeros((1, 4)))
    mark = fingers.points(*reach._skin.middle(TWO.finger, TWO.share, TWO.side))
    centers, radii = reach._balls(fingers, ["index"])
    for place, more in ((centers[:, 3:4], radii[3] + 0.005), (centers[:, 3:4] + 1.0, 0.0)):
        found = reach._distances(TWO, fingers, mark, (place, np.array([0.005])))
        assert found[0, 0] == pytest.approx(more)
    assert 0.003 < radii[3] < 0.02
