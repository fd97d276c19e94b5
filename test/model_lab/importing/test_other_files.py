"""Bags, MAT files, own message types and tracked tips become the numbers that they hold."""

from pathlib import Path

import numpy as np
import pytest
import recorded_run as record
import scipy.io
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.spatial.transform import Rotation

from model_lab.cli.main import main
from model_lab.importing.importing import make_set, propose
from model_lab.measurements.load import load_measurements
from softhand_common.documents.yaml_document import DocumentError

CASES = Path(__file__).parents[4] / "shared" / "cases"
HAND = "rbo_hand_2:index"
TIME = np.arange(0.0, 6.001, 0.1)
PRESSURE = 4e4 * np.sin(np.pi * TIME / 6.0) ** 2  # [Pa]
ANGLE = 2.0 * PRESSURE / 4e4  # [rad]


def imported(tmp_path, files, *options):
    assert main(["import", *map(str, files), "-o", str(tmp_path / "set"), "--yes", *options]) == 0
    return load_measurements(tmp_path / "set").runs


def check(run):
    np.testing.assert_allclose(run.columns["time"], TIME, atol=1e-6)
    np.testing.assert_allclose(run.columns["pressure"], PRESSURE, atol=1e-3)
    np.testing.assert_allclose(run.columns["tip_angle"], ANGLE, atol=1e-6)


def poses():
    turn = Rotation.from_euler("xyz", [0.2, -0.5, 1.0]) * Rotation.from_rotvec(
        np.outer(ANGLE, [0.0, -1.0, 0.0])
    )
    messages = []
    for seconds, pressure, (x, y, z, w) in zip(TIME, PRESSURE, turn.as_quat(), strict=True):
        pose = record.pose(seconds, (0.0, 0.0, 0.0))
        for name, value in zip("xyzw", (x, y, z, w), strict=True):
            setattr(pose.pose.orientation, name, float(value))
        messages.append(("/p", seconds, record.fluid_pressure(seconds, pressure)))
        messages.append(("/tip", seconds, pose))
    return messages


