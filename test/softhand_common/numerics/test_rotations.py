"""Rotations by quaternions against matrices written out and scipy's."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from softhand_common.numerics.rotations import about_x, compose, from_rpy, matrices, rotate


def matrix(axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    return {
        "x": np.array([[1, 0, 0], [0, c, -s], [0, s, c]]),
        "y": np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]),
        "z": np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
    }[axis]


def test_roll_pitch_yaw_turn_about_fixed_axes_in_this_order():
    roll, pitch, yaw = 0.3, -0.7, 1.9
    whole = matrix("z", yaw) @ matrix("y", pitch) @ matrix("x", roll)
    vectors = np.eye(3)
    assert rotate(from_rpy([roll, pitch, yaw]), vectors) == pytest.approx(vectors @ whole.T)


def test_roll_pitch_yaw_become_the_same_quaternion_as_scipys():
    for rpy in np.random.default_rng(3).uniform(-4.0, 4.0, (50, 3)):
        expected = Rotation.from_euler("xyz", rpy).as_quat()
        assert from_rpy(rpy) == pytest.approx(expected, rel=0, abs=1e-15)


def test_rotation_about_x():
    assert rotate(about_x(0.4), [0, 0, 1]) == pytest.approx(matrix("x", 0.4) @ [0, 0, 1])


def test_composition_applies_the_rightmost_first():
    first, second = about_x(0.4), from_rpy([0.0, 0.9, 0.0])
    both = rotate(compose(second, first), [0.0, 1.0, 2.0])
    assert both == pytest.approx(rotate(second, rotate(first, [0.0, 1.0, 2.0])))


def test_single_and_many_quaternions_of_any_length_turn_and_compose_as_scipys():
    random = np.random.default_rng(5)
    one, many, vectors = (
        random.normal(size=4),
        random.normal(size=(7, 4)),
        random.normal(size=(5, 3)),
    )
    assert rotate(one, vectors) == pytest.approx(Rotation.from_quat(one).apply(vectors))
    product = Rotation.from_quat(one) * Rotation.from_quat(many)
    assert compose(one, many) == pytest.approx(product.as_quat())


def test_a_quaternion_of_zeros_is_refused():
    with pytest.raises(ValueError, match="not zero"):
        rotate(np.zeros(4), [1.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="not zero"):
        compose(about_x(0.1), np.zeros(4))


def test_matrices_of_quaternions_of_any_length():
    quaternion = np.random.default_rng(5).normal(size=(4, 7))
    expected = Rotation.from_quat(quaternion.T).as_matrix()
    assert np.moveaxis(matrices(quaternion), -1, 0) == pytest.approx(expected)
