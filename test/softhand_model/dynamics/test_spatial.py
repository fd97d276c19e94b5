"""Rotations of the compiled kernels against scipy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from softhand_model.dynamics import spatial


@pytest.fixture
def pair():
    return Rotation.random(2, random_state=4)


def test_matrix_and_product_agree_with_scipy(pair):
    matrix = spatial.rotation_matrix(pair[0].as_quat())
    np.testing.assert_allclose(matrix, pair[0].as_matrix(), atol=1e-14)
    product = np.array(spatial.quaternion_product(pair[0].as_quat(), pair[1].as_quat()))
    assert abs(product @ (pair[0] * pair[1]).as_quat()) == pytest.approx(1, abs=1e-14)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 1.0, 3.1])
def test_rotation_vector_and_quaternion_are_inverse(angle, pair):
    vector = angle * np.array([0.6, 0.0, -0.8])
    quaternion = spatial.quaternion_of_rotation(vector)
    reference = pair[0].as_quat()
    turned = (pair[0] * Rotation.from_quat(quaternion)).as_quat()
    for sign in (1, -1):  # both quaternions of one orientation
        back = spatial.rotation_between(reference, sign * turned)
        np.testing.assert_allclose(back, vector, atol=1e-12)


def test_symmetric_inverse():
    root = np.random.default_rng(1).normal(size=(3, 3))
    matrix = root @ root.T + np.eye(3)
    inverse = np.array(spatial.invert_symmetric(spatial.rows(matrix)))
    np.testing.assert_allclose(inverse @ matrix, np.eye(3), atol=1e-13)
