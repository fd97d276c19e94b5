"""Objects as data: the sizes and masses of Table 8.1, files of one's own, and what is refused."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pneuflex_sim.scene.friction import load_friction
from pneuflex_sim.scene.mesh import box, mesh_of, write_meshes
from pneuflex_sim.scene.object_shapes import geometry
from pneuflex_sim.scene.objects import load_object, load_objects
from softhand_model.chain.hulls import COLLISION_MARGIN

TABLE_8_1 = {  # outer size [mm], mass [g]
    "water_bottle": ((63, 63, 215), 546),
    "tube": ((33, 33, 178), 114),
    "cylinder": ((65, 65, 175), 106),
    "water_balloon": ((125, 63, 35), 99),
    "tape_dispenser": ((56, 28, 77), 30),
    "staple_remover": ((57, 47, 32), 20),
    "sunglasses": ((125, 36, 23), 16),
    "marker": ((17, 17, 138), 14),
    "paper_cup": ((88, 88, 110), 13),
    "tissue": ((150, 150, 0.2), 1),
}


def outer_size(described):
    """Lengths (3,) [m] of the object along its own axes, by what it touches with."""
    pieces = described.geometry.pieces
    if pieces:
        return np.ptp(np.vstack(pieces), axis=0) + 2 * COLLISION_MARGIN
    if described.shape == "sheet":
        return np.array(described.dimensions["size"])
    return 2 * np.array(described.half_extents)


@pytest.mark.parametrize("name", TABLE_8_1)
def test_sizes_and_masses_are_those_of_table_8_1(name):
    size, mass = TABLE_8_1[name]
    described = load_object(name)
    assert described.mass == pytest.approx(mass * 1e-3)
    found = sorted(outer_size(described))
    np.testing.assert_allclose(
        found, sorted(np.array(size) * 1e-3), atol=4e-4
    )  # corners are rounded by COLLISION_MARGIN


def test_the_water_of_the_balloon_fills_it():
    assert load_object("water_balloon").geometry.solid.volume == pytest.approx(99e-6, rel=0.01)


def test_the_cup_is_open_and_its_inertia_is_that_of_a_thin_frustum():
    cup = load_object("paper_cup")
    solid, wall = cup.geometry.solid, cup.dimensions["wall"]
    radii = np.linspace(0.030, 0.044, 2001) - wall / 2
    area = 2 * math.pi * radii  # of rings; all staves are as thick across
    bottom = math.pi * (0.030 - wall) ** 2
    wall_area = 0.110 * area.mean()
    expected = (0.110 * (area * radii**2).mean() + bottom * (0.030 - wall) ** 2 / 2) / (
        wall_area + bottom
    )
    assert solid.inertia[2, 2] == pytest.approx(expected, rel=0.03)
    inside = np.array([0.0, 0.0, 0.02])
    for piece in cup.geometry.pieces:
        assert np.linalg.norm(piece - inside, axis=1).min() > 0.025


def test_height_at_rest_is_half_the_size_along_the_vertical():
    assert load_object("cylinder").rest_height == pytest.approx(0.0325)
    assert load_object("tape_dispenser").rest_height == pytest.approx(0.014)
    assert load_object("water_balloon").rest_height == pytest.approx(0.0175, abs=1e-6)
    turn = Rotation.from_euler("xyz", load_object("cylinder").rpy)
    assert abs(turn.as_matrix()[2, 2]) < 1e-9  # it lies


# -------------------------------------------------------------------- files of one's own
@pytest.fixture
def block(tmp_path):
    """A block of 40 x 60 x 80 mm in millimetres, off the origin: the paths of its STL and OBJ."""
    mesh = box((40.0, 60.0, 80.0), np.array([100.0, 0.0, 0.0]))
    write_meshes(tmp_path / "block.stl", {"block": mesh})
    write_meshes(tmp_path / "metres.obj", {"block": box((0.04, 0.06, 0.08), np.zeros(3))})
    return tmp_path


def yaml_of(folder, **changed):
    """A YAML file of an object of that mesh, with keys changed or left out (None)."""
    keys = {"format": "pneuflex-object/1", "name": "brick", "shape": "mesh", "file": "block.stl"}
    keys |= {"scale": 0.001, "mass": 0.3, "material": "pvc"} | changed
    path = folder / "brick.yaml"
    path.write_text(
        "".join(f"{key}: {value}\n" for key, value in keys.items() if value is not None)
    )
    return path


def test_a_mesh_by_its_yaml_is_the_box_that_it_is(block):
    described = load_object(yaml_of(block))
    assert (described.name, described.mass) == ("brick", 0.3)
    squares = np.array([0.04, 0.06, 0.08]) ** 2
    expected = np.diag(squares.sum() - squares) / 12
    np.testing.assert_allclose(described.geometry.solid.inertia, expected, atol=1e-9)
    assert len(described.geometry.pieces) == 1
    np.testing.assert_allclose(outer_size(described), [0.04, 0.06, 0.08], atol=1e-6)
    assert described.rest_height == pytest.approx(0.04)


def test_a_mesh_file_alone_is_taken_in_metres_with_a_middling_density(block):
    described = load_object(str(block / "metres.obj"))
    assert described.mass == pytest.approx(500 * 0.04 * 0.06 * 0.08)


def test_an_open_mesh_needs_to_be_taken_by_its_hull(block):
    mesh = box((0.04, 0.06, 0.08), np.zeros(3))
    open_top = type(mesh)(mesh.vertices, mesh.normals, mesh.indices[:-3])
    write_meshes(block / "open.obj", {"open": open_top})
    with pytest.raises(ValueError, match=r"brick.yaml:.: file: .*open.obj: .*3 open edges.*hull"):
        load_object(yaml_of(block, file="open.obj", scale=None))
    hull = load_object(yaml_of(block, file="open.obj", scale=None, pieces="hull"))
    assert hull.geometry.solid.volume == pytest.approx(0.04 * 0.06 * 0.08)


def corner_of_two_boxes(folder):
    """An L of two bars of 20 x 20 x 60 mm as YAML files, cut into pieces and as its hull."""
    outline = np.array([(0, 0), (60, 0), (60, 20), (20, 20), (20, 60), (0, 60)])
    points = np.array([(*point, z) for z in (0, 20) for point in outline]) / 1e3
    fan = [(3, 4, 5), (3, 5, 0), (3, 0, 1), (3, 1, 2)]
    faces = [face[::-1] for face in fan] + [tuple(k + 6 for k in face) for face in fan]
    for a, b in zip(range(6), (1, 2, 3, 4, 5, 0), strict=True):
        faces += [(a, b, a + 6), (b, b + 6, a + 6)]
    write_meshes(folder / "l.stl", {"l": mesh_of(points, np.array(faces, np.int32).ravel())})
    return [
        load_object(yaml_of(folder, file="l.stl", scale=None, pieces=pieces))
        for pieces in (None, "hull")
    ]


def test_what_is_drawn_is_what_touches(tmp_path):
    whole, hull = corner_of_two_boxes(tmp_path)
    assert whole.geometry.surface.volume == pytest.approx(40e-6)
    assert hull.geometry.surface.volume == pytest.approx(40e-6 + 16e-6)
    assert hull.geometry.solid.volume == pytest.approx(40e-6 + 16e-6)


def test_flat_faces_are_drawn_flat(tmp_path):
    for described in corner_of_two_boxes(tmp_path):
        surface = described.geometry.surface
        corners = surface.corners
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        shown = surface.normals[surface.indices].reshape(-1, 3, 3)
        np.testing.assert_allclose(shown, np.repeat(normal[:, None], 3, axis=1), atol=1e-9)


def test_a_material_of_no_table_of_friction_is_refused_with_file_and_key(block):
    path = yaml_of(block, material="cheese")
    with pytest.raises(ValueError, match=r"brick.yaml:.: material: expected one of .*got 'cheese'"):
        load_object(path, load_friction())
    assert load_object(path).material == "cheese"  # for drawing


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"shape": "cone"}, "brick.yaml:.: shape: expected one of cylinder, .*, got 'cone'"),
        ({"shape": None}, "brick.yaml:.: document: expected the key `shape`"),
        ({"mass": 0}, "brick.yaml:.: mass: expected a number from 1e-06 to 1000 kg, got 0"),
        ({"mass": None}, "brick.yaml:.: document: expected the key mass"),
        ({"colour": "red"}, "brick.yaml:.: document: expected only the keys .*, got colour"),
        (
            {"scale": None},
            "brick.yaml:.: file: .*longest side of 0.002 to 2 m, got 80 m; .*scale",
        ),
        (
            {"file": "none.stl"},
            "brick.yaml:.: file: .*none.stl: expected a mesh, got .*No such file",
        ),
        ({"file": "brick.yaml"}, "expected a file .stl or .obj, got '.yaml'"),
        (
            {"pieces": "many"},
            "brick.yaml:.: pieces: expected one of decomposed, hull, got 'many'",
        ),
        ({"rpy": "[0, 0]"}, "brick.yaml:.: rpy: expected 3 numbers"),
        ({"compliance": "{stiffness: -1, damping: 1}"}, "compliance.stiffness: expected a number"),
        ({"format": "pneuflex-objects/1"}, "format: expected one of pneuflex-object/1, got"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused_with_key_and_what_came(block, changed, named):
    with pytest.raises(ValueError, match=named):
        load_object(yaml_of(block, **changed))


def test_a_cup_without_room_in_it_is_refused(tmp_path):
    path = tmp_path / "cup.yaml"
    path.write_text(
        "format: pneuflex-object/1\nshape: cup\nmass: 0.01\nmaterial: paper\n"
        "diameter: 0.08\nbase_diameter: 0.01\nlength: 0.1\nwall: 0.006\n"
    )
    with pytest.raises(
        ValueError, match="cup.yaml:.: shape: cup: expected a wall below half .* 0.006"
    ):
        load_object(path)


def test_an_unknown_name_is_refused_with_those_there_are():
    with pytest.raises(ValueError, match="object: expected one of cylinder, .*; got 'brick'"):
        load_object("brick")


def test_every_shipped_object_says_what_it_leaves_out():
    for described in load_objects().values():
        assert described.note, described.name


def test_boxes_and_their_hulls_have_the_same_mass_properties():
    parts = [{"size": (0.02, 0.03, 0.04), "position": (0.01, 0.0, 0.0)}]
    one = geometry("boxes", {"boxes": parts})
    other = geometry("box", {"size": (0.02, 0.03, 0.04)})
    np.testing.assert_allclose(one.solid.inertia, other.solid.inertia, atol=1e-12)
