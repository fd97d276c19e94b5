"""Tables of a hand that held poses are loaded to the same numbers, whatever the dialect."""

import re
from functools import partial

import numpy as np
import pytest
from hand_csvs import (
    CHANNELS,
    HAND,
    TIPS,
    WRISTS,
    motion_capture,
    one_row_a_pose,
    poses,
    table,
)
from scipy.spatial.transform import Rotation

from model_lab.api.data import import_files
from model_lab.importing.cell_words import words
from model_lab.importing.hand_sets import set_of_hand
from softhand_common.documents.yaml_document import DocumentError

AXES, TURNED = "xyz", re.compile(r"turned by (\d+) deg")
PLAIN = [
    "time",
    *(f"pressure.{c}" for c in CHANNELS),
    *(f"{t}_tip.{a}" for t in TIPS for a in AXES),
]
HELD = {f"hold_{number}.csv": rpy for number, rpy in enumerate(WRISTS)}


def labelled(time, pressure, place):
    """A header with names as functions make them."""
    return [time, *map(pressure, CHANNELS), *(place(t, a) for t in TIPS for a in AXES)]


PLAIN = labelled("time", lambda c: f"pressure.{c}", lambda t, a: f"{t}_tip.{a}")
OF_A_HAND = ("Daumen", "Zeigefinger", "Mittelfinger", "Ringfinger", "Kleiner Finger")
FINGERS = dict(zip(TIPS, OF_A_HAND, strict=True))
GERMAN = labelled(
    "Zeit [s]", lambda c: f"Druck {c.upper()} [mbar]", lambda t, a: f"{FINGERS[t]} {a} [cm]"
)
CAMEL = labelled(
    "t_s", lambda c: f"pressure{c.upper()} [Pa]", lambda t, a: f"{t.title()}Tip{a.upper()}"
)
NUMBERED = labelled(
    "elapsed (s)", lambda c: f"ch{CHANNELS.index(c)} (psi)", lambda t, a: f"pos_{t}_{a}_mm"
)
WITH_UNITS = labelled("time [s]", lambda c: f"pressure.{c} [kPa]", lambda t, a: f"{t}_tip.{a} [mm]")
ANGLES = [*WITH_UNITS, "wrist roll [deg]", "wrist pitch [deg]", "wrist yaw [deg]"]
TURN = [*WITH_UNITS, *(f"hand_orientation.{part}" for part in "xyzw")]


def quaternion(rpy):
    return Rotation.from_euler("xyz", rpy).as_quat()


DIALECTS = {
    "semicolons_and_decimal_commas": (
        partial(one_row_a_pose, header=GERMAN, scales=(1e-2, 1e2), comma=";", decimal=","),
        HELD,
    ),
    "names_in_capitals_and_no_unit_of_places": (
        partial(one_row_a_pose, header=CAMEL, scales=(1.0, 1.0)),
        HELD,
    ),
    "numbered_channels_in_psi": (
        partial(one_row_a_pose, header=NUMBERED, scales=(1.0 / 6894.757293, 1e3)),
        HELD,
    ),
    "angles_of_the_wrist": (
        partial(one_row_a_pose, header=ANGLES, scales=(1e-3, 1e3), run_of=np.rad2deg),
        None,
    ),
    "quaternions_of_the_wrist": (
        partial(one_row_a_pose, header=TURN, scales=(1e-3, 1e3), run_of=quaternion),
        None,
    ),
    "motion_capture_beside_a_logger": (motion_capture, None),
    "a_body_whose_frame_nobody_aligned": (
        partial(motion_capture, turn=(0.1, -0.2, 1.6), shift=(0.03, -0.02, 0.02)),
        None,
    ),
}


def check_numbers(data, pressure=30.0, place=0.1e-3):
    """The runs of a set, in kPa and mm, hold the poses within these errors [Pa], [m]."""
    blown, seen = poses()
    for run, frame in enumerate(data.runs.values()):
        told = frame[[f"pressure.{channel}" for channel in CHANNELS]].to_numpy()
        assert 1e3 * told == pytest.approx(blown[run], abs=pressure)
        told = frame[[f"{tip}_tip.{axis}" for tip in TIPS for axis in AXES]].to_numpy()
        assert 1e-3 * told == pytest.approx(seen[run].reshape(len(told), -1), abs=place)


