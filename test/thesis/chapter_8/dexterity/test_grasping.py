"""Grasps of an object that is held out, in the simulation."""

from dataclasses import replace

import numpy as np
import pytest

from thesis.chapter_8.dexterity.feix import THUMB, grasp_types
from thesis.chapter_8.dexterity.feix_judge import MOST_DRIFT, judge_held, judge_type, shares
from thesis.chapter_8.dexterity.feix_search import pattern_of, start_values
from thesis.chapter_8.dexterity.feix_trials import HandSettings, PatternTrial, fresh_trials
from thesis.chapter_8.dexterity.grasping import (
    UNTURNED,
    Draw,
    GraspingHand,
    drawn,
    grasping,
    grasping_hand,
)
from thesis.chapter_8.dexterity.patterns import (
    Patterns,
    StoredGrasp,
    Times,
    load_patterns,
    write_patterns,
)

WRAP, SEGMENTS = pattern_of(3, start_values(3)), 5
OBJECT = WRAP.object


@pytest.fixture(scope="module")
def hand():
    found = GraspingHand(OBJECT, segments=SEGMENTS)
    yield found
    found.close()


@pytest.fixture(scope="module")
def wrapped(hand):
    return hand.grasp(WRAP, Times())


def test_fingers_wrap_a_cylinder_that_is_held_out_to_them(wrapped):
    assert not wrapped.dropped and wrapped.overlap <= 0.0
    assert wrapped.drift < 0.02 and wrapped.stayed == 1.0
    assert judge_type(grasp_types()[3], wrapped.touches).good
    assert all(np.linalg.norm(t.normal) == pytest.approx(1.0) for t in wrapped.touches)
    assert min(wrapped.gaps.values()) < 0.001


def test_what_is_held_stays_when_it_is_pulled_and_leaves_when_pulled_hard(hand):
    hand.grasp(WRAP, Times())
    assert hand.pull()[0] < 0.010
    assert 0.5 < hand.robust() < 20.0


def test_shaking_ends_when_the_object_is_lost_and_tells_when(hand):
    slippery = Draw(friction_scale=0.05)
    assert not hand.grasp(WRAP, Times(), slippery).dropped
    begin = hand.simulation.time
    lost = hand.shaken(until_lost=True)
    took = hand.simulation.time - begin
    assert 0.0 < lost.kept < 1.0 and not judge_held(lost).good
    assert took < 25.0 * lost.kept and lost.drift < 2.0 * MOST_DRIFT


def test_without_fingers_it_is_dropped(hand):
    open_hand = replace(WRAP, final=dict.fromkeys(WRAP.final, 0.0))
    found = hand.grasp(open_hand, Times())
    assert found.dropped and not found.touches and 0.0 < found.stayed < 0.9


def test_an_object_that_does_not_fit_is_not_grasped(hand):
    inside = replace(WRAP, position=(0.0, 0.0, 0.150))
    found = hand.grasp(inside, Times(), most_overlap=0.005)
    assert found.overlap > 0.005 and not found.touches


def test_palm_first_closes_the_thumb_before_the_fingers(hand):
    """The last channels to move are those of the fingers."""
    masses = []
    step = hand.simulation.set_air_masses
    hand.simulation.set_air_masses = lambda m: (masses.append(m.copy()), step(m))
    hand.grasp(replace(WRAP, palm_first=True), Times())
    hand.simulation.set_air_masses = step
    half = np.array(masses)[-round(Times().grasp / hand.simulation.step_size) - 1]
    final = np.array([WRAP.final[name] for name in "abcd"])
    assert half[2:] == pytest.approx(final[2:]) and (half[:2] < 0.5 * final[:2]).all()


def test_without_the_object_the_hand_closes_further(hand, wrapped):
    hand.grasp(WRAP, Times())
    around = hand.simulation.tip_angles()["index"]
    hand.pose_only(WRAP, Times())
    assert hand.simulation.tip_angles()["index"] > around + 0.1
    assert not hand.look()


def test_a_stored_grasp_is_the_same_bit_for_bit_in_another_simulation(tmp_path):
    settings = HandSettings(OBJECT, segments=SEGMENTS)
    (trial,) = fresh_trials("case", 3, WRAP, Times(), settings, 7, 1)
    quick = replace(trial, draw=replace(trial.draw, friction_scale=1e-6), robust=False)
    first = quick.result()
    stored = StoredGrasp(WRAP, 7, "case_3/0000", 1.0, 1, 1, 0.0, (first,))
    path = tmp_path / "patterns.yaml"
    write_patterns(Patterns("rbo_hand_2", 0.005, SEGMENTS, Times(), {3: stored}), path)
    grasping.cache_clear()
    again = replace(quick, pattern=load_patterns(path).grasps[3].pattern, key="again/3/1")
    assert again.result() == first
    assert not first["held"] and first["held_reason"]  # there is no friction
    assert load_patterns(path).grasps[3].trials == (first,)
    assert again.digest == quick.digest


def test_a_run_that_diverges_has_failed(monkeypatch):
    def diverge(*_args, **_more):
        raise RuntimeError("the simulation diverged")

    monkeypatch.setattr(GraspingHand, "grasp", diverge)
    settings = HandSettings(OBJECT, segments=SEGMENTS)
    found = PatternTrial("k", 3, WRAP, Times(), Draw(), 1.0, False, settings).result()
    assert not found["held"] and not found["typed"] and "diverged" in found["held_reason"]


def test_draws_differ_and_stay_within_their_bounds():
    draws = [drawn((1, 2, trial)) for trial in range(50)]
    assert drawn((1, 2, 0)) == draws[0] and len(set(draws)) == 50
    assert np.abs([draw.shift for draw in draws]).max() <= 0.001
    assert np.degrees(np.abs([draw.turn for draw in draws]).max()) <= 2.0
    for name, spread in (("mass_scale", 0.05), ("friction_scale", 0.15), ("modulus_scale", 0.05)):
        scales = np.array([getattr(draw, name) for draw in draws])
        assert np.abs(scales - 1.0).max() <= spread < 1.1 * np.abs(scales - 1.0).max()


def test_a_draw_has_an_opposite_one():
    one, other = drawn((3014, 2)), drawn((3014, -2))
    assert np.add(one.shift, other.shift) == pytest.approx(np.zeros(3))
    assert np.add(one.turn, other.turn) == pytest.approx(np.zeros(3))
    assert one.friction_scale + other.friction_scale == pytest.approx(2.0)
    assert one.modulus_scale + other.modulus_scale == pytest.approx(2.0)
    assert one.mass_scale != 1.0 and drawn((3014, 1)) not in (one, other)


def test_the_unturned_thumb_lies_along_the_palm():
    assert grasping_hand(UNTURNED).chain(THUMB).mount.rpy[2] == 0.0
    assert grasping_hand("four_channels").chain(THUMB).mount.rpy[2] != 0.0


def test_a_hand_of_third_settings_takes_the_place_of_the_oldest_one():
    grasping.cache_clear()
    worlds = [
        grasping(name, "four_channels", 0.005, 1).simulation.engine.world
        for name in ("bead", "pen", "card")
    ]
    assert [world.closed for world in worlds] == [True, False, False]
    assert grasping("pen", "four_channels", 0.005, 1).simulation.engine.world is worlds[1]


def test_shares_of_nothing_are_none():
    assert shares([], lambda touch: touch.part)["palm"] == 0.0
