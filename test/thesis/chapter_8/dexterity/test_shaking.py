"""What the wrist does to try a grasp."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from grasp_strategies.pose import IDENTITY_QUATERNION, Pose, angle_between
from thesis.chapter_8.dexterity.shaking import GRAVITY, motions

UPRIGHT = Pose(np.array([0.0, 0.0, 0.3]), IDENTITY_QUATERNION)
SHAKES, SWINGS = slice(-6, -3), slice(-3, None)


def test_each_motion_begins_where_the_last_one_ended_and_all_end_upright():
    last = UPRIGHT
    for _, pose in motions(UPRIGHT):
        first = pose(0.0)
        assert first.position == pytest.approx(last.position)
        assert angle_between(first.orientation, last.orientation) < 1e-6
        last = pose(1.0)
    assert last.position == pytest.approx(UPRIGHT.position)
    assert angle_between(last.orientation, UPRIGHT.orientation) < 1e-6


def test_gravity_comes_from_six_directions_of_the_hand():
    still = [pose(1.0) for _, pose in motions(UPRIGHT)[1:12:2]]
    down = [Rotation.from_quat(p.orientation).inv().apply([0.0, 0.0, -1.0]) for p in still]
    np.testing.assert_allclose(down, GRAVITY, atol=1e-9)
    assert {tuple(direction) for direction in GRAVITY} == {
        tuple(sign * axis) for axis in np.eye(3, dtype=int) for sign in (1, -1)
    }


@pytest.mark.parametrize("strength", [1.0, 0.5])
def test_it_is_shaken_by_30_mm_and_swings_by_45_deg_along_and_about_each_axis(strength):
    shares = np.linspace(0.0, 1.0, 41)
    for axis, (duration, pose) in enumerate(motions(UPRIGHT, strength)[SHAKES]):
        way = np.array([pose(s).position - UPRIGHT.position for s in shares])
        assert duration == 1.0 and np.ptp(way[:, axis]) == pytest.approx(0.060 * strength)
        assert np.abs(np.delete(way, axis, axis=1)).max() == 0.0
    for _, pose in motions(UPRIGHT, strength)[SWINGS]:
        angles = [angle_between(pose(s).orientation, IDENTITY_QUATERNION) for s in shares]
        assert np.degrees(max(angles)) == pytest.approx(45.0 * strength)
