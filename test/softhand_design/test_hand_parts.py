"""Parts of RBO Hand 2 and of a hand of one's own: measured anew, put together, and refused."""

import csv
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from pneuflex_sim.hand.kinematics import HandShape
from pneuflex_sim.hand.layout import build_layout
from pneuflex_sim.pictures.skin import HandSkin
from softhand_design.commands.hand import main
from softhand_design.kit import checks, rubber
from softhand_design.kit import part as kit_part
from softhand_design.kit.bill import bill_of, thread_length
from softhand_design.kit.frames import mount_poses
from softhand_design.kit.kit import build_kit
from softhand_design.kit.parameters import KitParameters
from softhand_design.kit.report import CheckedKit, checked_kit, write_kit
from softhand_design.kit.rubber import casts, layers
from softhand_design.kit.scaffold import build_scaffold
from softhand_design.kit.solids import box, overlap
from softhand_design.mould.measure import read_stl
from softhand_design.mould.parts import build_mould
from softhand_design.mould.report import make_mould
from softhand_design.mould.volume import corrections
from softhand_model.hand.actuator import load_actuator
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model

GRIPPER = Path(__file__).parents[2] / "examples" / "three_finger_gripper" / "gripper.yaml"

CORNER = 3.0  # [mm] by which the simulator rounds the back more than the mould


@pytest.fixture(scope="module", autouse=True)
def actuators_made_once():
    """Variants of a hand share its actuators: each is cast, and the room around it found, once."""
    with pytest.MonkeyPatch.context() as patch:
        for module, name in ((rubber, "build_cast"), (rubber, "sided"), (kit_part, "grown")):
            patch.setattr(module, name, cache(getattr(module, name)))
        yield


@pytest.fixture(scope="module")
def made():
    return checked_kit(build_kit(load_hand("rbo_hand_2")))


def part(kit, name):
    return next(found for found in kit.in_hand if found.name == name)


def failures(kit):
    return {check.name.partition(" (")[0] for check in checks.check_kit(kit) if not check.passed}


def winding(points, mesh):
    """Winding numbers (n,) of points about a mesh: sums of solid angles (van Oosterom)."""
    found = np.zeros(len(points))
    for i, point in enumerate(points):
        a, b, c = np.moveaxis(mesh.triangles - point, 1, 0)
        la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
        top = np.sum(a * np.cross(b, c), axis=1)
        low = la * lb * lc + np.sum(a * b, axis=1) * lc
        low += np.sum(b * c, axis=1) * la + np.sum(c * a, axis=1) * lb
        found[i] = np.sum(2.0 * np.arctan2(top, low)) / (4.0 * np.pi)
    return found


def inner_points(mesh, count, seed):
    """Points just inside a mesh's surface, at random."""
    random = np.random.default_rng(seed)
    face = random.choice(len(mesh.faces), count, p=mesh.area_faces / mesh.area)
    share = np.sort(random.uniform(size=(count, 2)), axis=1)
    weights = np.stack([share[:, 0], share[:, 1] - share[:, 0], 1.0 - share[:, 1]], axis=1)
    places = np.sum(weights[..., None] * mesh.triangles[face], axis=1)
    return places - 0.05 * mesh.face_normals[face]


def placed_meshes(kit):
    found = {}
    for one in kit.in_hand:
        for name, pose in one.copies.items():
            mesh = read_stl(one.file)
            mesh.apply_transform(np.vstack([pose, [0.0, 0.0, 0.0, 1.0]]))
            found[name] = mesh
    return found


def test_the_parts_of_rbo_hand_2_pass_every_check(made):
    assert [check.name for check in made.failed] == []
    assert len(made.checks) >= 80


def test_casts_have_the_rubber_of_the_model_with_its_corrections(made):
    actuator = load_actuator("P10.finger")
    due = actuator.rubber_volume() * 1e9 + sum(corrections(build_mould(actuator)).values())
    assert part(made.kit, "P10.finger_cast").read.volume() == pytest.approx(due, rel=0.005)


