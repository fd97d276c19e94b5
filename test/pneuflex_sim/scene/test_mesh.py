"""Normals of meshes as they are drawn: sharp at creases, smooth on round sides."""

import numpy as np
import pytest

from pneuflex_sim.scene.mesh import creased, mesh_of, tube

RING = 24  # corners of a round prism, 15 deg apart


@pytest.fixture
def prism():
    around = 2.0 * np.pi * np.arange(RING) / RING
    circle = np.column_stack([np.cos(around), np.sin(around)])
    return tube(np.array([np.column_stack([circle, np.full(RING, z)]) for z in (0.0, 1.0)]))


def test_a_round_prism_has_flat_ends_and_a_smooth_side(prism):
    found = creased(prism)
    level = np.abs(found.normals[:, 2]) > 0.5
    np.testing.assert_allclose(np.abs(found.normals[level]), [[0.0, 0.0, 1.0]] * level.sum())
    side = found.vertices[~level, :2]
    # the sum over unequal shares of both neighbours leans to one of them, by less than their 15 deg
    along = np.einsum("ij,ij->i", found.normals[~level, :2], side)
    assert along.min() > np.cos(np.radians(7.5))
    assert len(side) == 2 * RING  # each corner of both rings once: neighbours share their normal
    assert found.volume == pytest.approx(prism.volume)


def test_every_edge_is_sharp_beyond_the_angle(prism):
    found = creased(prism, np.radians(10.0))
    corners = found.corners
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat /= np.linalg.norm(flat, axis=1)[:, None]
    shown = found.normals[found.indices].reshape(-1, 3, 3)
    np.testing.assert_allclose(shown, np.repeat(flat[:, None], 3, axis=1), atol=1e-12)


def test_an_open_mesh_keeps_its_faces():
    square = mesh_of(
        np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([0, 1, 2, 0, 2, 3])
    )
    np.testing.assert_allclose(creased(square).corners, square.corners)
