"""Tables as plain loggers and spreadsheets have them: repeats side by side, raw readings beside
calibrated ones, standard deviations, volts, milliseconds by name.
"""

import numpy as np
import openpyxl
import pytest

from model_lab.cli.main import main
from model_lab.importing.importing import make_set, propose
from model_lab.importing.told import table_rows
from model_lab.measurements.load import load_measurements
from softhand_common.documents.yaml_document import DocumentError

PRESSURE = np.linspace(0.0, 40.0, 21)  # [kPa]
ANGLE = 2.0 * PRESSURE  # [deg]


def table(path, header, *columns):
    rows = "\n".join(",".join(f"{value:g}" for value in row) for row in zip(*columns, strict=True))
    path.write_text(f"{header}\n{rows}\n")
    return path


def means(path):
    return {one.quantity: one.column for one in propose([path]).sources[0].meanings}


@pytest.mark.parametrize(
    "header",
    [
        "Pressure (kPa),Trial 1 (deg),Trial 2 (deg),Trial 3 (deg)",
        "Pressure (kPa),Angle run1 (deg),Angle run2 (deg),Angle run3 (deg)",
        "Druck [kPa],Winkel Versuch 1 [°],Winkel Versuch 2 [°],Winkel Versuch 3 [°]",
        "Pressure (kPa),Angle 1 (deg),Angle 2 (deg),Angle 3 (deg)",
    ],
)
def test_columns_of_repeats_are_runs(tmp_path, header):
    path = table(tmp_path / "bending.csv", header, PRESSURE, ANGLE, ANGLE + 1.0, ANGLE - 1.0)
    found = make_set(propose([path]))
    assert len(found.runs) == 3
    for run, more in zip(found.runs, (0.0, 1.0, -1.0), strict=True):
        np.testing.assert_allclose(run.columns["pressure"], PRESSURE)
        np.testing.assert_allclose(run.columns["tip_angle"], ANGLE + more)
    assert any("taken as 3 runs" in remark for remark in found.remarks)


@pytest.mark.parametrize(
    "header",
    [
        "Pressure (kPa),Finger 1 (N),Finger 2 (N)",
        "Druck [kPa],Kraft Finger 1 [N],Kraft Finger 2 [N]",
    ],
)
def test_columns_of_specimens_are_runs_of_each(tmp_path, header):
    path = table(tmp_path / "blocked.csv", header, PRESSURE, 0.02 * PRESSURE, 0.03 * PRESSURE)
    found = make_set(propose([path]))
    assert [run["specimen"] for run in found.document["runs"].values()] == ["Finger1", "Finger2"]
    for run, slope in zip(found.runs, (0.02, 0.03), strict=True):
        np.testing.assert_allclose(run.columns["tip_force"], slope * PRESSURE)


def test_runs_with_dates_are_in_the_order_of_their_dates(tmp_path):
    for name, hour in (("again", 11), ("first", 9), ("middle", 10)):
        rows = "\n".join(
            f"2026-11-02T{hour:02}:00:{second:02},{second},{2 * second}" for second in range(20)
        )
        (tmp_path / f"{name}.csv").write_text(f"stamp,p [kPa],angle [deg]\n{rows}\n")
    found = make_set(propose(sorted(tmp_path.iterdir())))
    assert [*found.document["runs"]] == ["first", "middle", "again"]
    assert any("taken as recorded in this order" in remark for remark in found.remarks)


def test_an_option_may_stand_for_many_files(tmp_path):
    paths = [
        table(tmp_path / f"{name}.csv", "p [kPa],angle [deg]", PRESSURE, ANGLE)
        for name in ("thin_up_1", "thin_up_2", "thick_up_1")
    ]
    found = make_set(propose(paths), specimens={"thin*": "P3", "thick_up_1.csv": "P5"})
    assert [run["specimen"] for run in found.document["runs"].values()] == ["P3", "P3", "P5"]
    with pytest.raises(DocumentError, match="--specimen: expected one of the files"):
        make_set(propose(paths), specimens={"wide*": "P9"})


@pytest.mark.parametrize(
    "header", ["specimen;trial;p (kPa);angle (deg)", "Probe;Versuch;Druck kPa;Winkel [°]"]
)
def test_runs_one_below_the_other_are_parted_by_the_columns_that_name_them(tmp_path, header):
    rows = [
        f"{name};{trial};{pressure:g};{slope * pressure + trial:g}"
        for name, slope in (("thin", 2.0), ("thick", 1.5))
        for trial in (1, 2)
        for pressure in PRESSURE
    ]
    path = tmp_path / "all.csv"
    path.write_text("\n".join([header, *rows]))
    found = make_set(propose([path]))
    names = [f"all_{name}_{trial}" for name in ("thin", "thick") for trial in (1, 2)]
    assert [run.name for run in found.runs] == names
    np.testing.assert_allclose(found.runs[3].columns["tip_angle"], 1.5 * PRESSURE + 2.0)
    runs = found.document["runs"]
    assert [runs[name]["specimen"] for name in names] == ["thin", "thin", "thick", "thick"]
    assert len({runs[name]["protocol"] for name in names}) == 1
    assert sum("are 4 runs" in remark for remark in found.remarks) == 1


