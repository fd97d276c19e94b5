"""Rotations of the compiled kernels against scipy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pneuflex_sim import spatial


@pytest.fixture
def pair():
    return Rotation.random(2, random_state=4)


def test_matrix_and_product_agree_with_scipy(pair):
    matrix, product = np.empty((3, 3)), np.empty(4)
    spatial.rotation_matrix(pair[0].as_quat(), matrix)
    np.testing.assert_allclose(matrix, pair[0].as_matrix(), atol=1e-14)
    spatial.quaternion_product(pair[0].as_quat(), pair[1].as_quat(), product)
    assert abs(product @ (pair[0] * pair[1]).as_quat()) == pytest.approx(1, abs=1e-14)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 1.0, 3.1])
def test_rotation_vector_and_quaternion_are_inverse(angle, pair):
    vector, quaternion, back = angle * np.array([0.6, 0.0, -0.8]), np.empty(4), np.empty(3)
    spatial.quaternion_of_rotation(vector, quaternion)
    reference = pair[0].as_quat()
    turned = (pair[0] * Rotation.from_quat(quaternion)).as_quat()
    for sign in (1, -1):  # both quaternions of one orientation
        spatial.rotation_between(reference, sign * turned, back)
        np.testing.assert_allclose(back, vector, atol=1e-12)


def test_symmetric_inverse():
    root = np.random.default_rng(1).normal(size=(3, 3))
    matrix, inverse = root @ root.T + np.eye(3), np.empty((3, 3))
    spatial.invert_symmetric(matrix, inverse)
    np.testing.assert_allclose(inverse @ matrix, np.eye(3), atol=1e-13)
