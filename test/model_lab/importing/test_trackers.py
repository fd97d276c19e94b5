"""Files as trackers and data acquisition write them, with several lines of header."""

import re

import numpy as np
import pytest

from model_lab.cli.main import main
from model_lab.importing import derived
from model_lab.importing.importing import propose
from model_lab.measurements.load import load_measurements

TIME = np.arange(0.0, 6.0, 0.04)
PRESSURE = 40.0 * np.sin(np.pi * TIME / 6.0) ** 2  # [kPa]
ANGLE = np.radians(3.0 * PRESSURE)
LENGTH = 90.0
POSE = ["Rotation"] * 4 + ["Position"] * 3 + ["Mean Marker Error"]
MARKER = ["Position"] * 3
MOTIVE = [
    "Format Version,1.23,Take Name,Take 1,Rotation Type,Quaternion,Length Units,Meters\n",
    ",".join(["", "", *["Rigid Body"] * 8, *["Marker"] * 3]),
    ",".join(["", "", *["{body}"] * 8, *["one"] * 3]),
    ",".join(["", "", *['"3C0E"'] * 8, *['"1:7"'] * 3]),
    ",".join(["", "", *POSE, *MARKER]),
    "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,,X,Y,Z\n",
]
LVM = """LabVIEW Measurement
Separator\tTab
X_Columns\tOne
***End_of_Header***

Channels\t1
Delta_X\t0.040000
***End_of_Header***
X_Value\tPressure\tComment
"""


def arc(share):
    """x and y (samples,) at a share of the length of an arc."""
    bend = np.where(ANGLE < 1e-9, 1e-9, ANGLE)
    radius, along = LENGTH / bend, share * bend
    return radius * np.sin(along), radius * (1.0 - np.cos(along))


def write(path, header, columns, delimiter=","):
    rows = [delimiter.join(f"{value:.7f}" for value in row) for row in zip(*columns, strict=True)]
    path.write_text(header + "\n".join(rows) + "\n")
    return path


def pressures(tmp_path):
    return write(tmp_path / "log.csv", "time_s,pressure_kPa\n", [TIME, PRESSURE])


def motive(tmp_path, body="tip"):
    zero = 0.0 * TIME
    turn = [zero, np.sin(ANGLE / 2.0), zero, np.cos(ANGLE / 2.0)]
    x, y = arc(1.0)
    place = [x, zero, y]
    columns = [np.arange(len(TIME)), TIME, *turn, *place, zero + 3e-4, *place]
    return write(tmp_path / "take.csv", "\n".join(MOTIVE).format(body=body), columns)


def deep_lab_cut(tmp_path):
    shares = {"base": 0.0, "middle": 0.4, "end": 1.0}
    bodies = "".join(f",{name}" * 3 for name in shares)
    header = f"scorer{',net' * 9}\nbodyparts{bodies}\ncoords{',x,y,likelihood' * 3}\n"
    points = [value for share in shares.values() for value in (*arc(share), 0.0 * TIME + 0.99)]
    return write(tmp_path / "video.csv", header, [np.arange(len(TIME)), *points])


def check(tmp_path, files, *options):
    """The command that is proposed makes the set."""
    (how,) = (text for what, text in propose(files).unsure.items() if what == "the tip angle")
    call = re.fullmatch("--map '(.*)'", how)[1]
    options = ("--map", call, *options, "--hand", "rbo_hand_2:index", "--yes")
    assert main(["import", *map(str, files), "-o", str(tmp_path / "set"), *options]) == 0
    columns = load_measurements(tmp_path / "set").runs[0].columns
    np.testing.assert_allclose(columns["time"], TIME, atol=1e-6)
    np.testing.assert_allclose(columns["pressure"], PRESSURE * 1e3, atol=0.1)
    np.testing.assert_allclose(columns["tip_angle"], ANGLE, atol=2e-5)


