"""Files as people have them become the same numbers, and what is open is named."""

import re
import shlex

import numpy as np
import openpyxl
import pytest

from model_lab.cli.main import main
from model_lab.importing.importing import make_set, propose
from model_lab.importing.runs import ImportedRun, clock_offset, remarks_on_clocks
from model_lab.measurements.load import load_measurements
from softhand_common.documents.yaml_document import DocumentError

TIME = np.arange(0.0, 6.0, 0.25)
PRESSURE = 40.0 * np.sin(np.pi * TIME / 6.0) ** 2  # [kPa]
ANGLE = 2.0 * PRESSURE + 0.01 * PRESSURE**2  # [deg]
HAND = "rbo_hand_2:index"


def write(path, header, *columns, sign=".", delimiter=",", encoding="utf-8", before="", after=""):
    rows = [
        delimiter.join(f"{v:.6f}".replace(".", sign) for v in row)
        for row in zip(*columns, strict=True)
    ]
    path.write_text(before + "\n".join([header, *rows]) + after + "\n", encoding=encoding)
    return path


def numbers(folder):
    run = load_measurements(folder).runs[0]
    return run.columns["time"], run.columns["pressure"], run.columns["tip_angle"]


def check(folder):
    time, pressure, angle = numbers(folder)
    np.testing.assert_allclose(time, TIME, atol=1e-5)
    np.testing.assert_allclose(pressure, PRESSURE * 1e3, atol=0.2)
    np.testing.assert_allclose(angle, np.radians(ANGLE), atol=1e-5)


DIALECTS = {
    "plain": ("time [s],pressure [kPa],tip_angle [deg]", {}, 1.0),
    "semicolons and decimal commas": (
        "Zeit [s];Druck [mbar];Winkel [°]",
        {"sign": ",", "delimiter": ";", "encoding": "latin-1"},
        10.0,
    ),
    "tabs and UTF-16": (
        "t (s)\tp (kPa)\tangle (deg)",
        {"delimiter": "\t", "encoding": "utf-16"},
        1.0,
    ),
    "blanks and comment sign": ("# t_s p_kPa angle_deg", {"delimiter": " "}, 1.0),
    "byte order mark": ("temps [s],pression [hPa],angle [deg]", {"encoding": "utf-8-sig"}, 10.0),
    "preamble and footer": (
        "Time (s);Pressure (bar);Bending angle (deg)",
        {"delimiter": ";", "before": "Specimen;A\nMachine;X\n\n", "after": "\nend of file"},
        0.01,
    ),
    "row of units": ("Time,Pressure,Angle\ns,kPa,deg", {}, 1.0),
    "row of units in brackets": ("Time|Pressure|Angle\n[s]|[kPa]|[deg]", {"delimiter": "|"}, 1.0),
}


@pytest.mark.parametrize("dialect", DIALECTS)
def test_files_of_many_dialects_hold_the_same_numbers(dialect, tmp_path, capsys):
    header, given, scale = DIALECTS[dialect]
    file = write(tmp_path / "r1.csv", header, TIME, PRESSURE * scale, ANGLE, **given)
    assert main(["import", str(file), "-o", str(tmp_path / "set"), "--hand", HAND, "--yes"]) == 0
    check(tmp_path / "set")
    assert "model-lab import" in capsys.readouterr().out


def test_what_is_not_known_is_named_with_what_to_add(tmp_path):
    file = write(tmp_path / "r1.csv", "time,pressure,tip_angle", TIME, PRESSURE, ANGLE)
    proposal = propose([file])
    assert proposal.unsure == {
        "the unit of pressure": "--map 'pressure=pressure:UNIT'",
        "the unit of tip_angle": "--map 'tip_angle=tip_angle:UNIT'",
    }
    with pytest.raises(DocumentError, match="the unit of pressure"):
        make_set(proposal)
    told = propose(
        [file], maps={"pressure": ("pressure", "kPa"), "tip_angle": ("tip_angle", "deg")}
    )
    make_set(told, HAND).write(tmp_path / "set")
    check(tmp_path / "set")


