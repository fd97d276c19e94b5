"""Rotations, single ones and at many points, against matrices written out and scipy's."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from softhand_model.numerics import rotations
from softhand_model.numerics.rotations import about_x, compose, from_rpy, rotate


# ------------------------------------------------------------------ single ones
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


# ------------------------------------------------------------------ at many points
VECTORS = np.random.default_rng(3).normal(size=(3, 40)) * np.logspace(-9, 0.3, 40)


def test_exponential_is_the_rotation_at_every_size():
    found, _ = rotations.exponentials(VECTORS)
    expected = Rotation.from_rotvec(VECTORS.T).as_matrix()
    assert np.moveaxis(found, -1, 0) == pytest.approx(expected, abs=1e-14)


def test_left_jacobian_moves_the_rotation():
    random, step = np.random.default_rng(4), 1e-6
    change = random.normal(size=VECTORS.shape)
    _, jacobian = rotations.exponentials(VECTORS)
    more, less = (Rotation.from_rotvec((VECTORS + s * step * change).T) for s in (1, -1))
    expected = (more * less.inv()).as_rotvec().T / (2 * step)
    assert rotations.turned(jacobian, change) == pytest.approx(expected, abs=1e-8)


def test_series_meet_the_closed_forms():
    near = np.sqrt(rotations.SMALL_SQUARE) * np.array(
        [[1 - 1e-9, 1 + 1e-9], [0.0, 0.0], [0.0, 0.0]]
    )
    rotation, jacobian = rotations.exponentials(near)
    assert rotation[..., 0] == pytest.approx(rotation[..., 1], abs=1e-8)
    assert jacobian[..., 0] == pytest.approx(jacobian[..., 1], abs=1e-8)


def test_rotation_vectors_undo_the_exponential():
    inside = VECTORS * np.minimum(1.0, 3.1 / np.linalg.norm(VECTORS, axis=0))
    assert rotations.rotation_vectors(rotations.exponentials(inside)[0]) == pytest.approx(
        inside, rel=1e-7, abs=1e-14
    )


def test_matrices_of_quaternions_of_any_length():
    quaternion = np.random.default_rng(5).normal(size=(4, 7))
    expected = Rotation.from_quat(quaternion.T).as_matrix()
    assert np.moveaxis(rotations.matrices(quaternion), -1, 0) == pytest.approx(expected)


def test_products_and_inverses_are_those_of_numpy():
    random = np.random.default_rng(6)
    a, b, v = (random.normal(size=shape) for shape in ((3, 3, 8), (3, 3, 8), (3, 5, 8)))
    stacked = [np.moveaxis(m, -1, 0) for m in (a, b, v)]
    assert np.moveaxis(rotations.product(a, b), -1, 0) == pytest.approx(stacked[0] @ stacked[1])
    assert np.moveaxis(rotations.turned(a, v), -1, 0) == pytest.approx(stacked[0] @ stacked[2])
    assert np.moveaxis(rotations.inverse(a), -1, 0) == pytest.approx(np.linalg.inv(stacked[0]))
    back = np.einsum("jin,jn->in", a, v[:, 0])
    assert rotations.turned_back(a, v[:, 0]) == pytest.approx(back)
    crossed = np.cross(v[:, 0], v[:, 1], axis=0)
    assert rotations.cross(v[:, 0], v[:, 1]) == pytest.approx(crossed)
    assert rotations.turned(rotations.cross_matrix(v[:, 0]), v[:, 1]) == pytest.approx(crossed)
