"""Bodies of a mesh: taken apart for their pieces, together for their mass where they overlap."""

import numpy as np
import pytest

from pneuflex_sim.scene import bodies as module
from pneuflex_sim.scene.bodies import bodies_of, without_overlap
from pneuflex_sim.scene.mesh import box, hull_mesh, merged, mesh_of, write_meshes
from pneuflex_sim.scene.objects import load_object
from pneuflex_sim.scene.solids import box_solid, convex_pieces, mesh_solid

BAR = (0.08, 0.03, 0.02)


def welded(size, center):
    """A box with one vertex a corner, as files are read."""
    return hull_mesh(np.unique(box(size, np.array(center)).vertices, axis=0))


def bar_in_two(overlap):
    """The bar as two halves [m] that overlap around its middle."""
    length = 0.5 * (BAR[0] + overlap)
    away = 0.5 * (BAR[0] - length)
    return [welded((length, *BAR[1:]), (x, 0.0, 0.0)) for x in (-away, away)]


def hollow(side, center):
    body = welded(3 * (side,), center)
    return mesh_of(body.vertices, body.indices[::-1].copy())


def test_bodies_that_overlap_are_taken_apart_for_their_pieces():
    halves = bar_in_two(0.01)
    pieces = convex_pieces(merged(halves))
    assert len(pieces) == 2
    for piece, half in zip(pieces, halves, strict=True):
        np.testing.assert_allclose(np.sort(piece, axis=0), np.sort(half.vertices, axis=0))


@pytest.mark.parametrize("overlap", [0.01, 0.04, 0.08])
def test_bodies_that_overlap_have_mass_and_inertia_of_their_union(overlap):
    found, whole = mesh_solid(without_overlap(merged(bar_in_two(overlap)))), box_solid(BAR)
    assert found.volume == pytest.approx(whole.volume, rel=1e-9)
    np.testing.assert_allclose(found.center, 0.0, atol=1e-12)
    np.testing.assert_allclose(found.inertia, whole.inertia, atol=1e-12)


def test_a_body_within_another_counts_once():
    cube, inner = welded(3 * (0.1,), np.zeros(3)), welded(3 * (0.03,), np.zeros(3))
    assert without_overlap(merged([cube, inner])).volume == pytest.approx(1e-3, rel=1e-9)


@pytest.mark.parametrize("overlap", [0.0, 1e-12, -0.01])
def test_bodies_that_touch_or_lie_apart_stay_as_they_are(overlap):
    mesh = merged(bar_in_two(overlap))
    assert without_overlap(mesh) is mesh


def test_bodies_whose_bounds_alone_overlap_stay_as_they_are():
    """An L, and a block in its corner."""
    arms = [
        welded((0.06, 0.02, 0.02), (0.03, 0.01, 0.01)),
        welded((0.02, 0.04, 0.02), (0.01, 0.04, 0.01)),
    ]
    angle = without_overlap(
        merged([arms[0], arms[1].moved(np.array([0.0, -0.005, 0.0]), np.eye(3))])
    )
    mesh = merged([angle, welded(3 * (0.01,), (0.04, 0.04, 0.01))])
    assert len(bodies_of(mesh)) == 2
    assert without_overlap(mesh) is mesh


def test_a_hollow_within_a_body_stays_with_it():
    mesh = merged([welded(3 * (0.1,), np.zeros(3)), hollow(0.05, np.zeros(3))])
    assert bodies_of(mesh) == [mesh] and without_overlap(mesh) is mesh


def test_overlapping_bodies_with_a_hollow_are_refused():
    away = (0.08, 0.0, 0.0)
    mesh = merged(
        [welded(3 * (0.1,), np.zeros(3)), hollow(0.02, np.zeros(3)), welded(3 * (0.1,), away)]
    )
    with pytest.raises(
        ValueError, match="surface: expected bodies without hollows where they over"
    ):
        without_overlap(mesh)


def test_without_the_library_bodies_that_may_overlap_are_refused(monkeypatch):
    monkeypatch.setattr(module, "find_spec", lambda name: None)
    apart = merged(bar_in_two(-0.01))
    assert without_overlap(apart) is apart
    with pytest.raises(ValueError, match="pip install manifold3d`, or give `pieces: hull`"):
        without_overlap(merged(bar_in_two(0.01)))


def test_an_object_of_overlapping_bodies_weighs_what_the_bar_weighs(tmp_path):
    write_meshes(tmp_path / "bar.stl", {str(k): half for k, half in enumerate(bar_in_two(0.02))})
    assert load_object(tmp_path / "bar.stl").mass == pytest.approx(500.0 * np.prod(BAR), rel=1e-6)
