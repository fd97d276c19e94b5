"""Series of the rollout against closed forms."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from softhand_model.dynamics.rollout import SERIES_ANGLE, SERIES_TANGENT, error_from, turn_of

LARGEST = 2.0 * np.arctan(SERIES_TANGENT)  # [rad] of an error that a series gives


@pytest.mark.parametrize(
    "angle", [0.0, 1e-9, 0.01, 0.999 * SERIES_ANGLE, 1.001 * SERIES_ANGLE, 2.0]
)
def test_a_turn_is_exact_to_the_last_digits(angle):
    vector = angle * np.array([0.6, 0.0, -0.8])
    half = 0.5 * angle
    exact = [*(np.sin(half) * np.array([0.6, 0.0, -0.8])), np.cos(half)]
    np.testing.assert_allclose(turn_of(vector), exact, rtol=1e-15, atol=1e-24)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.01, 0.999 * LARGEST, 1.001 * LARGEST, 3.0])
def test_an_error_is_exact_to_the_last_digits(angle):
    vector = angle * np.array([0.6, 0.0, -0.8])
    reference = Rotation.random(random_state=4)
    turned = (reference * Rotation.from_rotvec(vector)).as_quat()
    for sign in (1.0, -1.0):  # both quaternions of one orientation
        found = error_from(reference.as_quat(), sign * turned)
        np.testing.assert_allclose(found, vector, atol=1e-15)
