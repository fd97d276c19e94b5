"""Mass properties against closed forms, and convex pieces of meshes."""

import threading

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull, Delaunay
from scipy.spatial.transform import Rotation

from pneuflex_sim.scene import solids as module
from pneuflex_sim.scene.mesh import box, mesh_of
from pneuflex_sim.scene.objects import load_object
from pneuflex_sim.scene.solids import (
    box_solid,
    cache_file,
    convex_pieces,
    cylinder_solid,
    ellipsoid_solid,
    eroded,
    hull_solid,
    joined,
    mesh_solid,
)


def torus_mesh(ring, tube, around=96, across=64):
    """Mesh of a torus about z."""
    u, v = np.meshgrid(
        2 * np.pi * np.arange(around) / around, 2 * np.pi * np.arange(across) / across
    )
    u, v = u.T, v.T
    radius = ring + tube * np.cos(v)
    vertices = np.stack([radius * np.cos(u), radius * np.sin(u), tube * np.sin(v)], -1)
    faces = []
    for i in range(around):
        for j in range(across):
            a, b = i * across + j, (i + 1) % around * across + j
            c, d = (i + 1) % around * across + (j + 1) % across, i * across + (j + 1) % across
            faces += [(a, b, c), (a, c, d)]
    return mesh_of(vertices.reshape(-1, 3), np.array(faces, np.int32).ravel())


def test_a_box_as_a_mesh_is_the_box_of_the_closed_form():
    size, center = (0.02, 0.05, 0.11), np.array([0.3, -0.2, 0.1])
    solid, expected = mesh_solid(box(size, center)), box_solid(size)
    assert solid.volume == pytest.approx(expected.volume)
    np.testing.assert_allclose(solid.center, center)
    np.testing.assert_allclose(solid.inertia, expected.inertia, atol=1e-15)


def test_a_torus_as_a_mesh_is_the_torus_of_the_closed_form():
    ring, tube = 0.04, 0.012
    solid = mesh_solid(torus_mesh(ring, tube))
    assert solid.volume == pytest.approx(2 * np.pi**2 * ring * tube**2, rel=5e-3)
    about_axis = ring**2 + 0.75 * tube**2
    across = 0.5 * ring**2 + 0.625 * tube**2
    np.testing.assert_allclose(
        solid.inertia, np.diag([across, across, about_axis]), rtol=5e-3, atol=1e-9
    )


def test_the_integral_comes_to_the_closed_form_by_the_square_of_the_mesh_width():
    exact = 2 * np.pi**2 * 0.04 * 0.012**2
    errors = [1 - mesh_solid(torus_mesh(0.04, 0.012, n, n)).volume / exact for n in (24, 48)]
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.05)


def test_an_ellipsoid_and_a_cylinder_are_those_of_many_points():
    around = 2 * np.pi * np.arange(100) / 100
    height = np.linspace(-1, 1, 61)
    ring = np.sqrt(1 - height**2)
    points = np.stack(
        [np.outer(np.cos(around), ring), np.outer(np.sin(around), ring), np.tile(height, (100, 1))]
    ).reshape(3, -1)
    size = np.array([0.086, 0.063, 0.035])
    many, solid = hull_solid(points.T * size / 2), ellipsoid_solid(size)
    assert many.volume == pytest.approx(solid.volume, rel=5e-3)
    np.testing.assert_allclose(many.inertia, solid.inertia, rtol=5e-3, atol=1e-10)
    circle = 0.02 * np.stack([np.cos(around), np.sin(around)], 1)
    points = np.array([[*point, z] for point in circle for z in (-0.05, 0.05)])
    many, solid = hull_solid(points), cylinder_solid(0.04, 0.1)
    np.testing.assert_allclose(many.inertia, solid.inertia, rtol=2e-3, atol=1e-10)


def test_two_halves_of_a_box_are_the_box():
    halves = [
        hull_solid(np.unique(box((0.03, 0.04, 0.1), np.array([x, 0, 0])).vertices, axis=0))
        for x in (-0.015, 0.015)
    ]
    whole = joined(halves)
    assert whole.volume == pytest.approx(box_solid((0.06, 0.04, 0.1)).volume)
    np.testing.assert_allclose(whole.center, 0, atol=1e-12)
    np.testing.assert_allclose(whole.inertia, box_solid((0.06, 0.04, 0.1)).inertia, atol=1e-12)