def test_two_files_of_one_run_keep_the_stamps_of_the_output_and_tell_a_late_clock(tmp_path):
    write(tmp_path / "druck.csv", "Zeit [s],Druck [kPa]", TIME, PRESSURE)
    late = TIME[8:-4] + 1.0
    write(tmp_path / "winkel.csv", "Zeit [s],Winkel [deg]", late, ANGLE[8:-4])
    proposal = propose([tmp_path / "druck.csv", tmp_path / "winkel.csv"])
    found = make_set(proposal, HAND)
    assert "1.00 s late" in found.remarks[0]
    mended = make_set(proposal, HAND, {"winkel.csv": -1.0})
    np.testing.assert_allclose(mended.runs[0].columns["time"], TIME[8:-4], atol=1e-6)
    np.testing.assert_allclose(mended.runs[0].columns["pressure"], PRESSURE[8:-4], atol=1e-6)
    np.testing.assert_allclose(mended.runs[0].lead["time"], TIME[:8], atol=1e-6)
    assert not mended.remarks


def test_files_of_one_clock_are_late_by_the_same_time():
    def late(*offsets):
        runs = [ImportedRun(f"r{k}", {}, {}, (), (), (f"{k}.csv", o)) for k, o in offsets]
        return [re.search("=(.*) corrects", said)[1] for said in remarks_on_clocks(runs)]

    assert late((1, 0.33), (2, 0.35), (3, 0.37)) == ["-0.35"] * 3
    assert late((1, 0.3), (2, 2.0)) == ["-0.3", "-2"]


def test_no_offset_is_told_where_a_sensor_is_only_noisy():
    told = []
    for seed in range(50):
        random = np.random.default_rng(seed)
        noisy = ANGLE + random.normal(0.0, 4.0, len(ANGLE))
        told.append(clock_offset(TIME, PRESSURE, TIME, noisy))
    assert not any(told)


def test_a_unit_of_another_quantity_is_refused_with_the_option_that_gave_it(tmp_path):
    file = write(tmp_path / "r1.csv", "time,pressure,tip_angle", TIME, PRESSURE, ANGLE)
    with pytest.raises(DocumentError, match=r"expected a unit of pressure, got deg \(--map"):
        propose([file], maps={"pressure": ("pressure", "deg")})


# ---------------------------------------------------------------------- specimens
BEND = ("time [s],pressure [kPa],tip_angle [deg]", TIME, PRESSURE, ANGLE)


def of_names(tmp_path, names, *options):
    files = [write(tmp_path / f"{name}.csv", *BEND) for name in names]
    out = tmp_path / "set"
    command = ["import", *map(str, files), "-o", str(out), "--hand", HAND, "--yes", *options]
    assert main(command) == 0
    return {run.name: (run.specimen, run.protocol) for run in load_measurements(out).runs}


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["thin_1", "thin_2", "thick_1"], [("thin", "run"), ("thin", "run"), ("thick", "run")]),
        (
            ["thin_ramp_1", "thin_half_1", "thick_ramp_1"],
            [("thin", "ramp"), ("thin", "half"), ("thick", "ramp")],
        ),
        (["finger_A_1", "finger_B_1"], [("A", "finger"), ("B", "finger")]),
        (["ramp_1", "ramp_2", "half_1"], [("index", "ramp"), ("index", "ramp"), ("index", "half")]),
        (["run1", "run2"], [("index", "run"), ("index", "run")]),
        (["pull1_slow", "pull2_slow"], [("index", "pull_slow"), ("index", "pull_slow")]),
        (["01_ramp", "02_ramp"], [("index", "ramp"), ("index", "ramp")]),
        (["20kPa_1", "40kPa_1"], [("index", "20kPa"), ("index", "40kPa")]),
        (["ramp_1", "thick_ramp_1"], [("index", "ramp"), ("index", "thick_ramp")]),
    ],
)
def test_names_of_files_say_specimens_and_protocols(tmp_path, names, expected, capsys):
    assert list(of_names(tmp_path, names).values()) == expected
    output = capsys.readouterr().out
    several = len({specimen for specimen, _ in expected}) > 1
    assert ("are taken as 2 specimens" in output) == several
    assert ("may name another" in output) == (
        names[0] == "ramp_1" and several is False and "thick_ramp_1" in names
    )


def test_one_specimen_can_be_said(tmp_path, capsys):
    found = of_names(tmp_path, ["thin_1", "thick_1"], "--specimen", "mine")
    assert found == {"thin_1": ("mine", "thin"), "thick_1": ("mine", "thick")}
    assert "--specimen mine" in capsys.readouterr().out


def test_what_is_taken_as_repeats_is_told_and_how_to_say_otherwise(tmp_path, capsys):
    names = ["left_1", "left_2", "right_1"]
    of_names(tmp_path, names)
    told = capsys.readouterr().out
    assert "taken as repeats, whose differences are noise: left_1 = left_2; if" in told
    said = [word for name in names for word in ("--specimen", f"{name}.csv={name}")]
    found = of_names(tmp_path, names, *said, "--force")
    assert [specimen for specimen, _ in found.values()] == names
    told = capsys.readouterr().out
    assert "taken as repeats" not in told and "--specimen left_1.csv=left_1" in told


