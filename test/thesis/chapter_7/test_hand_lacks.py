"""What facts of the thesis say of the model of RBO Hand 2: geometry, bounds, what is named."""

from dataclasses import replace

import numpy as np
import pytest

from model_lab.experiments import hand_pose
from softhand_model.effects import effect_classes
from softhand_model.hand.hand import load_hand
from thesis import frame
from thesis.chapter_3_and_5.disturbance import JUDGED
from thesis.chapter_7 import static_reach
from thesis.chapter_7.candidates import IN_GRASP, IN_POSE, Candidate
from thesis.chapter_7.hand_lacks import agreeing, mending
from thesis.chapter_7.palm_cone import MARKERS, cone, own_bend
from thesis.chapter_7.sliding import misfit
from thesis.chapter_7.static_reach import StaticHand, nearest
from thesis.chapter_8.dexterity.kapandji import RADIUS, TARGETS, THUMB
from thesis.chapter_8.dexterity.posture import RIGID, PosedHand, hand_variant
from thesis.chapter_8.kapandji import MOST_RIGID

HAND = load_hand("rbo_hand_2")
MARKS = np.array(list(MARKERS.values()))
WEIGHTLESS = effect_classes()["gravity"](mass_scale=0.0)
COARSE = 5  # segments of an actuator in the small run


def test_a_cone_is_a_circle_whose_curvatures_add_as_a_right_angle():
    mount = replace(HAND.chain(THUMB).mount, position=(0.0, 0.0, 0.0))
    chains = tuple(replace(c, mount=mount) if c.name == THUMB else c for c in HAND.chains)
    bends = np.array([0.0, 0.7, 2.5])
    ends = cone(replace(HAND, chains=chains), bends)[:, 0]
    turned = np.hypot(np.pi / 2.0, bends)  # of the tangent, in the plane of the circle
    length = 0.05 * np.pi / 2.0
    chord = 2.0 * length / turned * np.sin(turned / 2.0)
    start = np.array(HAND.chain("palm").mount.position)
    assert np.linalg.norm(ends - start, axis=1) == pytest.approx(chord, abs=1e-9)


def off_the_cone(*effects):
    """Largest distance [m] of the markers from the cone at 40 kPa in all channels."""
    pressures = np.array([0.0, 40e3])
    hand = StaticHand(HAND, [WEIGHTLESS, *effects])
    seen = hand.points(THUMB, 0.0, MARKS, np.repeat(pressures[:, None], 4, axis=1))
    return np.linalg.norm(seen - cone(HAND, own_bend(HAND, pressures)), axis=2).max(axis=1)


def test_the_palm_of_the_model_is_nearly_a_cone_and_that_of_unequal_arcs_is_not():
    at_rest, bent = off_the_cone()
    assert at_rest < 1e-4
    assert bent < 1e-3
    stiff = Candidate("actuator_scatter", "modulus_factor", {"actuator": "palm_outer"}).at(1.4)
    assert off_the_cone(stiff)[1] > 5 * bent


def test_distances_at_rest_are_those_of_the_simulator():
    posed, hand = PosedHand(), StaticHand(HAND, [WEIGHTLESS])
    for target in TARGETS:
        gap = hand.gaps(target, np.zeros((1, 4)))[0]
        # the simulator takes fewer points of the skin, and has no wrong side
        assert posed.gap(target) - 3e-3 < gap
    assert hand.gaps(TARGETS[5], np.zeros((1, 4)))[0] == pytest.approx(
        posed.gap(TARGETS[5]), abs=3e-3
    )
    posed.close()


def test_a_smaller_bend_reaches_no_farther():
    hand = StaticHand(HAND)
    gaps = [nearest(hand, TARGETS[7], first=512, most_bend=b)[0] for b in (1.0, 4.0, np.inf)]
    assert gaps[0] > gaps[1] > gaps[2]
    _, pressures = nearest(hand, TARGETS[7], first=512, most_bend=1.0)
    assert hand.bends(pressures[None]).max() < 1.05


def test_more_tries_find_nothing_nearer():
    hand = StaticHand(HAND)
    few, pressures = nearest(hand, TARGETS[0])
    many, _ = nearest(hand, TARGETS[0], first=8192)
    assert few == pytest.approx(many, abs=1e-3)
    assert hand.gaps(TARGETS[0], pressures[None])[0] == pytest.approx(few)
    assert (pressures >= 0.0).all() and (pressures <= hand.limits).all()


def test_a_thumb_that_went_through_the_finger_is_farther():
    place = HAND.chain("index").mount.position
    pressures = np.zeros((1, 4))
    beside = []
    for aside in (0.03, -0.03):  # of the index, to the thumb's side and to the other
        mount = replace(HAND.chain("index").mount, position=(place[0], place[1] + aside, place[2]))
        thumb = replace(HAND.chain(THUMB), mount=HAND.chain("index").mount)
        chains = {c.name: c for c in HAND.chains} | {
            THUMB: thumb,
            "index": replace(HAND.chain("index"), mount=mount),
        }
        parts = tuple(chains[c.name] for c in HAND.chains)
        hand = StaticHand(replace(HAND, chains=parts), [WEIGHTLESS])
        beside.append(hand.gaps(TARGETS[0], pressures)[0])
    assert beside[0] > beside[1] + 0.02


def test_with_a_rigid_palm_most_places_are_out_of_reach():
    hand = StaticHand(hand_variant(RIGID))
    near = [nearest(hand, target, first=256)[0] <= RADIUS for target in TARGETS]
    assert sum(near) <= MOST_RIGID


def test_place_one_agrees_when_it_is_not_reached():
    assert agreeing([1, 2], [0.02, 0.02]) == [True, False]
    assert agreeing([1, 2], [0.002, 0.002]) == [False, True]


def predicted(*forces):
    return {f"{pressure:g}": list(forces) for pressure in (45e3, JUDGED)}


def made(base, **effects):
    told = {name: {"0.5": one, "2": predicted(0.0, 0.0, 0.0)} for name, one in effects.items()}
    return {"base": base, "other_segments": base[f"{JUDGED:g}"], "effects": told}


def test_an_effect_is_named_only_where_the_base_model_is_refuted():
    good, bad = predicted(7.0, 7.5, 6.5), predicted(2.0, 7.0, 12.0)
    assert mending(made(bad, friction=good, palm=bad)) == ["friction"]
    assert mending(made(good, friction=good)) == []


def test_no_pressure_mends_forces_that_differ_between_directions():
    forces = {40e3: np.array([1.0, 5.0]), 60e3: np.array([5.0, 9.0])}
    squares, pressure = misfit(forces, 0.0)
    assert squares == pytest.approx(8.0)  # 5 and 9 N, each 2 N from 7
    assert pressure == pytest.approx(60e3)


@pytest.mark.parametrize("candidate", [*IN_POSE, *IN_GRASP], ids=lambda one: one.label)
def test_every_candidate_is_one_of_this_hand(candidate):
    low, high = candidate.usual(2)
    assert low < high
    where = dict(candidate.where)
    assert where in effect_classes()[candidate.effect].places(HAND)


def test_small_run(check_small_run, small, monkeypatch):
    for module, segments in ((hand_pose, "HAND_SEGMENTS"), (static_reach, "SEGMENTS")):
        monkeypatch.setattr(module, segments, COARSE)
    check_small_run("hand_lacks")
    results, report = small("hand_lacks")
    assert all(report.judged)
    assert results["palm"]["verdict"] == "adequate"
    assert "pressure.a" in results["palm"]["refusal"]
    assert frame.title_of(frame.experiment("hand_lacks")).startswith("What the model")
