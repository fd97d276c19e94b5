"""Postures of the empty hand: pressures, order, contacts by side, and the objective of a place."""

from dataclasses import replace

import numpy as np
import pytest

from grasp_strategies.in_process_scene import SkinContact, SkinPlace, build_scene
from softhand_model.hand.hand import load_hand
from thesis.chapter_8.dexterity.kapandji import TARGETS, Snapshot, Verdict
from thesis.chapter_8.dexterity.posture import (
    FOUR,
    NOT_TOUCHED,
    RIGID,
    SEVEN,
    PosedHand,
    cost,
    first_channels,
    hand_variant,
    hold_place,
    missed,
    touch_place,
)

SETTINGS = {"place": 4, "segments": 5, "step": 0.005}


@pytest.fixture(scope="module")
def hand():
    posed = PosedHand(segments=5)
    yield posed
    posed.close()


def test_an_empty_hand_at_rest_touches_nothing_and_does_not_move(hand):
    closed, later = hand.take(np.zeros(4))
    assert not closed.contacts and not later.contacts
    assert later.speed < 1e-3


def test_channels_come_to_their_pressures_and_the_air_stays(hand):
    wanted = np.array([20e3, 30e3, 10e3, 40e3])
    closed, later = hand.take(wanted)
    assert hand.scene.simulation.pressures() == pytest.approx(wanted, rel=0.02)
    assert later.speed < closed.speed


def test_the_same_pressures_give_the_same_bit_for_bit(hand):
    wanted = np.array([50e3, 60e3, 45e3, 80e3])
    first = hand.take(wanted)[1], hand.joints()
    hand.take(np.zeros(4))
    second = hand.take(wanted)[1], hand.joints()
    assert first[0] == second[0]
    assert (first[1] == second[1]).all()


def test_neighbours_that_lie_too_close_touch_with_the_flanks_that_face_each_other():
    hand = load_hand("rbo_hand_2")
    mount = hand.chain("middle").mount
    close = replace(mount, position=(mount.position[0], 0.007, mount.position[2]))
    chains = tuple(replace(c, mount=close) if c.name == "middle" else c for c in hand.chains)
    scene = build_scene(
        hand=replace(hand, chains=chains), scene="stand", step=0.005, finger_contact=True
    )
    scene.step(0.2)
    found = [{p.chain: p.side for p in contact.places} for contact in scene.finger_contacts()]
    scene.close()
    assert {"middle": "-y", "ring": "+y"} in found
    assert all(sides == {"middle": "-y", "ring": "+y"} for sides in found)


def test_pressures_beyond_the_limits_are_refused(hand):
    with pytest.raises(ValueError, match="pressures: expected 0 to"):
        hand.take(np.array([0.0, 81e3, 0.0, 0.0]))


@pytest.mark.parametrize("thumb_first", [True, False])
def test_either_the_thumb_or_the_fingers_are_filled_first(hand, thumb_first, monkeypatch):
    simulation, given = hand.scene.simulation, []
    fill = simulation.set_air_masses
    monkeypatch.setattr(simulation, "set_air_masses", lambda m: (given.append(m.copy()), fill(m)))
    hand.take(np.array([20e3, 20e3, 20e3, 20e3]), thumb_first)
    early = given[round(0.5 / simulation.step_size)]
    assert (early > 0.3 * given[-1]).tolist() == [not thumb_first] * 2 + [thumb_first] * 2
    assert (given[-1] > 0.0).all()


def test_palm_and_thumb_are_filled_first():
    four, seven = hand_variant(FOUR), hand_variant(SEVEN)
    assert dict(zip(four.channels, first_channels(four), strict=True)) == {
        "a": False,
        "b": False,
        "c": True,
        "d": True,
    }
    first = np.array(seven.channels)[first_channels(seven)]
    assert set(first) == {"thumb", "palm_inner", "palm_outer"}
    assert len(seven.channels) == 7


def test_a_rigid_palm_does_not_carry_the_thumb_anywhere():
    moved = {}
    for name in (FOUR, RIGID):
        posed = PosedHand(name, segments=5)
        shape, last = posed.scene.simulation.shape, None
        last = shape.layout.chain_joints["palm"].stop - 1
        before = shape.frames(posed.joints())[0][last]
        posed.take(np.array([0.0, 0.0, 0.0, 120e3]))
        moved[name] = np.linalg.norm(shape.frames(posed.joints())[0][last] - before)
        posed.close()
    assert moved[FOUR] > 0.02 and moved[RIGID] < 0.001


