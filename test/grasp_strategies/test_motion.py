import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from grasp_strategies.pose import (
    IDENTITY,
    Motion,
    Pose,
    angle_between,
    duration_at_speed,
    minimum_jerk,
)

START = Pose(np.array([0.1, 0.0, 0.4]), IDENTITY)
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