def workbook(path, headers):
    """A spreadsheet with one run per sheet, named by number."""
    book = openpyxl.Workbook()
    book.remove(book.active)
    for number, header in enumerate(headers, 1):
        sheet = book.create_sheet(f"{'run' if number < 3 else 'half'} {number}")
        for row in [header, *zip(PRESSURE, number * PRESSURE, strict=True)]:
            sheet.append(list(row))
    book.save(path)
    return path


def test_sheets_with_the_same_columns_are_runs(tmp_path):
    path = workbook(tmp_path / "day.xlsx", 3 * [("p (kPa)", "angle (deg)")])
    found = make_set(propose([path]))
    assert [run.name for run in found.runs] == ["day_run-1", "day_run-2", "day_half-3"]
    np.testing.assert_allclose(found.runs[1].columns["tip_angle"], 2.0 * PRESSURE)
    (only,) = make_set(propose([path], sheets={"": "run 2"})).runs
    assert only.name == "day"


def test_sheets_with_other_columns_are_asked_for_and_named_once(tmp_path, capsys):
    headers = [("p (kPa)", "angle (deg)"), ("p (kPa)", "force (N)")]
    path = workbook(tmp_path / "day.xlsx", headers)
    with pytest.raises(DocumentError, match="--sheet 'run 1'"):
        propose([path])
    twice = ["--sheet", "run 1", "--sheet", "run 2"]
    assert main(["import", str(path), "-o", str(tmp_path / "set"), *twice]) == 2
    assert "--sheet: expected all files once, got this twice" in capsys.readouterr().err


def test_whole_numbers_that_repeat_are_readings_where_the_name_says_more(tmp_path):
    steps = np.repeat([0.0, 10.0, 20.0, 30.0], 5)
    header = "t (s),finger pressure (kPa),test angle (deg)"
    path = table(tmp_path / "steps.csv", header, np.arange(20.0) / 7.0, steps, 2.0 * steps)
    (run,) = make_set(propose([path])).runs
    np.testing.assert_allclose(run.columns["pressure"], steps)


def test_a_number_of_each_sample_and_words_of_a_phase_part_nothing(tmp_path):
    path = tmp_path / "one.csv"
    rows = [
        f"{place},{0.1 * place:g},{'up' if place < 11 else 'down'},{pressure:g},{2.0 * pressure:g}"
        for place, pressure in enumerate(PRESSURE)
    ]
    path.write_text("\n".join(["sample,t (s),phase,p (kPa),angle (deg)", *rows]))
    (run,) = make_set(propose([path])).runs
    assert len(run.columns["pressure"]) == len(PRESSURE)


def test_angles_with_a_number_alone_may_be_those_of_joints_and_are_asked_for(tmp_path):
    header = "Pressure (kPa),Angle 1 (deg),Angle 2 (deg)"
    with pytest.raises(DocumentError, match="expected one column for tip_angle"):
        propose([table(tmp_path / "bending.csv", header, PRESSURE, ANGLE, ANGLE)])


def test_raw_readings_and_standard_deviations_give_way_to_what_was_measured(tmp_path):
    header = "millis,pressure_raw,pressure_kPa,angle mean (deg),angle SD (deg)"
    columns = 50.0 * np.arange(21.0), PRESSURE + 512.0, PRESSURE, ANGLE, 0.0 * ANGLE + 1.0
    path = table(tmp_path / "log.csv", header, *columns)
    assert means(path) == {"time": "millis", "pressure": "pressure", "tip_angle": "angle mean"}
    (run,) = make_set(propose([path])).runs
    np.testing.assert_allclose(run.columns["pressure"], PRESSURE)
    assert run.columns["time"][-1] == pytest.approx(1.0)


def test_a_sensor_in_volts_is_calibrated_by_slope_and_offset(tmp_path, capsys):
    path = table(tmp_path / "v.csv", "p_sensor (V),angle (deg)", 0.5 + PRESSURE / 50.0, ANGLE)
    command = ["import", str(path), "-o", str(tmp_path / "set"), "--yes"]
    assert main([*command, "--map=pressure=p_sensor"]) == 2
    assert "linear(p_sensor,SLOPE,OFFSET):UNIT'" in capsys.readouterr().err
    assert main([*command, "--map=pressure=linear(p_sensor,50):kPa"]) == 2
    assert "a slope and an offset" in capsys.readouterr().err
    assert main([*command, "--map=pressure=linear(p_sensor,50,-25):kPa"]) == 0
    (run,) = load_measurements(tmp_path / "set").runs
    np.testing.assert_allclose(run.columns["pressure"], 1e3 * PRESSURE, atol=1e-2)