def test_the_objective_is_a_pure_function_with_verdicts_at_all_radii():
    values = {"a": 39e3, "b": 12e3, "c": 16e3, "d": 106e3}
    first = touch_place(values, SETTINGS)
    touch_place({"c": 50e3}, SETTINGS)
    assert touch_place(values, SETTINGS) == first
    assert list(first["at_radius"]) == ["5", "8", "12"]
    assert first["touched"] == first["at_radius"]["8"]
    assert touch_place({}, SETTINGS)["reason"] == "no contact"


def test_the_gap_is_where_the_thumb_is(hand):
    hand.take(np.zeros(4))
    gaps = [hand.gap(target) for target in TARGETS]
    assert min(gaps) > 0.02
    tips = hand.scene.simulation.fingertips()
    between = np.linalg.norm(tips["thumb"][0] - tips["little"][0])
    assert gaps[5] == pytest.approx(between, abs=0.02)


def test_what_is_not_touched_costs_more_than_any_touch():
    far = cost(Verdict(True, "", 0.008, 0.2, ()), 0.0, 0.0)
    for verdict in (
        Verdict(False, "no contact", None, 0.0, ()),
        Verdict(False, "force of 3 N", 0.0, 3.0, ()),
        Verdict(False, "joints at 0.1 rad/s", 0.0, 1.0, ()),
    ):
        assert cost(verdict, 0.0, 0.1) >= NOT_TOUCHED >= far


def test_a_contact_on_the_way_to_a_place_does_not_cost_more_than_none():
    none = Verdict(False, "no contact", None, 0.0, ())
    elsewhere = Verdict(False, "not within the radius", 0.030, 0.0, ())
    beside = Verdict(False, "not within the radius", 0.012, 0.0, ())
    costs = [cost(verdict, 0.010, 0.0) for verdict in (beside, elsewhere, none)]
    assert costs == sorted(costs) and costs[0] < costs[1]
    behind = Verdict(False, "not within the radius", 0.035, 0.0, ())
    assert cost(behind, 0.010, 0.0) == cost(none, 0.010, 0.0)
    assert cost(none, 0.009, 0.0) < cost(none, 0.010, 0.0)


def test_a_draw_changes_pressures_a_little_within_the_limits_and_the_same_each_time():
    values = {"a": 60e3, "b": 80e3, "c": 40e3, "d": 60e3}  # b at its limit
    usual = touch_place(values, SETTINGS)
    first, again, other = (touch_place(values, {**SETTINGS, "draw": [1, k]}) for k in (2, 2, 3))
    assert first == again
    gaps = [found["gap"] for found in (usual, first, other)]
    assert len(set(gaps)) == 3 and np.ptp(gaps) < 0.02


@pytest.mark.parametrize(
    ("less", "more"),
    [
        ({"speed": 0.051}, {"speed": 0.06}),
        ({"speed": 0.06}, {"speed": 0.2}),
        ({"force": 2.1}, {"force": 3.0}),
        ({"force": 0.04}, {"force": 0.01}),
        ({"before": 0.010}, {"before": 0.012}),
        ({"before": 0.012}, {"before": None}),
        ({"speed": 0.06}, {"distance": 0.009}),
    ],
)
def test_what_is_missed_more_costs_more_in_a_longer_search(less, more):
    def costs(distance=0.003, before=0.003, force=0.2, speed=0.01):
        def seen(far, speed):
            end = SkinPlace("thumb", 0.080, 0.025, "back", 0.085, 0.060, 0.012)
            # a pad that is hit the given distance below 75 % of its length
            pad = SkinPlace("little", 0.75 * 0.090 - far, 0.0, "pad", 0.090, 0.070, 0.016)
            return Snapshot([SkinContact((end, pad), force)], speed)

        closed = Snapshot([], 0.01) if before is None else seen(before, 0.01)
        return missed(TARGETS[6], closed, seen(distance, speed), distance)

    assert NOT_TOUCHED < costs(**less) < costs(**more)


def test_a_touch_is_repeated_at_once_and_costs_the_radius_at_most_if_all_touch():
    values = {"a": 39e3, "b": 12e3, "c": 16e3, "d": 106e3}
    draws = [[1, 2], [1, 3]]
    none = hold_place({}, {**SETTINGS, "draws": draws})
    assert none["runs"] == 1 and none["held"] == 0 and none["cost"] > NOT_TOUCHED
    found = hold_place(values, {**SETTINGS, "draws": draws})
    alone = [touch_place(values, SETTINGS)]
    assert alone[0]["touched"]
    alone += [touch_place(values, {**SETTINGS, "draw": draw}) for draw in draws]
    assert found["runs"] == 3 and found["held"] == sum(one["touched"] for one in alone)
    assert (found["cost"] <= NOT_TOUCHED) == (found["held"] == 3)
    if found["held"] == 3:
        assert found["cost"] == pytest.approx(np.mean([one["cost"] for one in alone]))