@pytest.mark.parametrize("storage", [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
def test_the_tip_angle_of_a_bag_is_made_of_its_quaternion(tmp_path, storage, capsys):
    bag = record.write_bag(tmp_path / "r1", poses(), storage)
    said = "tip_angle=quaternion(/tip pose.orientation)"
    assert propose([bag]).unsure == {"the tip angle": f"--map '{said}'"}
    check(imported(tmp_path, [bag], "--hand", HAND, "--map", said)[0])
    assert "0 at the beginning" in capsys.readouterr().out
    with pytest.raises(DocumentError, match="numbers of a quaternion"):
        propose([bag], maps={"tip_angle": ("/tip pose.orientation.y", "")})


def test_a_ros1_bag_of_the_driver_needs_no_word(tmp_path):
    messages = []
    for number, seconds in enumerate(TIME):
        state = record.ros1_joint_state(number, seconds, ["a"], effort=[PRESSURE[number]])
        angle = record.ros1_joint_state(number, seconds, ["p10"], position=[ANGLE[number]])
        messages += [("/pneumaticbox/state", seconds, state), ("/hand/tip_angles", seconds, angle)]
    bag = record.write_ros1_bag(tmp_path / "ramp_1.bag", messages)
    check(imported(tmp_path, [bag], "--hand", HAND)[0])


def test_own_message_types_are_read_with_their_definitions(tmp_path):
    definition = tmp_path / "defs" / "my_rig" / "msg" / "Reading.msg"
    definition.parent.mkdir(parents=True)
    definition.write_text("float64 pressure_kpa\nfloat64 angle_deg\n")
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(definition.read_text(), "my_rig/msg/Reading"))
    with Writer(tmp_path / "r1", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        topic = writer.add_connection("/rig", "my_rig/msg/Reading", typestore=store)
        for seconds, pressure, angle in zip(TIME, PRESSURE, ANGLE, strict=True):
            reading = store.types["my_rig/msg/Reading"](pressure / 1e3, np.degrees(angle))
            data = store.serialize_cdr(reading, "my_rig/msg/Reading")
            writer.write(topic, record.WALL_START + round(seconds * 1e9), data)
    _forget_definitions(tmp_path / "r1")
    maps = ["--map", "pressure=/rig pressure_kpa:kPa", "--map", "tip_angle=/rig angle_deg:deg"]
    with pytest.raises(DocumentError, match="my_rig"):
        propose([tmp_path / "r1"])
    check(imported(tmp_path, [tmp_path / "r1"], "--msgs", str(tmp_path / "defs"), *maps)[0])


def _forget_definitions(bag):
    """Make of a bag one of the time when bags did not hold the definitions of their messages."""
    import sqlite3

    with sqlite3.connect(next(bag.glob("*.db3"))) as database:
        database.execute("DELETE FROM message_definitions")


def test_a_mat_file_with_vectors_or_structures_is_read(tmp_path):
    vectors = {"time_s": TIME, "pressure_kPa": PRESSURE / 1e3, "angle_deg": np.degrees(ANGLE)}
    scipy.io.savemat(tmp_path / "plain.mat", vectors | {"note": "one finger", "rate": 10.0})
    scipy.io.savemat(tmp_path / "two.mat", {"r1": vectors, "r2": vectors})
    check(imported(tmp_path / "a", [tmp_path / "plain.mat"])[0])
    runs = imported(tmp_path / "b", [tmp_path / "two.mat"])
    assert [run.name for run in runs] == ["two_r1", "two_r2"]
    for run in runs:
        check(run)


def test_an_array_of_structures_is_a_run_each(tmp_path):
    vectors = {"time_s": TIME, "pressure_kPa": PRESSURE / 1e3, "angle_deg": np.degrees(ANGLE)}
    trials = np.empty(2, object)
    trials[:] = [vectors, vectors]
    scipy.io.savemat(tmp_path / "low.mat", {"trial": trials})
    runs = imported(tmp_path / "a", [tmp_path / "low.mat"])
    assert [run.name for run in runs] == ["low_trial-1", "low_trial-2"]
    for run in runs:
        check(run)


def test_a_mat_file_of_version_7_3_is_refused_with_the_mend(tmp_path):
    (tmp_path / "new.mat").write_bytes(
        b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + b"\0" * 9
    )
    with pytest.raises(DocumentError, match="'-v7'"):
        propose([tmp_path / "new.mat"])


def test_the_tip_angle_of_a_table_is_made_of_tip_coordinates(tmp_path):
    safe = np.maximum(ANGLE, 1e-9)
    x, y = 90.0 * np.sin(safe) / safe, -90.0 * (1.0 - np.cos(safe)) / safe
    rows = [",".join(map(repr, row)) for row in np.stack([TIME, PRESSURE, x, y], axis=1).tolist()]
    (tmp_path / "r1.csv").write_text("\n".join(["t [s],p [Pa],x [mm],y [mm]", *rows]))
    check(imported(tmp_path, [tmp_path / "r1.csv"], "--map", "tip_angle=tip(x,y)")[0])
    with pytest.raises(DocumentError, match="expected 4 columns, got 2"):
        propose([tmp_path / "r1.csv"], maps={"tip_angle": ("quaternion(x,y)", "")})


@pytest.mark.skipif(not CASES.is_dir(), reason="needs ../shared/cases")
@pytest.mark.parametrize(
    ("case", "files", "maps"),
    [
        ("bag_ros1", "*.bag", {}),
        ("bag_mocap_pose", "thin*", {"tip_angle": ("quaternion(/tip pose.orientation)", "")}),
        ("preamble", "*.csv", {"pressure": ("pressure", "kPa"), "tip_angle": ("tip_angle", "deg")}),
        (
            "german_names",
            "*.csv",
            {"pressure": ("pressure", "kPa"), "tip_angle": ("tip_angle", "deg")},
        ),
    ],
)
def test_files_that_people_brought_become_sets(tmp_path, case, files, maps):
    proposal = propose(sorted((CASES / case).glob(files)), maps=maps)
    make_set(proposal, HAND).write(tmp_path / "set")
    for run in load_measurements(tmp_path / "set").runs:
        assert run.samples > 50
        assert 0.3 < np.ptp(run.columns["tip_angle"]) < 4.0
        assert 1e4 < np.ptp(run.columns["pressure"]) < 6e4


@pytest.mark.skipif(not CASES.is_dir(), reason="needs ../shared/cases")
@pytest.mark.parametrize(
    ("case", "parts"),
    [
        ("preamble", ["line 4 has it", "model-lab import"]),
        ("german_names", ["semicolons", "model-lab import"]),
        ("bag_mocap_pose", ["numbers of a quaternion", "model-lab import"]),
        ("time_glitch", ["row 161", "leave `time` out", "mend the clock"]),
    ],
)
def test_a_set_that_people_brought_is_told_how_to_go_on(case, parts):
    with pytest.raises(DocumentError) as reason:
        load_measurements(CASES / case)
    assert all(part in str(reason.value) for part in parts), reason.value


@pytest.mark.skipif(not CASES.is_dir(), reason="needs ../shared/cases")
def test_the_import_does_not_ask_to_sort_rows_that_are_in_order():
    maps = {"stress": ("stress", "MPa")}
    with pytest.raises(DocumentError, match="row 161 .*in order, as stretch goes on smoothly"):
        make_set(propose([CASES / "time_glitch" / "u.csv"], maps=maps))


@pytest.mark.skipif(not CASES.is_dir(), reason="needs ../shared/cases")
def test_a_set_of_ros1_bags_is_read():
    (first, *_) = load_measurements(CASES / "bag_ros1").runs
    assert first.samples > 50 and np.ptp(first.columns["tip_angle"]) > 0.3