def test_principal_axes_of_a_turned_box_give_its_inertia_back():
    turn = Rotation.from_euler("xyz", (0.4, -0.7, 1.1)).as_matrix()
    solid = mesh_solid(box((0.02, 0.05, 0.11), np.zeros(3)).moved(np.zeros(3), turn))
    moments, axes = solid.principal()
    matrix = Rotation.from_quat(axes).as_matrix()
    np.testing.assert_allclose(matrix @ np.diag(moments) @ matrix.T, solid.inertia, atol=1e-12)
    np.testing.assert_allclose(
        sorted(moments), sorted(np.diag(box_solid((0.02, 0.05, 0.11)).inertia))
    )


def test_axes_that_are_principal_stay():
    assert cylinder_solid(0.04, 0.1).principal()[1].tolist() == [0, 0, 0, 1]


def test_a_surface_that_looks_inwards_is_refused():
    with pytest.raises(ValueError, match="expected one that encloses a volume, got -"):
        mesh = box((0.1, 0.1, 0.1), np.zeros(3))
        mesh_solid(mesh_of(mesh.vertices, mesh.indices[::-1]))


@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_a_hull_of_points_in_one_plane_is_refused(turn):
    points = np.array([[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0], [0.05, 0.05, 0]])
    with pytest.raises(ValueError, match=r"surface: expected .* (one plane|encloses a volume)"):
        hull_solid(Rotation.from_euler("x", turn).apply(points))


RING, TUBE = 0.03, 0.012
QUICK = module.COACD_SETTINGS | {
    "mcts_iterations": 20,
    "resolution": 500,
}  # a search that is less long


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    """A cache that no other test sees."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))


@pytest.fixture(scope="module")
def torus():
    """A coarse torus about z."""
    return torus_mesh(RING, TUBE, 14, 8)


def test_work_that_takes_long_is_shown_with_what_is_cheaper(monkeypatch, capsys):
    monkeypatch.setattr(module, "TELL_PERIOD", 0.01)
    shown = threading.Event()

    class Seen(module.Progress):
        def __call__(self, step, number, total):
            print(step)
            shown.set()

    monkeypatch.setattr(module, "Progress", Seen)
    with module._shown(2) as begin:
        begin(2)
        assert shown.wait(60.0)
    assert "body 2 of 2; kept for the next time; `pieces: hull`" in capsys.readouterr().out


def test_a_cache_that_is_damaged_or_does_not_fit_is_made_anew(torus, monkeypatch):
    monkeypatch.setattr(module, "_decomposed", lambda mesh: (torus.vertices,))
    cache = cache_file(torus)
    cache.parent.mkdir(parents=True)
    cache.write_bytes(b"PK\x03\x04 damaged")
    assert convex_pieces(torus)[0] is torus.vertices
    np.testing.assert_array_equal(convex_pieces(torus)[0], torus.vertices)
    cache.unlink()
    cache.mkdir()  # nothing can take its place
    with pytest.warns(UserWarning, match="the convex pieces are not kept"):
        assert convex_pieces(torus)[0] is torus.vertices


def test_the_pieces_fill_a_torus_leave_its_hole_and_are_kept(torus, monkeypatch):
    pytest.importorskip("coacd")
    monkeypatch.setattr(module, "COACD_SETTINGS", QUICK)
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
    monkeypatch.setitem(module.COACD_SETTINGS, "threshold", 0.1)
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


def write_stl(path, *meshes):
    whole = trimesh.util.concatenate(meshes)
    whole.export(path)
    return path


def test_a_mesh_of_no_thickness_is_refused_with_its_file(tmp_path):
    box = trimesh.creation.box((0.04, 0.03, 0.02))
    box.vertices[:, 2] = 0.0
    path = write_stl(tmp_path / "flat.stl", box)
    with pytest.raises(ValueError, match=r"flat.stl: surface: expected one that encloses a volume"):
        load_object(path)