def test_sheet_and_scaffold_have_the_volume_of_a_formula(made):
    assert part(made.kit, "rbo_hand_2_sheet").read.volume() == pytest.approx(55 * 90 * 3, rel=1e-3)
    # plate, four struts of 48 x 12 x 2, and more for pads, arm and what raises them
    least = 10 * 80 * 60 + 4 * 48 * 12 * 2
    assert least < part(made.kit, "rbo_hand_2_scaffold").read.volume() < 1.35 * least


def test_actuators_lie_where_the_simulator_has_them(made):
    layout = build_layout(load_hand("rbo_hand_2"), 10, load_model(None))
    skin = HandSkin(HandShape(layout)).parts(layout.rest)
    for one in made.kit.casts:
        for name, solid in one.room().items():
            low, high = np.reshape(solid.bounding_box(), (2, 3))
            points = skin[name][1].vertices * 1e3
            np.testing.assert_allclose(low, points.min(axis=0), atol=CORNER)
            np.testing.assert_allclose(high, points.max(axis=0), atol=CORNER)


def test_no_point_of_a_printed_part_or_of_the_sheet_lies_in_another_part(made):
    meshes = placed_meshes(made.kit)
    for name in ("scaffold", "saddle of thumb", "sheet"):
        points = inner_points(meshes[name], 150, 3)
        inside = np.abs(winding(points, meshes[name]) - 1.0) < 1e-3  # not so beside sharp edges
        points = points[inside]
        assert len(points) > 130
        for other, mesh in meshes.items():
            if other != name:
                low, high = mesh.bounds
                near = points[((points > low) & (points < high)).all(axis=1)]
                assert np.abs(winding(near, mesh)).max(initial=0.0) < 1e-3, (name, other)


def test_struts_at_the_places_of_the_hands_file_would_run_through_the_palm(made):
    rooms = part(made.kit, "P10.PalmOuter_mirrored_cast").room()
    ring = box([-1.0, -6.0, 0.0], [1.0, 6.0, 50.0]).transform(mount_poses(made.kit.hand)["ring"])
    assert overlap(ring, rooms["palm_outer"]) > 500.0


@pytest.mark.parametrize(
    ("moved", "failed"),
    [
        ((1.0, 0.0, 0.0), {"assembled: largest overlap of two parts"}),
        ((-40.0, 0.0, 300.0), {"assembled: parts that touch no other"}),
    ],
)
def test_a_scaffold_out_of_its_place_is_refused(made, moved, failed, tmp_path):
    kit = made.kit
    solid = kit.structure[0].solid.translate(moved)
    wrong = replace(kit, structure=[replace(kit.structure[0], solid=solid), *kit.structure[1:]])
    if moved[2]:
        wrong = replace(
            wrong, scaffold=replace(kit.scaffold, free_lengths={}), hand=_strutless(kit)
        )
    assert failed <= failures(wrong)
    refused = CheckedKit(wrong, bill_of(wrong), checks.check_kit(wrong))
    with pytest.raises(ValueError, match="parts of rbo_hand_2: .*expected"):
        write_kit(refused, tmp_path)
    assert not list(tmp_path.glob("*.stl"))


def _strutless(kit):
    chains = tuple(replace(chain, strut=None) for chain in kit.hand.chains)
    return replace(kit.hand, chains=chains)


def test_a_tray_that_is_too_shallow_or_too_narrow_is_found(made):
    kit, name = made.kit, "P10.thumb_layer"
    whole = kit.trays[name]
    shallow = replace(whole, solid=whole.solid.trim_by_plane((0.0, 0.0, -1.0), -3.8))
    found = failures(replace(kit, trays={**kit.trays, name: shallow}))
    assert found == {f"{name}: depth of its tray"}
    narrow = replace(whole, solid=whole.solid.scale((1.0, 0.9, 1.0)))
    found = failures(replace(kit, trays={**kit.trays, name: narrow}))
    assert found == {f"{name}: space in its tray"}


@pytest.mark.parametrize("turn", [-0.5, 0.0, 0.9])
def test_a_thumb_at_another_angle_gets_a_saddle_that_fits(turn):
    hand = load_hand("rbo_hand_2")
    palm, thumb = hand.chain("palm"), hand.chain("thumb")
    mount = replace(thumb.mount, rpy=(0.0, 0.0, turn))
    kit = build_kit(replace(hand, chains=(palm, replace(thumb, mount=mount)), sheet=None))
    assert failures(kit) == set()
    assert kit.structure[1].read.volume() > 1000.0