@pytest.mark.parametrize("name", DIALECTS)
def test_any_dialect_is_loaded_to_the_same_numbers(tmp_path, name):
    make, wrist = DIALECTS[name]
    data = import_files(make(tmp_path), hand=HAND, wrist=wrist)
    # the frame found by a hand cut otherwise is 0.5 mm off
    check_numbers(data, place=2e-3 if name == "a_body_whose_frame_nobody_aligned" else 0.1e-3)


def test_runs_have_the_names_of_their_files(tmp_path):
    data = import_files(one_row_a_pose(tmp_path, WITH_UNITS, (1e-3, 1e3)), hand=HAND, wrist=HELD)
    assert list(data.runs) == [name.removesuffix(".csv") for name in HELD]
    data = import_files(motion_capture(tmp_path), hand=HAND)
    assert len({*data.runs} & {"r1", "r2"}) == 0


def test_a_frame_is_freed_only_where_the_body_was_not_aligned(tmp_path):
    files = motion_capture(tmp_path, turn=(0.0, 0.0, 1.6))
    found, _ = set_of_hand(files, HAND)
    assert found.document["specimens"]["hand"]["frame"] == "free"
    (angle,) = [float(one[1]) for one in map(TURNED.search, found.remarks) if one]
    assert angle == pytest.approx(np.rad2deg(1.6), abs=2.0)
    found, _ = set_of_hand(motion_capture(tmp_path), HAND)
    assert "frame" not in found.document["specimens"]["hand"]
    assert not any(map(TURNED.search, found.remarks))


def test_a_stated_orientation_is_that_of_the_wrist_wherever_the_places_were_tracked(tmp_path):
    own = Rotation.from_euler("xyz", (0.4, -1.1, 1.6))
    read = one_row_a_pose(tmp_path, WITH_UNITS, (1e-3, 1e3))
    for path in read:
        head, *rows = path.read_text().splitlines()
        values = np.array([row.split(",") for row in rows], float)
        places = own.apply(values[:, 5:].reshape(-1, 3)) + [400.0, -200.0, 900.0]  # [mm]
        table(path, head.split(","), np.hstack([values[:, :5], places.reshape(len(rows), -1)]))
    found, _ = set_of_hand(read, HAND, wrist=HELD)
    held = [run["wrist_rpy"] for run in found.document["runs"].values()]
    assert np.array(held) == pytest.approx(np.array(WRISTS), abs=1e-6)
    assert found.document["specimens"]["hand"]["frame"] == "free"
    assert any("the stated orientation stays" in remark for remark in found.remarks)
    check_numbers(import_files(read, hand=HAND, wrist=HELD), place=2e-3)


def test_a_mirrored_hand_is_not_turned(tmp_path):
    read = one_row_a_pose(tmp_path, WITH_UNITS, (1e-3, 1e3))
    for path in read:
        head, *rows = path.read_text().splitlines()
        values = np.array([row.split(",") for row in rows], float)
        values[:, 6::3] *= -1.0  # y
        table(path, head.split(","), values)
    found, _ = set_of_hand(read, HAND, wrist=HELD)
    assert "frame" not in found.document["specimens"]["hand"]


def test_a_file_that_states_one_length_unit_for_all_positions_needs_no_map(tmp_path):
    files = motion_capture(tmp_path, shift=(0.0, 0.0, 3.0))  # too far to guess the unit
    for path in files[::2]:
        text = path.read_text()
        path.write_text(
            text.replace("Format Version,1.23", "Format Version,1.23,Length Units,Meters")
        )
    check_numbers(import_files(files, hand=HAND), place=2e-3)


def test_a_world_whose_y_points_up_is_told(tmp_path):
    for name, room in (("z", 0.0), ("y", -np.pi / 2)):
        (tmp_path / name).mkdir()
        found, _ = set_of_hand(motion_capture(tmp_path / name, room=room), HAND)
        assert ("y of the world seems to point up" in found.remarks[0]) == (name == "y")


def test_a_clock_that_is_late_is_told_and_mended(tmp_path):
    files = motion_capture(tmp_path, late=0.9)
    found, _ = set_of_hand(files, HAND)
    said = [remark for remark in found.remarks if "its clock seems" in remark]
    assert len(said) == len(WRISTS)
    assert all(abs(float(one.split("seems ")[1].split(" s late")[0]) - 0.9) < 0.15 for one in said)
    shifts = {file.name: -0.9 for file in files if "mocap" in file.name}
    data = import_files(files, hand=HAND, shifts=shifts)
    check_numbers(data)
    assert "its clock" not in str(data)


