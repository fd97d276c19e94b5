"""Poses, and smooth motion between two of them."""

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from grasp_strategies.pose import (
    IDENTITY_QUATERNION,
    Motion,
    Pose,
    angle_between,
    duration_at_speed,
    heading,
    inverse,
    minimum_jerk,
    slerp,
)


def random_rotations(seed, count=2):
    return Rotation.random(count, np.random.default_rng(seed))


def same_rotation(first, second):
    return abs(abs(np.dot(first, second)) - 1.0) < 1e-12


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("fraction", [0.0, 0.3, 1.0])
def test_slerp_agrees_with_scipy(seed, fraction):
    ends = random_rotations(seed)
    expected = Slerp([0.0, 1.0], ends)(fraction).as_quat()
    assert same_rotation(slerp(*ends.as_quat(), fraction), expected)


def test_slerp_of_nearly_equal_rotations_stays_a_unit_quaternion_between_them():
    near = Rotation.from_rotvec([1e-6, 0.0, 0.0]).as_quat()
    half = slerp(IDENTITY_QUATERNION, near, 0.5)
    assert np.linalg.norm(half) == pytest.approx(1.0, abs=1e-15)
    assert angle_between(IDENTITY_QUATERNION, half) == pytest.approx(5e-7, rel=1e-6)


def test_slerp_takes_the_short_way_when_the_signs_differ():
    turned = Rotation.from_euler("z", 0.4).as_quat()
    assert angle_between(
        IDENTITY_QUATERNION, slerp(IDENTITY_QUATERNION, -turned, 0.5)
    ) == pytest.approx(0.2)


@pytest.mark.parametrize("seed", range(5))
def test_angle_between_is_the_magnitude_of_the_relative_rotation(seed):
    first, second = random_rotations(seed)
    expected = (first.inv() * second).magnitude()
    assert angle_between(first.as_quat(), second.as_quat()) == pytest.approx(expected)


def test_a_point_located_in_a_composed_frame_comes_back():
    rotations = random_rotations(3)
    outer = Pose(np.array([0.1, 0.2, 0.3]), rotations[0].as_quat())
    inner = Pose(np.array([-0.3, 0.0, 0.5]), rotations[1].as_quat())
    composed = outer.compose(inner)
    assert outer.locate(composed.position) == pytest.approx(inner.position, abs=1e-14)
    assert same_rotation(composed.orientation, (rotations[0] * rotations[1]).as_quat())


def test_inverse_undoes_a_rotation():
    quaternion = random_rotations(1)[0].as_quat()
    expected = Rotation.from_quat(quaternion).inv().as_quat()
    assert same_rotation(inverse(quaternion), expected)


@pytest.mark.parametrize("yaw", [-2.0, 0.3, 3.0])
@pytest.mark.parametrize("tilt", [0.0, 0.5, 1.5])
def test_heading_is_the_yaw_whatever_the_tilt_about_a_level_axis(yaw, tilt):
    rotation = Rotation.from_euler("z", yaw) * Rotation.from_rotvec([tilt * 0.6, tilt * 0.8, 0.0])
    assert same_rotation(heading(rotation.as_quat()), Rotation.from_euler("z", yaw).as_quat())


def test_heading_of_an_overturned_body_is_none():
    assert (
        heading(Rotation.from_euler("x", np.pi).as_quat()).tolist() == IDENTITY_QUATERNION.tolist()
    )


START = Pose(np.array([0.1, 0.0, 0.4]), IDENTITY_QUATERNION)
GOAL = Pose(np.array([0.1, 0.3, 0.0]), Rotation.from_euler("y", 1.2).as_quat())


def test_minimum_jerk_rests_at_both_ends():
    # the boundary conditions that define the course: position 0 and 1, no speed, no acceleration
    h = 1e-4
    for end, position in ((0.0, 0.0), (1.0, 1.0)):
        inside = abs(minimum_jerk(end + (h if end == 0 else -h)) - position)
        assert inside < 11 * h**3


def test_minimum_jerk_has_no_sixth_derivative():
    # Euler-Lagrange of least integrated squared jerk: x^(6) = 0
    samples = [minimum_jerk(s) for s in np.linspace(0.0, 1.0, 7)]
    assert np.diff(samples, 6) == pytest.approx(0.0, abs=1e-12)


def test_greatest_speed_of_a_motion_is_the_speed_asked_for():
    duration = duration_at_speed(START, GOAL, 0.25, 100.0)
    motion = Motion(START, GOAL, duration)
    times = np.linspace(0.0, duration, 2001)
    places = np.array([motion.at(t).position for t in times])
    speeds = np.linalg.norm(np.diff(places, axis=0), axis=1) / np.diff(times)
    assert speeds.max() == pytest.approx(0.25, rel=1e-5)


def test_greatest_turning_is_the_turn_speed_asked_for():
    duration = duration_at_speed(START, GOAL, 100.0, 0.5)
    motion = Motion(START, GOAL, duration)
    times = np.linspace(0.0, duration, 2001)
    turns = [motion.at(t).orientation for t in times]
    rates = [angle_between(a, b) for a, b in itertools.pairwise(turns)]
    assert max(rates) / (times[1] - times[0]) == pytest.approx(0.5, rel=1e-4)


def test_a_motion_is_straight_and_ends_at_its_goal():
    motion = Motion(START, GOAL, 2.0)
    way = GOAL.position - START.position
    for t in np.linspace(0.0, 2.0, 9):
        assert np.cross(motion.at(t).position - START.position, way) == pytest.approx(
            0.0, abs=1e-15
        )
    assert motion.at(2.0).position == pytest.approx(GOAL.position)
    assert motion.at(5.0).position == pytest.approx(GOAL.position)


def test_a_motion_without_duration_is_at_its_goal_at_once():
    assert Motion(START, GOAL, 0.0).at(0.0).position == pytest.approx(GOAL.position)
