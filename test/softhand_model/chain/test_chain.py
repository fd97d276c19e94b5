"""Discretised chains: shape, volume, gains, and what the palm's arcs become."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from softhand_model.chain.chain import discretise
from softhand_model.chain.segments import BEND_AXIS
from softhand_model.effects import effect_classes
from softhand_model.hand.actuator import load_actuator
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import Model, load_model

FINGER = load_hand("single_finger").chain("finger")
HAND = load_hand("rbo_hand_2")


def tip_pose(chain, rotation=None):
    """Tip (3,) and orientation in the chain's base frame, by multiplying up the joints."""
    segments = chain.segments
    rotation = np.zeros(segments.offset.shape) if rotation is None else rotation
    position, turned = np.zeros(3), Rotation.identity()
    for offset, rest, vector in zip(segments.offset, segments.rest, rotation, strict=True):
        position = position + turned.apply(offset)
        turned = turned * Rotation.from_quat(rest) * Rotation.from_rotvec(vector)
    return position + turned.apply(segments.tip_offset), turned


def test_straight_finger_ends_at_its_length():
    for segments in (1, 3, 5, 15):
        position, turned = tip_pose(discretise(FINGER, segments, Model()))
        assert position == pytest.approx([0.0, 0.0, 0.09])
        assert turned.magnitude() == pytest.approx(0.0)


def test_effects_on_the_rubber_of_a_chain_that_is_cut_are_those_of_one_cut_with_them():
    classes, palm = effect_classes(), HAND.chain("palm")
    stiffer, zone = classes["yeoh_stiffening"](c2=0.2), classes["dead_zone"](threshold=2e3)
    pressures = np.array([[5e3, 20e3, 30e3]] * len(palm.actuators))
    cut = discretise(palm, 5, Model(effects=(zone,)))
    plain = cut.rest_rotations(pressures)
    found, whole = cut.of_rubber([stiffer]), discretise(palm, 5, Model(effects=(zone, stiffer)))
    assert (found.rest_rotations(pressures) == whole.rest_rotations(pressures)).all()
    assert (found.rest_rotation([2e4, 2e4]) == whole.rest_rotation([2e4, 2e4])).all()
    assert (cut.rest_rotations(pressures) == plain).all()
    assert np.abs(found.rest_rotations(pressures) - plain).max() > 1e-3


def test_finger_on_a_strut_ends_behind_both():
    little = discretise(HAND.chain("little"), 5, Model())
    assert tip_pose(little)[0] == pytest.approx([0.0, 0.0, 0.05 + 0.09])
    assert little.segments.offset.shape == (6, 3)
    assert little.segments.offset[0] == pytest.approx([0.0, 0.0, 0.025])
    assert little.segments.stiffness[0] == pytest.approx(HAND.chain("little").strut.stiffness())


@pytest.mark.parametrize("segments", [1, 5, 12])
def test_palm_at_rest_is_a_quarter_circle(segments):
    position, turned = tip_pose(discretise(HAND.chain("palm"), segments, Model()))
    turn = HAND.chain("palm").turn
    assert position == pytest.approx([0.0, turn * 0.05, 0.05])
    assert turned.apply([0, 0, 1]) == pytest.approx([0.0, turn, 0.0], abs=1e-12)
    assert turned.apply([1, 0, 0]) == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)


def test_joints_of_the_palm_lie_on_the_arc():
    segments = discretise(HAND.chain("palm"), 5, Model()).segments
    position, turned = np.zeros(3), Rotation.identity()
    center = np.array([0.0, HAND.chain("palm").turn * 0.05, 0.0])
    for offset, rest in zip(segments.offset, segments.rest, strict=True):
        position = position + turned.apply(offset)
        turned = turned * Rotation.from_quat(rest)
        assert np.linalg.norm(position - center) == pytest.approx(0.05)


@pytest.mark.parametrize("pressure", [5e3, 31e3, 70e3])
def test_finger_bends_about_y_by_its_tip_angle(pressure):
    chain = discretise(FINGER, 6, Model())
    rotation = chain.rest_rotation([pressure])
    assert rotation[:, [0, 2]] == pytest.approx(np.zeros((6, 2)), abs=0)
    free = float(load_actuator("P10.finger").tip_angle(pressure))
    assert rotation[:, 1].sum() == pytest.approx(free, rel=1e-8)