def test_markers_and_channels_with_other_names_are_told_by_maps(tmp_path):
    header = [
        name.replace("index_tip", "Zeigefinger").replace("pressure.c", "line 7") for name in PLAIN
    ]
    files = one_row_a_pose(tmp_path, header, (1e-5, 1e3))
    maps = {
        "index_tip": ("Zeigefinger", ""),
        "pressure.c": ("line 7", ""),
        "pressure": ("", "bar"),
        "places": ("", "mm"),
        "time": ("time", "s"),
    }
    check_numbers(import_files(files, None, maps, HAND, wrist=HELD))


def test_markers_that_were_not_followed_are_left_out(tmp_path):
    header = [name.replace("ring_tip", "glove") for name in PLAIN]
    header = [f"{name} [kPa]" if "pressure" in name else name for name in header]
    files = one_row_a_pose(tmp_path, header, (1e-3, 1e3))
    found, _ = set_of_hand(files, HAND, wrist=HELD)
    assert [*found.document["markers"]] == ["thumb_tip", "index_tip", "middle_tip", "little_tip"]


REFUSED = {
    "nobody says how the wrist was held": (PLAIN, {}, "the orientation of the wrist"),
    "a channel is missing": (
        [name.replace("pressure.d", "flow") for name in PLAIN],
        HELD,
        "the pressure of each channel .* got no pressure.d",
    ),
    "two markers of a finger": (
        [name.replace("ring_tip", "index_tip_2") for name in PLAIN],
        HELD,
        "index_tip: expected the columns of one position",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_open_is_refused_with_what_to_say(tmp_path, name):
    header, wrist, message = REFUSED[name]
    header = [f"{one} [kPa]" if "pressure" in one else one for one in header]
    files = one_row_a_pose(tmp_path, header, (1e-3, 1e3))
    with pytest.raises(DocumentError, match=message):
        set_of_hand(files, HAND, wrist=wrist)


def test_positions_of_which_none_is_a_fingertip_are_told(tmp_path):
    header = labelled("t [s]", lambda c: f"p {c} [kPa]", lambda t, a: f"M{TIPS.index(t)} {a} [mm]")
    files = one_row_a_pose(tmp_path, header, (1e-3, 1e3))
    with pytest.raises(DocumentError, match=r"got positions: M0 x, M1 x, M2 x, M3 x, M4 x; give"):
        set_of_hand(files, HAND)
    maps = {f"{tip}_tip": (f"M{index}", "") for index, tip in enumerate(TIPS)}
    check_numbers(import_files(files, None, maps, HAND, wrist=HELD))


def test_a_marker_with_two_axes_is_told_to_lack_one(tmp_path):
    header = ["time [s]", *(f"pressure.{c} [kPa]" for c in CHANNELS)]
    header += ["index_tip.x [mm]", "index_tip.z [mm]"]
    path = table(tmp_path / "photos.csv", header, np.ones((4, len(header))))
    with pytest.raises(DocumentError, match="index_tip: expected x, y and z, got x, z.*:index"):
        set_of_hand([path], HAND)


def test_repeats_that_lack_poses_are_those_of_one_protocol_without_these(tmp_path):
    def file(name, lost):
        (first, *_) = one_row_a_pose(tmp_path, WITH_UNITS, (1e-3, 1e3))
        lines = first.read_text().splitlines()
        cells = lines[1 + lost].split(",")
        lines[1 + lost] = ",".join([*cells[:-3], "", "", ""])
        path = tmp_path / name
        path.write_text("\n".join(lines) + "\n")
        return path

    files = [file(f"{index}.csv", lost) for index, lost in enumerate((1, 3))]
    found, _ = set_of_hand(files, HAND, wrist=dict.fromkeys(("0.csv", "1.csv"), WRISTS[0]))
    assert [entry["protocol"] for entry in found.document["runs"].values()] == 2 * ["poses_1"]
    kept = 1e-3 * poses()[0][0][[0, 2, 4]]
    for run in found.runs:
        told = np.stack([run.columns[f"pressure.{c}"] for c in CHANNELS], axis=1)
        assert told == pytest.approx(kept, abs=1e-3)
    assert "2 poses are left out, as a repeat of the same protocol lacks them" in found.remarks


def test_pressures_without_a_unit_are_refused(tmp_path):
    files = one_row_a_pose(tmp_path, PLAIN, (1e-3, 1e3))
    with pytest.raises(DocumentError, match="unit of pressure, got none; for all pressures"):
        set_of_hand(files, HAND, wrist=HELD)


def test_words_of_names_are_parted_by_capitals_and_signs():
    assert words("IndexTip_x [mm]") == ["index", "tip", "x", "mm"]