def test_the_arcs_of_a_right_hand_are_cast_in_mirrored_moulds():
    arcs = [one for one in casts(load_hand("rbo_hand_2")) if "Palm" in one.name]
    assert {one.name for one in arcs} == {
        "P10.PalmInner_mirrored_cast",
        "P10.PalmOuter_mirrored_cast",
    }
    for one in arcs:
        low, high = np.reshape(one.solid.bounding_box(), (2, 3))
        assert -low[1] > 2.0 * high[1]  # it turns towards -y


def test_a_mirrored_mould_is_the_mirror_image_in_its_file():
    arc = load_actuator("P10.PalmInner")
    plain, mirrored = make_mould(arc), make_mould(arc, turn=-1)
    assert mirrored.name == "P10.PalmInner_mirrored" and mirrored.failed == []
    for name in ("shell", "core"):
        one, other = read_stl(plain.files[name]), read_stl(mirrored.files[name])
        assert other.is_watertight and other.volume == pytest.approx(one.volume, rel=1e-6)
        assert other.bounds[:, 1] == pytest.approx(-one.bounds[::-1, 1], abs=1e-4)


def test_a_web_joins_the_layers_of_its_fingers_in_one_sheet():
    hand = load_hand("rbo_hand_1")
    ((sheet, shape),) = layers(hand, KitParameters())
    assert list(sheet.copies) == ["left+middle+right layer"]
    # three pairs 20 wide and two gaps of 10 over 60 mm, without the rounded ends
    assert shape.area() == pytest.approx(3 * 20 * 120 + 2 * 10 * 60, rel=0.02)


def test_thread_goes_around_a_straight_actuator_as_often_as_there_are_grooves():
    # P5: grooves from 3 to 114 mm, every 3 mm; around 2*(9 + 1.5 + 9) mm
    turns = np.floor((120.0 - np.sqrt(3 * 4.5) - 1.0 - 3.0) / 3.0)
    one = turns * np.hypot(39.0, 3.0)
    assert thread_length(load_actuator("P5"), 1.5) == pytest.approx(2e-3 * one, rel=1e-3)


def test_a_hand_of_ones_own_gets_files_and_a_bill(tmp_path, capsys):
    assert main(["parts", str(GRIPPER), "-o", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    for path in tmp_path.glob("*.stl"):
        mesh = read_stl(path.read_bytes())
        assert mesh.is_watertight and mesh.volume > 0.0, path.name
    rows = list(csv.DictReader((tmp_path / "three_finger_gripper_bill.csv").open()))
    assert {row["file"] for row in rows if row["file"]} <= {p.name for p in tmp_path.iterdir()}
    slim = next(row for row in rows if row["part"] == "slim_cast")
    assert int(slim["count"]) == 2
    assert float(slim["mass_g"]) == pytest.approx(1.08 * float(slim["volume_cm3"]), rel=1e-3)
    assert "slim_cast" in shown and "checks passed" in shown
    assert main(["parts", str(GRIPPER), "-o", str(tmp_path)]) == 2
    assert "--force" in capsys.readouterr().err


def test_a_hand_without_room_for_its_parts_is_refused():
    hand, used = load_hand("rbo_hand_2"), KitParameters()
    with pytest.raises(ValueError, match="rbo_hand_2: plate: expected a palm plate"):
        build_kit(replace(hand, plate=None))
    wall = [box([-100.0, -50.0, 61.0], [1.0, 50.0, 104.0])]
    with pytest.raises(ValueError, match="mount of palm: expected room for an arm of 4 mm"):
        build_scaffold(hand, wall, wall, None, used)
    fingers = replace(hand, chains=hand.chains[:4])
    with pytest.raises(ValueError, match="strut: expected room for the struts of little, ring"):
        build_scaffold(fingers, wall, wall, None, used)


def test_halves_of_one_casting_are_refused(tmp_path, capsys):
    assert main(["parts", "rbo_hand_1_split", "-o", str(tmp_path)]) == 2
    assert "expected actuators that are whole castings" in capsys.readouterr().err