@pytest.mark.parametrize(
    ("drives", "expected"),
    [
        ([(1.0, 1.0), (1.1, 1.3), (0.9, 0.8)], ["run", "run", "run"]),  # by hand
        ([(1.0, 1.0), (0.5, 1.0), (1.05, 1.0)], ["run", "run_b", "run"]),  # half the pressure
        ([(1.0, 1.0), (1.0, 4.0), (0.5, 4.0), (1.0, 3.8)], ["run", "run_b", "run_c", "run_b"]),
    ],
)
def test_runs_that_were_driven_otherwise_are_no_repeats(drives, expected, tmp_path, capsys):
    rng = np.random.default_rng(3)
    for number, (level, slower) in enumerate(drives, 1):
        noisy = level * PRESSURE + 0.1 * rng.standard_normal(len(PRESSURE))
        columns = (slower * TIME, noisy, ANGLE)
        write(tmp_path / f"run{number}.csv", "time [s],pressure [kPa],tip_angle [deg]", *columns)
    files, out = sorted(map(str, tmp_path.glob("*.csv"))), tmp_path / "set"
    assert main(["import", *files, "-o", str(out), "--hand", HAND, "--yes"]) == 0
    assert [run.protocol for run in load_measurements(out).runs] == expected
    told = capsys.readouterr().out
    apart = [f"run{at}" for at, name in enumerate(expected, 1) if name != "run"]
    assert ("driven to another level or at another pace" in told) == bool(apart)
    assert f"{', '.join(apart)}: driven" in told or not apart


@pytest.mark.parametrize("option", ["--shift", "--specimen"])
def test_what_is_said_of_an_unknown_file_is_refused(option, tmp_path, capsys):
    file = write(tmp_path / "bent.csv", *BEND)
    command = ["import", str(file), "-o", str(tmp_path / "set"), option, "other.csv=1", "--yes"]
    assert main(command) == 2
    said = capsys.readouterr().err
    assert f"{option}: expected one of the files bent.csv, got other.csv" in said


def test_a_clock_that_is_not_there_is_not_shifted(tmp_path):
    file = write(tmp_path / "bent.csv", "pressure [kPa],angle [deg]", PRESSURE, ANGLE)
    with pytest.raises(DocumentError, match="expected a file with a column of time"):
        make_set(propose([file]), shifts={"bent.csv": 1.0})


def test_the_next_commands_run_without_dimensions_too(tmp_path, capsys):
    file = write(tmp_path / "bent_1.csv", *BEND)
    assert main(["import", str(file), "-o", str(tmp_path / "set"), "--yes"]) == 0
    following = capsys.readouterr().out.split("Next:")[1].split("\n")[1]
    assert main(shlex.split(following)[1:]) == 0


def test_how_far_strips_were_stretched_before(tmp_path, capsys):
    stretch = 1.0 + TIME / 6.0
    pulls = ("time [s],stretch [-],stress [kPa]", TIME, stretch, 67.0 * (stretch - stretch**-2))
    files = [str(write(tmp_path / f"pull_{n}.csv", *pulls)) for n in (1, 2)]
    command = ["import", *files, "-o", str(tmp_path / "set"), "--yes", "--stretched-to", "2"]
    assert main([*command, "--stretched-to", "pull_2.csv=2.5"]) == 0
    runs = load_measurements(tmp_path / "set").runs
    assert [run.stretched_to for run in runs] == [2.0, 2.5]
    assert "--stretched-to 2 --stretched-to pull_2.csv=2.5" in capsys.readouterr().out
    assert main([*command, "--stretched-to", "other.csv=2.5", "--force"]) == 2
    assert "pull_1.csv" in capsys.readouterr().err
    bent = str(write(tmp_path / "bent_1.csv", *BEND))
    assert main(["import", bent, "-o", str(tmp_path / "b"), "--yes", "--stretched-to", "2"]) == 2
    assert "--stretched-to: expected an experiment whose input" in capsys.readouterr().err