def test_the_position_of_the_tip_alone_is_proposed_as_a_chord_from_the_base(tmp_path):
    half = np.deg2rad(ANGLE) / 2.0
    columns = PRESSURE, 90.0 * np.cos(half), 90.0 * np.sin(half)
    path = table(tmp_path / "tip.csv", "pressure (kPa),x (mm),y (mm)", *columns)
    told = propose([path]).unsure["the tip angle"]
    assert "--map 'tip_angle=tip(x,y)'" in told and "0 at the base" in told
    (run,) = make_set(propose([path], maps={"tip_angle": ("tip(x,y)", "")})).runs
    np.testing.assert_allclose(run.columns["tip_angle"], np.deg2rad(ANGLE), atol=1e-4)


def test_what_is_not_known_of_a_file_is_said_by_quantity(tmp_path):
    path = table(tmp_path / "imu.csv", "pressure (kPa),pitch,roll", PRESSURE, ANGLE, 0.0 * ANGLE)
    told = propose([path]).unsure["what was measured"]
    assert told == "--map tip_angle=COLUMN:UNIT or --map tip_force=COLUMN:UNIT"


STAMPED = "14:05:{second:06.3f} -> "


@pytest.mark.parametrize(
    ("line", "maps"),
    [
        (
            "pressure:{p:.2f},angle:{a:.2f}",
            {"pressure": ("pressure", "kPa"), "tip_angle": ("angle", "deg")},
        ),
        ("Time: {t:.2f} s, Pressure: {p:.2f} kPa, Angle: {a:.2f} deg", None),
        ("t={t:.2f}\tp_kPa={p:.2f}\tangle_deg={a:.2f}", None),
        ('{{"time": {t:.2f}, "tip": {{"angle_deg": {a:.2f}}}, "pressure_kpa": {p:.2f}}}', None),
        (STAMPED + "Pressure: {p:.2f} kPa | Angle: {a:.2f} deg", None),
        (
            STAMPED + "{p:.2f},{a:.2f}",
            {"pressure": ("column 2", "kPa"), "tip_angle": ("column 3", "deg")},
        ),
    ],
)
def test_what_microcontrollers_print_is_a_table(tmp_path, line, maps):
    path, time = tmp_path / "serial.txt", 0.1 * np.arange(len(PRESSURE))
    lines = [
        line.format(t=t, p=p, a=a, second=23.0 + t)
        for t, p, a in zip(time, PRESSURE, ANGLE, strict=True)
    ]
    first = ["Starting..."] if not line.startswith(STAMPED) else ["14:05:22.500 -> Starting..."]
    path.write_text("\n".join([*first, *lines]) + "\n")
    run = make_set(propose([path], maps=maps)).runs[0]
    np.testing.assert_allclose(run.columns["pressure"], PRESSURE)
    np.testing.assert_allclose(run.columns["tip_angle"], ANGLE)
    if maps is None or line.startswith(STAMPED):
        np.testing.assert_allclose(run.columns["time"], time, atol=1e-6)


def test_a_few_lines_with_names_do_not_make_a_table(tmp_path):
    header = ["rate: 100 Hz, sensors: 2", "pressure (kPa),angle (deg)"]
    rows = [f"{p:g},{a:g}" for p, a in zip(PRESSURE, ANGLE, strict=True)]
    path = tmp_path / "r.csv"
    path.write_text("\n".join(header + rows))
    np.testing.assert_allclose(make_set(propose([path])).runs[0].columns["tip_angle"], ANGLE)


def test_columns_of_many_files_alike_are_shown_once_or_twice(tmp_path):
    header = "Pressure (kPa),Angle (deg)"
    files = [
        table(tmp_path / f"run_{number}.csv", header, PRESSURE, number * ANGLE)
        for number in (1, 2, 3, 4)
    ]
    other = table(tmp_path / "other.csv", "Angle (rad),Pressure (bar)", ANGLE, PRESSURE)
    rows = table_rows(propose([*files, other]))[1:]
    shown = [row[0] for row in rows]
    assert (
        shown
        == ["run_1.csv"] * 2 + ["run_2.csv"] * 2 + ["run_3.csv", "run_4.csv"] + ["other.csv"] * 2
    )
    assert [row[1] for row in rows[4:6]] == ["as in run_1.csv"] * 2
