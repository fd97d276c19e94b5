"""Convex pieces of a torus: they fill it, leave its hole open, come from the cache, repeat."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull, Delaunay

from pneuflex_sim.scene import solids as module
from pneuflex_sim.scene.mesh import box, mesh_of
from pneuflex_sim.scene.solids import cache_file, convex_pieces, eroded

RING, TUBE = 0.03, 0.012
QUICK = module.SETTINGS | {"mcts_iterations": 20, "resolution": 500}  # a search that is less long


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    """A cache that no other test sees."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))


@pytest.fixture(scope="module")
def torus():
    """A coarse torus about z."""
    around, across = 14, 8
    vertices, faces = [], []
    for i in range(around):
        for j in range(across):
            u, v = 2 * np.pi * i / around, 2 * np.pi * j / across
            radius = RING + TUBE * np.cos(v)
            vertices.append([radius * np.cos(u), radius * np.sin(u), TUBE * np.sin(v)])
            a, b = i * across + j, (i + 1) % around * across + j
            c, d = (i + 1) % around * across + (j + 1) % across, i * across + (j + 1) % across
            faces += [(a, b, c), (a, c, d)]
    return mesh_of(np.array(vertices), np.array(faces, np.int32).ravel())


def test_the_pieces_fill_a_torus_leave_its_hole_and_are_kept(torus, monkeypatch):
    pytest.importorskip("coacd")
    monkeypatch.setattr(module, "SETTINGS", QUICK)
    pieces = convex_pieces(torus)
    volume = sum(ConvexHull(piece).volume for piece in pieces)
    assert torus.volume * 0.98 < volume < torus.volume * 1.15
    ring = 2 * np.pi * np.arange(36) / 36
    for radius, inside in ((RING, True), (0.5 * (RING - TUBE), False)):
        points = np.stack([radius * np.cos(ring), radius * np.sin(ring), 0 * ring], axis=1)
        found = np.any([Delaunay(piece).find_simplex(points) >= 0 for piece in pieces], axis=0)
        assert found.mean() > 0.9 if inside else not found.any()
    monkeypatch.setattr(module, "_decomposed", None)  # cannot be called: the pieces are kept
    for one, other in zip(pieces, convex_pieces(torus), strict=True):
        np.testing.assert_array_equal(one, other)


def test_another_mesh_or_setting_has_another_cache(torus, monkeypatch):
    pytest.importorskip("coacd")
    first = cache_file(torus)
    assert cache_file(mesh_of(1.001 * torus.vertices, torus.indices)) != first
    monkeypatch.setitem(module.SETTINGS, "threshold", 0.1)
    assert cache_file(torus) != first


def test_a_convex_mesh_is_its_own_piece_without_the_library(monkeypatch):
    monkeypatch.setattr(module, "_decomposed", None)
    (piece,) = convex_pieces(box((0.02, 0.03, 0.04), np.zeros(3)))
    assert ConvexHull(piece).volume == pytest.approx(0.02 * 0.03 * 0.04)


def test_without_the_library_a_hollow_mesh_is_refused_with_what_to_do(torus, monkeypatch):
    def missing(_):
        raise module.metadata.PackageNotFoundError

    monkeypatch.setattr(module.metadata, "version", missing)
    with pytest.raises(ValueError, match="pip install coacd.*pieces: hull"):
        convex_pieces(torus)


def test_erosion_moves_every_face_by_the_margin():
    corners = np.array([[0, 0, 0], [0.05, 0, 0], [0, 0.06, 0], [0, 0, 0.07]])
    inner = eroded(corners, 0.001)
    hull = ConvexHull(corners)
    distance = -(hull.equations[:, :3] @ inner.T + hull.equations[:, 3:])
    np.testing.assert_allclose(distance.min(axis=1), 0.001, atol=1e-9)


def test_a_thin_piece_keeps_a_tenth_of_its_thickness():
    plate = np.unique(box((0.05, 0.05, 0.001), np.zeros(3)).vertices, axis=0)
    assert np.ptp(eroded(plate, 0.001)[:, 2]) == pytest.approx(1e-4)
