"""Vectors and rotations in kernels, against numpy's and scipy's."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from softhand_common.numerics import triples

VECTORS = np.random.default_rng(3).normal(size=(40, 3)) * np.logspace(-9, 0.3, 40)[:, None]


def test_rotation_is_the_exponential_at_every_size():
    found = [triples.rotation(tuple(vector)) for vector in VECTORS]
    assert np.array(found) == pytest.approx(Rotation.from_rotvec(VECTORS).as_matrix(), abs=1e-14)


def test_left_jacobian_moves_the_rotation():
    random, step = np.random.default_rng(4), 1e-6
    change = random.normal(size=VECTORS.shape)
    more, less = (Rotation.from_rotvec(VECTORS + s * step * change) for s in (1, -1))
    expected = (more * less.inv()).as_rotvec() / (2 * step)
    for vector, moved, wanted in zip(VECTORS, change, expected, strict=True):
        jacobian = np.array(triples.left_jacobian(tuple(vector)))
        assert jacobian @ moved == pytest.approx(wanted, abs=1e-8)


def test_series_meet_the_closed_forms():
    below, above = (triples.SMALL_SQUARE * (1.0 + sign * 1e-12) for sign in (-1, 1))
    near, far = triples.coefficients(below), triples.coefficients(above)
    assert near == pytest.approx(far, rel=1e-11)
    assert triples.coefficients(0.0) == (1 / 2, 1 / 6)


def test_rotation_vectors_undo_the_exponential():
    inside = VECTORS * np.minimum(1.0, 3.1 / np.linalg.norm(VECTORS, axis=1))[:, None]
    for vector in inside:
        found = triples.rotation_vector(triples.rotation(tuple(vector)))
        assert found == pytest.approx(tuple(vector), rel=1e-7, abs=1e-14)


def test_products_and_inverses_are_those_of_numpy():
    a, b = np.random.default_rng(6).normal(size=(2, 3, 3))
    rows, others = (tuple(map(tuple, m)) for m in (a, b))
    assert np.array(triples.multiply(rows, others)) == pytest.approx(a @ b)
    assert np.array(triples.apply(rows, others[0])) == pytest.approx(a @ b[0])
    assert np.array(triples.inverse(rows)) == pytest.approx(np.linalg.inv(a))
    assert np.array(triples.transposed(rows)) == pytest.approx(a.T)
    assert np.array(triples.cross(rows[0], others[0])) == pytest.approx(np.cross(a[0], b[0]))
    assert triples.dot(rows[0], others[0]) == pytest.approx(a[0] @ b[0])


def test_what_turns_about_y_follows_the_rotation():
    turn = Rotation.from_rotvec([0.3, -0.5, 0.2])
    found = triples.about_y(tuple(map(tuple, turn.as_matrix())), np.sin(0.7), np.cos(0.7))
    expected = (turn * Rotation.from_rotvec([0.0, 0.7, 0.0])).as_matrix()
    assert np.array(found) == pytest.approx(expected)


def test_points_are_read_from_the_last_axis():
    vectors, matrices = np.arange(6.0).reshape(3, 2), np.arange(18.0).reshape(3, 3, 2)
    assert triples.vector_at(vectors, 1) == tuple(vectors[:, 1])
    assert np.array(triples.matrix_at(matrices, 1)).tolist() == matrices[:, :, 1].tolist()