@pytest.mark.parametrize("body", ["tip", "Rigid Body 1"])
def test_motive_writes_five_lines_of_header(tmp_path, body):
    check(tmp_path, [pressures(tmp_path), motive(tmp_path, body)])


def test_markers_of_deep_lab_cut_have_frames_in_place_of_times(tmp_path):
    files = [pressures(tmp_path), deep_lab_cut(tmp_path)]
    check(tmp_path, files, "--map", "time=bodyparts coords:25Hz")


def test_a_column_that_counts_evenly_is_asked_for_its_unit(tmp_path):
    unsure = propose([deep_lab_cut(tmp_path)]).unsure
    assert "30Hz" in unsure["the unit of bodyparts coords"]


def test_numbers_of_readings_taken_by_hand_are_no_time(tmp_path):
    header = "Step,p [kPa],angle [deg]\n"
    table = write(tmp_path / "hand.csv", header, [range(12)] * 3)
    proposal = propose([table])
    assert not proposal.unsure
    assert {meant.quantity for meant in proposal.sources[0].meanings} == {"pressure", "tip_angle"}


def test_lvm_has_a_name_for_a_comment_beside_the_numbers(tmp_path):
    log = write(tmp_path / "log.lvm", LVM, [TIME, PRESSURE], delimiter="\t")
    table = propose([log]).sources[0].table
    assert [column.name for column in table.columns] == ["X_Value", "Pressure"]
    options = ("--map", "time=X_Value:s", "--map", "pressure=Pressure:kPa")
    files = [log, motive(tmp_path)]
    check(tmp_path, files, *options)


def test_units_in_the_header_of_lvm_are_read(tmp_path):
    units = "Y_Unit_Label\tkPa\nX_Dimension\tTime\nDelta_X"
    log = write(tmp_path / "log.lvm", LVM.replace("Delta_X", units), [TIME, PRESSURE], "\t")
    check(tmp_path, [log, motive(tmp_path)])


def test_three_markers_in_a_plane_are_not_two_in_space():
    points = np.concatenate([arc(0.0), arc(0.4), arc(1.0)])
    np.testing.assert_allclose(derived.plane_markers_angle(points), ANGLE, atol=1e-6)
    assert np.abs(derived.markers_angle(points) - ANGLE).max() > 0.5


@pytest.mark.parametrize(
    ("header", "values", "call", "unit"),
    [
        ("kappa [1/m]", ANGLE / 0.09, "curvature(kappa,90mm)", ""),
        ("kappa", ANGLE / 9.0, "curvature(kappa,9 cm)", ":1/cm"),
        ("R (mm)", LENGTH / (ANGLE + 0.2), "radius(R,0.09m)", ""),
    ],
)
def test_an_angle_is_made_of_a_curvature_and_the_length_that_bends(
    tmp_path, header, values, call, unit
):
    file = write(tmp_path / "arc.csv", f"time_s,pressure_kPa,{header}\n", [TIME, PRESSURE, values])
    out = tmp_path / "set"
    wanted = ["-o", str(out), "--hand", "rbo_hand_2:index", "--yes"]
    assert main(["import", str(file), *wanted, "--map", f"tip_angle={call}{unit}"]) == 0
    (run,) = load_measurements(out).runs
    np.testing.assert_allclose(run.columns["tip_angle"], ANGLE, atol=1e-5)


@pytest.mark.parametrize(
    "wrong", ["curvature(kappa)", "curvature(kappa,90)", "curvature(kappa,LENGTH)"]
)
def test_a_curvature_without_a_length_is_refused(tmp_path, wrong, capsys):
    file = write(tmp_path / "arc.csv", "time_s,pressure_kPa,kappa [1/m]\n", [TIME, PRESSURE, ANGLE])
    out = ["-o", str(tmp_path / "set"), "--yes"]
    assert main(["import", str(file), *out, "--map", f"tip_angle={wrong}"]) == 2
    assert "curvature(kappa,90mm)" in capsys.readouterr().err
