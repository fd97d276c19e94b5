"""Rotations at many points against scipy's, and derivatives against differences."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from softhand_model.numerics import rotations as fields

VECTORS = np.random.default_rng(3).normal(size=(3, 40)) * np.logspace(-9, 0.3, 40)


def test_exponential_is_the_rotation_at_every_size():
    found, _ = fields.exponentials(VECTORS)
    expected = Rotation.from_rotvec(VECTORS.T).as_matrix()
    assert np.moveaxis(found, -1, 0) == pytest.approx(expected, abs=1e-14)


def test_left_jacobian_moves_the_rotation():
    random, step = np.random.default_rng(4), 1e-6
    change = random.normal(size=VECTORS.shape)
    _, jacobian = fields.exponentials(VECTORS)
    more, less = (Rotation.from_rotvec((VECTORS + s * step * change).T) for s in (1, -1))
    expected = (more * less.inv()).as_rotvec().T / (2 * step)
    assert fields.turned(jacobian, change) == pytest.approx(expected, abs=1e-8)


def test_series_meet_the_closed_forms():
    near = np.sqrt(fields.SMALL_SQUARE) * np.array([[1 - 1e-9, 1 + 1e-9], [0.0, 0.0], [0.0, 0.0]])
    rotation, jacobian = fields.exponentials(near)
    assert rotation[..., 0] == pytest.approx(rotation[..., 1], abs=1e-8)
    assert jacobian[..., 0] == pytest.approx(jacobian[..., 1], abs=1e-8)


def test_rotation_vectors_undo_the_exponential():
    inside = VECTORS * np.minimum(1.0, 3.1 / np.linalg.norm(VECTORS, axis=0))
    assert fields.rotation_vectors(fields.exponentials(inside)[0]) == pytest.approx(
        inside, rel=1e-7, abs=1e-14
    )


def test_matrices_of_quaternions_of_any_length():
    quaternion = np.random.default_rng(5).normal(size=(4, 7))
    expected = Rotation.from_quat(quaternion.T).as_matrix()
    assert np.moveaxis(fields.matrices(quaternion), -1, 0) == pytest.approx(expected)


def test_products_and_inverses_are_those_of_numpy():
    random = np.random.default_rng(6)
    a, b, v = (random.normal(size=shape) for shape in ((3, 3, 8), (3, 3, 8), (3, 5, 8)))
    stacked = [np.moveaxis(m, -1, 0) for m in (a, b, v)]
    assert np.moveaxis(fields.product(a, b), -1, 0) == pytest.approx(stacked[0] @ stacked[1])
    assert np.moveaxis(fields.turned(a, v), -1, 0) == pytest.approx(stacked[0] @ stacked[2])
    assert np.moveaxis(fields.inverse(a), -1, 0) == pytest.approx(np.linalg.inv(stacked[0]))
    back = np.einsum("jin,jn->in", a, v[:, 0])
    assert fields.turned_back(a, v[:, 0]) == pytest.approx(back)
    crossed = np.cross(v[:, 0], v[:, 1], axis=0)
    assert fields.cross(v[:, 0], v[:, 1]) == pytest.approx(crossed)
    assert fields.turned(fields.cross_matrix(v[:, 0]), v[:, 1]) == pytest.approx(crossed)
