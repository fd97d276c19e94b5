"""Skin of a hand: exact at rest, near the swept volume when bent, smooth, and its files."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from pneuflex_sim.hand.kinematics import HandShape
from pneuflex_sim.hand.layout import build_layout
from pneuflex_sim.pictures.skin import HandSkin, blend_weights
from pneuflex_sim.scene.mesh import Mesh, box, write_meshes
from softhand_model.chain.outline import cross_section
from softhand_model.hand.hand import load_hand
from softhand_model.hand.profile import ConstantProfile
from softhand_model.model_file import load_model

LENGTH = 0.090  # [m] of a P10 finger


def skin_of(hand, segments=5):
    hand = load_hand(hand) if isinstance(hand, str) else hand
    return HandSkin(HandShape(build_layout(hand, segments, load_model(None))))


def even_finger(height=0.02, width=0.02):
    """The single finger with a constant section."""
    hand = load_hand("single_finger")
    chain = hand.chain("finger")
    even = replace(
        chain.actuators["finger"], height=ConstantProfile(height), width=ConstantProfile(width)
    )
    return replace(hand, chains=(replace(chain, actuators={"finger": even}),))


def bent(layout, angle):
    """Joint orientations (n, 4) of a finger that bends by an angle [rad] in even parts."""
    n = len(layout.mass)
    return Rotation.from_rotvec(np.tile([0.0, angle / n, 0.0], (n, 1))).as_quat()


def section_extents(mesh, place, thickness=1e-4):
    """Height and width [m] of a mesh along z where its vertices lie at a place."""
    near = mesh.vertices[np.abs(mesh.vertices[:, 2] - place) < thickness]
    return np.ptp(near[:, 0]), np.ptp(near[:, 1])


def test_the_resting_skin_has_height_and_width_of_the_profiles():
    skin = skin_of("single_finger")
    mesh = skin.actuator("finger", skin.shape.layout.rest)
    for place in (0.0, 0.018, 0.045, 0.072):
        taper = 1.0 - 0.925 * place / LENGTH
        height, width = section_extents(mesh, place)
        assert height == pytest.approx(0.020 * taper ** (1 / 3), rel=1e-9)
        assert width == pytest.approx(0.020 * taper ** (1 / 8), rel=1e-9)
    assert mesh.vertices[:, 2].max() == pytest.approx(LENGTH, rel=1e-12)
    assert mesh.vertices[:, 0].max() == pytest.approx(0.0, abs=1e-12)


def outline_area_and_centroid():
    """Area [-] and distance [-] of the centroid from the passive layer, of the unit outline."""
    x, y = cross_section().T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    area = cross.sum() / 2.0
    return area, -np.sum((x + np.roll(x, -1)) * cross) / (6.0 * area)


@pytest.mark.parametrize(("segments", "worst"), [(5, 0.06), (10, 0.02)])
def test_a_finger_bent_by_half_a_turn_keeps_the_volume_that_pappus_gives_it(segments, worst):
    skin = skin_of(even_finger(), segments)
    layout = skin.shape.layout
    straight = skin.actuator("finger", layout.rest).volume
    area, centroid = outline_area_and_centroid()
    assert straight == pytest.approx(area * 0.02**2 * LENGTH, rel=0.03)  # less the rounded tip
    swept = straight * (1.0 + np.pi / LENGTH * centroid * 0.02)
    volume = skin.actuator("finger", bent(layout, np.pi)).volume
    assert abs(volume / swept - 1.0) < worst, volume / swept


def test_the_passive_layer_of_a_bent_finger_is_an_arc_without_waves():
    skin = skin_of(even_finger(), 5)
    mesh = skin.actuator("finger", bent(skin.shape.layout, np.pi))
    rings = mesh.vertices[:-2].reshape(-1, len(cross_section()), 3)
    line = rings[:, 0, [0, 2]]  # the point at y = 0.4 of the width on the passive layer
    inner = line[8:-14]
    circle = np.linalg.lstsq(
        np.column_stack([2.0 * inner, np.ones(len(inner))]), np.sum(inner**2, axis=1), rcond=None
    )[0]
    distance = np.linalg.norm(inner - circle[:2], axis=1)
    assert distance.mean() == pytest.approx(LENGTH / np.pi, rel=0.05)
    assert np.ptp(distance) < 0.02 * distance.mean()


def test_weights_add_up_to_one_and_the_ends_belong_to_their_bones():
    for bones in (2, 3, 6):
        weights = blend_weights(np.linspace(0.0, bones - 1.0, 31), bones)
        np.testing.assert_allclose(weights.sum(axis=1), 1.0, atol=1e-12)
        assert weights.min() >= 0.0
        np.testing.assert_allclose(weights[[0, -1]], np.eye(bones)[[0, -1]], atol=1e-12)


@pytest.mark.parametrize("name", ["rbo_hand_1", "rbo_hand_1_split", "rbo_hand_2"])
def test_every_part_of_a_hand_is_closed_and_looks_outwards(name):
    skin = skin_of(name)
    parts = skin.parts(skin.shape.layout.rest)
    hand = load_hand(name)
    assert set(hand.actuator_names) | {"plate", "sheet"} <= set(parts)
    for part, (_, mesh) in parts.items():
        edges = mesh.indices.reshape(-1, 3)[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
        where = np.round(mesh.vertices, 9)
        there = {(tuple(where[a]), tuple(where[b])) for a, b in edges}
        assert all((b, a) in there for a, b in there), part
        assert 0.0 < mesh.volume <= ConvexHull(mesh.vertices).volume * (1 + 1e-9), part


def test_arcs_of_the_palm_lie_side_by_side_around_one_centre():
    skin = skin_of("rbo_hand_2")
    rest = skin.shape.layout.rest
    centre = np.array([0.010, -0.010 + 0.050, 0.105])
    for name, radius in (("palm_inner", 0.0375), ("palm_outer", 0.0625)):
        around = skin.actuator(name, rest).vertices[:, 1:] - centre[1:]
        distance = np.linalg.norm(around, axis=1)
        assert distance.min() == pytest.approx(radius - 0.0125, abs=2e-4)
        assert distance.max() == pytest.approx(radius + 0.0125, abs=2e-4)


def read_stl(path):
    data = path.read_bytes()
    kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    found = np.frombuffer(data[84:], kind)
    assert len(found) == np.frombuffer(data[80:84], "<u4")[0]
    return found


def read_obj(path):
    vertices, faces = [], []
    for line in filter(None, path.read_text().splitlines()):
        kind, *rest = line.split()
        if kind == "v":
            vertices.append([float(value) for value in rest])
        if kind == "f":
            faces.append([int(value.split("//")[0]) - 1 for value in rest])
    vertices, indices = np.array(vertices), np.array(faces, dtype=np.int32).ravel()
    return Mesh(vertices, np.zeros_like(vertices), indices)


def test_files_hold_the_meshes(tmp_path):
    meshes = {"a": box((0.01, 0.02, 0.03), np.zeros(3)), "b": box((0.02,) * 3, np.ones(3))}
    write_meshes(tmp_path / "two.stl", meshes)
    write_meshes(tmp_path / "two.obj", meshes)
    triangles = read_stl(tmp_path / "two.stl")
    assert len(triangles) == sum(len(mesh.corners) for mesh in meshes.values())
    normal = np.cross(*np.moveaxis(np.diff(triangles["corners"], axis=1), 1, 0))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    np.testing.assert_allclose(triangles["normal"], normal, atol=1e-3)
    assert read_obj(tmp_path / "two.obj").volume == pytest.approx(6e-6 + 8e-6, rel=1e-3)