def test_bent_finger_points_to_its_bending_side():
    chain = discretise(FINGER, 6, Model())
    position, _ = tip_pose(chain, chain.rest_rotation([10e3]))
    assert position[0] > 0.01
    assert position[1] == pytest.approx(0.0, abs=1e-15)


def test_body_lies_on_the_outer_side_of_the_neutral_layer():
    segments = discretise(FINGER, 5, Model()).segments
    assert segments.body_center[:, 0] == pytest.approx(-segments.body_size[:, 0] / 2)
    top = segments.body_center[:, 2] + segments.body_size[:, 2] / 2
    assert top[:-1] == pytest.approx(np.diff(np.cumsum(segments.offset[:, 2])))
    assert top[-1] == pytest.approx(segments.tip_offset[2])


def test_joint_stiffness_is_that_of_the_section_over_the_length():
    chain = discretise(FINGER, 5, Model())
    x = 0.018 * (np.arange(5) + 0.5)
    expected = load_actuator("P10.finger").stiffness(x) / 0.018
    for axis in range(3):
        assert chain.segments.stiffness[:, axis] == pytest.approx(expected)


def test_compliance_to_a_moment_at_the_tip_converges():
    """1/k summed over the joints against the integral of dx/B over all but the soft tip."""
    totals = []
    for segments in (9, 18, 36, 72):
        stiffness = discretise(FINGER, segments, Model()).segments.stiffness[:, 1]
        totals.append(np.sum(1.0 / stiffness[: 8 * segments // 9]))
    x = (np.arange(20000) + 0.5) * 0.08 / 20000
    exact = np.sum(0.08 / 20000 / load_actuator("P10.finger").stiffness(x))
    errors = np.abs(np.array(totals) - exact)
    assert errors[-1] / exact < 1e-3
    assert np.all(errors[:-1] / errors[1:] > 3.0)


def test_masses_add_up_to_the_rubber_beyond_the_first_joint():
    finger = load_actuator("P10.finger")
    chain = discretise(FINGER, 5, Model())
    assert chain.segments.mass.sum() == pytest.approx(finger.mass_between(0.009, 0.09))
    little, strut = discretise(HAND.chain("little"), 5, Model()), HAND.chain("little").strut
    assert little.segments.mass.sum() == pytest.approx(finger.mass + strut.mass / 2)


def test_volume_at_rest_is_chamber_and_tube():
    chain = discretise(HAND.chain("palm"), 5, Model())
    parts = HAND.chain("palm").actuators.values()
    expected = [part.chamber_volume() + part.supply_volume for part in parts]
    assert chain.volume(np.zeros(5)) == pytest.approx(expected)
    assert HAND.rest_volumes()[3] == pytest.approx(expected[1])


def test_volume_of_a_uniformly_bent_finger():
    chain, finger = discretise(FINGER, 5, Model()), load_actuator("P10.finger")
    bent = chain.volume(np.full(5, 20.0 * 0.018))
    assert bent == pytest.approx([finger.chamber_volume(20.0) + finger.supply_volume])


def test_strut_holds_no_air():
    little = discretise(HAND.chain("little"), 5, Model())
    assert little.volume_gain[0, 0] == 0.0
    assert little.rest_rotation([30e3])[0] == pytest.approx(np.zeros(3), abs=0)
    assert little.rest_tables[0].slope(30e3)[:3] == pytest.approx(np.zeros(3), abs=0)


def test_volume_of_the_palm_follows_its_bend():
    """Pure bend about the axes in the middle of the segments: V = V0 + z*h**2/2 * angle."""
    palm = discretise(HAND.chain("palm"), 5, Model())
    bend = np.array([Rotation.from_quat(axes).apply([0, 0.1, 0])[1] for axes in palm.segments.axes])
    grown = palm.volume(bend) - palm.volume(np.zeros(5))
    assert grown == pytest.approx(np.full(2, 0.025**3 / 2 * 0.5), rel=1e-9)


@pytest.mark.parametrize("name", ["index", "palm"])
def test_slopes_of_the_tables_are_those_of_the_rest_rotation(name):
    chain = discretise(HAND.chain(name), 4, Model())
    pressures, step = np.full(len(HAND.chain(name).actuators), 25e3), 1.0
    slopes = [table.slope(25e3)[BEND_AXIS::3] for table in chain.rest_tables]
    for row, shift in zip(slopes, step * np.eye(len(pressures)), strict=True):
        change = chain.rest_rotation(pressures + shift) - chain.rest_rotation(pressures - shift)
        assert row == pytest.approx(change[:, 1] / (2 * step), rel=1e-5)


def equal_bends(pressure):
    """Pressures of inner and outer arc at which both bend freely by the same angle."""
    inner, outer = HAND.chain("palm").actuators.values()
    wanted = float(inner.tip_angle(pressure))
    return pressure, brentq(lambda p: float(outer.tip_angle(p)) - wanted, 0.0, 150e3)


def test_palm_does_not_twist_where_its_arcs_bend_alike():
    palm = discretise(HAND.chain("palm"), 5, Model())
    rotation = palm.rest_rotation(equal_bends(40e3))
    own = [
        Rotation.from_quat(axes).inv().apply(vector)
        for axes, vector in zip(palm.segments.axes, rotation, strict=True)
    ]
    each = float(load_actuator("P10.PalmInner").tip_angle(40e3)) / 5
    assert np.array(own) == pytest.approx(np.tile([0.0, each, 0.0], (5, 1)), abs=1e-7)


def test_unequal_pressure_twists_the_palm_either_way():
    palm = discretise(HAND.chain("palm"), 5, Model())

    def twist(pressures):
        turned = [
            Rotation.from_quat(axes).inv().apply(vector)[2]
            for axes, vector in zip(palm.segments.axes, palm.rest_rotation(pressures), strict=True)
        ]
        return HAND.chain("palm").turn * sum(turned)

    assert twist([40e3, 10e3]) < -0.01
    assert twist([10e3, 60e3]) > 0.01


def test_palm_of_few_segments_ends_where_that_of_many_does():
    poses = []
    for segments in (5, 10, 40):
        palm = discretise(HAND.chain("palm"), segments, Model())
        poses.append(tip_pose(palm, palm.rest_rotation([30e3, 45e3])))
    finest = poses[-1]
    errors = [np.linalg.norm(position - finest[0]) for position, _ in poses[:2]]
    turns = [(turned.inv() * finest[1]).magnitude() for _, turned in poses[:2]]
    assert errors[0] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.6)
    assert turns[0] < 0.02


def test_bent_palm_moves_the_thumb_to_the_palmar_side():
    palm = discretise(HAND.chain("palm"), 5, Model())
    position, _ = tip_pose(palm, palm.rest_rotation([30e3, 30e3]))
    assert position[0] > 0.01


def test_modulus_of_the_model_scales_stiffness_and_rest():
    soft = discretise(FINGER, 5, Model(calibration={"modulus_scale": {"A": 0.5}}))
    base = discretise(FINGER, 5, Model())
    assert soft.segments.stiffness == pytest.approx(0.5 * base.segments.stiffness)
    assert soft.rest_rotation([15e3]) == pytest.approx(base.rest_rotation([30e3]), rel=1e-6)


def test_gravity_leaves_the_rest_shape_alone():
    weightless, heavy = (discretise(FINGER, 5, model) for model in (Model(), load_model("gravity")))
    straight = np.zeros((5, 3))
    assert heavy.step(1e-3, [30e3], straight) == pytest.approx(weightless.rest_rotation([30e3]))


def test_wrong_input_is_named():
    with pytest.raises(ValueError, match="segments: expected at least 1, got 0"):
        discretise(FINGER, 0, Model())
    with pytest.raises(ValueError, match="expected pneuflex for a simulated chain, got linear"):
        discretise(FINGER, 5, Model(base="linear"))


def test_single_arc_turns_like_a_pair():
    palm = HAND.chain("palm")
    alone = replace(palm, actuators={"palm_outer": palm.actuators["palm_outer"]})
    position, _ = tip_pose(discretise(alone, 5, Model()))
    assert position == pytest.approx([0.0, palm.turn * 0.0625, 0.0625])