@pytest.mark.parametrize("names", [("Solldruck", "Istdruck"), ("p_set", "p_meas"), ("p", "p_cmd")])
def test_what_was_asked_of_a_regulator_is_not_what_was_measured(tmp_path, names):
    asked = {"Solldruck", "p_set", "p_cmd"}
    columns = [np.round(PRESSURE) if name in asked else PRESSURE for name in names]
    header = ",".join(["t [s]", *(f"{name} [kPa]" for name in names), "angle [deg]"])
    file = write(tmp_path / "r1.csv", header, TIME, *columns, ANGLE)
    make_set(propose([file]), HAND).write(tmp_path / "set")
    check(tmp_path / "set")


def test_sheets_that_name_fingers_are_a_run_of_each(tmp_path):
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, factor in (("Finger A", 1.0), ("Finger B", 0.5)):
        sheet = book.create_sheet(name)
        sheet.append(["t [s]", "p [kPa]", "angle [deg]"])
        for row in zip(TIME, PRESSURE, ANGLE, strict=True):
            sheet.append([row[0], row[1], factor * row[2]])
    book.save(tmp_path / "fingers.xlsx")
    found = make_set(propose([tmp_path / "fingers.xlsx"]))
    first, second = (run.columns["tip_angle"] for run in found.runs)
    assert list(found.document["specimens"]) == ["A", "B"]
    np.testing.assert_allclose(second, 0.5 * first)


def test_of_several_sheets_the_one_that_is_said_is_read(tmp_path, capsys):
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, factor in (("Raw data", 1.0), ("Half", 0.5), ("Notes", None)):
        sheet = book.create_sheet(name)
        sheet.append(["t [s]", "p [kPa]", "angle [deg]"])
        for row in zip(TIME, PRESSURE, ANGLE, strict=True) if factor else []:
            sheet.append([row[0], row[1], factor * row[2]])
    file = tmp_path / "r1.xlsx"
    book.save(file)
    command = ["import", str(file), "-o", str(tmp_path / "set"), "--yes", "--hand", HAND]
    assert main(command) == 2
    line = capsys.readouterr().err
    assert "Raw data" in line and "Half" in line and "Notes" not in line
    assert "--sheet 'Raw data'" in line
    assert main([*command, "--sheet", "Raw data"]) == 0
    check(tmp_path / "set")
    again = capsys.readouterr().out.split("The same again:\n")[1].splitlines()[0]
    assert main([*shlex.split(again)[1:], "--force"]) == 0
    assert main([*command, "--sheet", "r1.xlsx=Half", "--force"]) == 0
    np.testing.assert_allclose(numbers(tmp_path / "set")[2], np.radians(ANGLE / 2), atol=1e-5)
    capsys.readouterr()
    for wrong, words in (("half", "Raw data, Half, Notes"), ("r2.xlsx=Half", "r1.xlsx")):
        assert main([*command, "--sheet", wrong, "--force"]) == 2
        assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("header", "factor"),
    [("Dehnung in %", 100.0), ("Dehnung [%]", 100.0), ("Dehnung", 100.0), ("Dehnung", 1.0)],
)
def test_a_strain_is_in_percent_where_its_header_says_so_or_it_would_be_too_large(
    header, factor, tmp_path
):
    strain = 0.8 * np.sin(np.pi * TIME / 6.0) ** 2
    file = write(
        tmp_path / "pull.csv", f"Zeit in s,{header},Spannung in kPa", TIME, factor * strain, strain
    )
    assert main(["import", str(file), "-o", str(tmp_path / "set"), "--yes"]) == 0
    found = load_measurements(tmp_path / "set").runs[0].columns["stretch"]
    np.testing.assert_allclose(found, 1.0 + strain, atol=1e-5)


@pytest.mark.parametrize(
    ("column", "scale", "expected"),
    [
        ("Std [deg]", 1.0, 0.5),
        ("angle sd (mrad)", 17.453, 0.5),
        ("standard deviation", 1.0, 0.5),
        ("pressure std [kPa]", 1.0, None),
        ("std [%]", 1.0, None),
        ("deviation [mm]", 1.0, None),
    ],
)
def test_a_column_of_standard_deviations_is_the_noise(column, scale, expected, tmp_path, capsys):
    header = f"Pressure [kPa],Mean angle [deg],{column}"
    file = write(tmp_path / "table.csv", header, PRESSURE, ANGLE, np.full(len(TIME), 0.5 * scale))
    out = tmp_path / "set"
    assert main(["import", str(file), "-o", str(out), "--hand", HAND, "--yes"]) == 0
    noise = load_measurements(out).noise
    told = "noise: 0.5 deg of tip_angle" in capsys.readouterr().out
    assert told == (expected is not None)
    assert noise == ({"tip_angle": pytest.approx(np.radians(expected))} if expected else {})
