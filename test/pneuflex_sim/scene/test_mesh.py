"""Meshes: normals as they are drawn, and STL and OBJ files."""

import numpy as np
import pytest
import trimesh

from pneuflex_sim.scene import mesh
from pneuflex_sim.scene.mesh import (
    box,
    creased,
    hull_mesh,
    mesh_of,
    open_edges,
    read_mesh,
    tube,
    write_meshes,
)

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


def test_a_tetrahedron_has_flat_faces_alone():
    found = creased(hull_mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])))
    assert len(found.vertices) == 12
    flat = np.vstack([-np.eye(3), np.full((1, 3), 3**-0.5)])
    assert np.unique(found.normals.round(9), axis=0) == pytest.approx(
        np.unique(flat.round(9), axis=0)
    )


def test_an_edge_is_sharp_also_between_faces_that_meet_smoothly_over_others():
    base = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    low = tube(np.array([base, base * [0.6, 0.6, 1] + [0.2, 0.2, 0.1]]))  # sides rise by 27 deg
    assert len(creased(low).vertices) == 18  # three at each corner of the base, else one


def test_an_open_mesh_keeps_its_faces():
    square = mesh_of(
        np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([0, 1, 2, 0, 2, 3])
    )
    np.testing.assert_allclose(creased(square).corners, square.corners)


SIZE = (0.02, 0.03, 0.04)
PYRAMID = """# a pyramid with a square base
mtllib none.mtl
o pyramid
v -0.02 -0.02 0
v 0.02 -0.02 0
v 0.02 0.02 0
v -0.02 0.02 0
v 0 0 0.03 1.0
vn 0 0 1
usemtl red
f 4 3 2 1
f 1/1/1 2/1/1 5/1/1
f 2//1 3//1 5//1
f 3 4 -1
f 4 1 -1
"""


def test_what_is_written_is_read_again(tmp_path):
    mesh = box(SIZE, np.array([0.1, 0.0, 0.0]))
    write_meshes(tmp_path / "box.stl", {"box": mesh})
    write_meshes(tmp_path / "box.obj", {"box": mesh})
    for name in ("box.stl", "box.obj"):
        found = read_mesh(tmp_path / name)
        assert found.volume == pytest.approx(np.prod(SIZE), rel=1e-6)
        assert open_edges(found) == 0
        np.testing.assert_allclose(found.vertices.mean(axis=0), [0.1, 0, 0], atol=1e-3)


def test_a_text_stl_is_read_too(tmp_path):
    lines = ["solid box"]
    for corners in box(SIZE, np.zeros(3)).corners:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex {:.9e} {:.9e} {:.9e}".format(*corner) for corner in corners]
        lines += ["endloop", "endfacet"]
    (tmp_path / "box.STL").write_text("\n".join([*lines, "endsolid box"]))
    found = read_mesh(tmp_path / "box.STL")
    assert found.volume == pytest.approx(np.prod(SIZE)) and open_edges(found) == 0


def test_faces_of_many_corners_slashes_and_negative_indices(tmp_path):
    (tmp_path / "pyramid.obj").write_text(PYRAMID)
    found = read_mesh(tmp_path / "pyramid.obj", 2.0)
    assert found.volume == pytest.approx(8 * 0.04**2 * 0.03 / 3) and open_edges(found) == 0


def test_faces_that_look_inwards_are_turned(tmp_path):
    mesh = box(SIZE, np.zeros(3))
    inwards = type(mesh)(mesh.vertices, mesh.normals, mesh.indices[::-1])
    write_meshes(tmp_path / "box.obj", {"box": inwards})
    assert read_mesh(tmp_path / "box.obj").volume == pytest.approx(np.prod(SIZE))


@pytest.mark.parametrize(
    ("change", "to"),
    [(b"# a pyramid", "# Körper".encode("latin-1")), (b" ", b"\t"), (b"\n", b"\r\n")],
)
def test_text_of_other_editors_is_read_as_well(tmp_path, change, to):
    (tmp_path / "pyramid.obj").write_bytes(PYRAMID.encode().replace(change, to))
    assert open_edges(read_mesh(tmp_path / "pyramid.obj")) == 0


def test_a_text_stl_may_lack_its_last_line(tmp_path):
    write_meshes(tmp_path / "box.stl", {"box": box(SIZE, np.zeros(3))})
    text = trimesh.load_mesh(tmp_path / "box.stl").export(file_type="stl_ascii")
    (tmp_path / "text.stl").write_text(text[: text.index("endsolid")])
    assert open_edges(read_mesh(tmp_path / "text.stl")) == 0


@pytest.mark.parametrize("cut", [-20, None])
def test_a_binary_stl_of_another_length_than_it_says_is_refused(tmp_path, cut):
    write_meshes(tmp_path / "box.stl", {"box": box(SIZE, np.zeros(3))})
    data = (tmp_path / "box.stl").read_bytes()
    (tmp_path / "torn.stl").write_bytes(data[:cut] if cut else data + b"\xff")
    with pytest.raises(ValueError, match=r"torn\.stl: expected 4 triangles or more .* got 0"):
        read_mesh(tmp_path / "torn.stl")


@pytest.mark.parametrize("removed", [1, 2])
def test_open_edges_are_counted(tmp_path, removed):
    mesh = box(SIZE, np.zeros(3))
    write_meshes(
        tmp_path / "box.obj",
        {"box": type(mesh)(mesh.vertices, mesh.normals, mesh.indices[3 * removed :])},
    )
    assert open_edges(read_mesh(tmp_path / "box.obj")) == {1: 3, 2: 4}[removed]


@pytest.mark.parametrize(
    ("name", "text", "named"),
    [
        ("none.ply", "ply", "expected a file .stl or .obj, got '.ply'"),
        ("torn.stl", "solid nothing", "expected 4 triangles or more"),
        ("torn.obj", "v 0 0 x", "expected a mesh, got .*(could not be read|could not convert)"),
        ("torn.obj", "v 0 0 1\nf 1 2 3", "expected a mesh, got index"),
        (
            "torn.obj",
            PYRAMID.replace("f 4 3 2 1", "f 0 3 2 1"),
            "expected a mesh, got a face with a",
        ),
        ("torn.obj", PYRAMID.replace("v -0.02 -0.02 0", "v -0.02 -0.02"), "expected 4 triangles"),
        (
            "large.obj",
            PYRAMID.replace("0.0", "0"),
            "expected a longest side of 0.002 to 2 m, got",
        ),
    ],
)
def test_what_cannot_be_used_is_refused_with_the_file(tmp_path, name, text, named):
    (tmp_path / name).write_text(text)
    with pytest.raises(ValueError, match=f"{name}: {named}"):
        read_mesh(tmp_path / name)


def test_a_file_that_is_too_large_is_not_read_whole(tmp_path, monkeypatch):
    monkeypatch.setattr(mesh, "LARGEST_MESH_FILE", 100)
    write_meshes(tmp_path / "box.stl", {"box": box((0.04, 0.06, 0.08), np.zeros(3))})
    with pytest.raises(ValueError, match=r"box\.stl: expected a mesh, got more than 100 bytes"):
        read_mesh(tmp_path / "box.stl")
