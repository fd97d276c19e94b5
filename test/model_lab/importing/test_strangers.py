"""Files as strangers brought them: what their headers and clocks say is taken as they mean it."""

import numpy as np
import pytest

from model_lab.cli.main import main
from model_lab.importing.importing import make_set, propose
from model_lab.measurements.load import load_measurements
from softhand_common.documents.yaml_document import DocumentError

TIME = np.arange(0.0, 6.0, 0.25)
PRESSURE = 40.0 * np.sin(np.pi * TIME / 6.0) ** 2  # [kPa]
ANGLE = 2.0 * PRESSURE + 0.01 * PRESSURE**2  # [deg]
PSI = 6.894757  # [kPa]
HAND = "rbo_hand_2:index"


def write(path, header, *columns, delimiter=","):
    rows = [delimiter.join(map(str, row)) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


def made(file, folder, **said):
    found = make_set(propose([file], **said), HAND)
    found.write(folder)
    return load_measurements(folder).runs[0].columns, found


def check(columns):
    np.testing.assert_allclose(columns["time"], TIME, atol=1e-5)
    np.testing.assert_allclose(columns["pressure"], PRESSURE * 1e3, atol=0.5)
    np.testing.assert_allclose(columns["tip_angle"], np.radians(ANGLE), atol=1e-5)


@pytest.mark.parametrize(
    ("header", "factor"),
    [
        ("Pressure (psig)", 1.0 / PSI),
        ("p [bar(g)]", 0.01),
        ("P_kPag", 1.0),
        ("Druck [mbar rel.]", 10.0),
    ],
)
def test_a_unit_of_gauge_pressure_is_that_unit(tmp_path, header, factor):
    file = write(tmp_path / "r.csv", f"t [s],{header},angle [deg]", TIME, PRESSURE * factor, ANGLE)
    columns, found = made(file, tmp_path / "set")
    check(columns)
    assert "is" not in found.document["columns"]["pressure"]


def test_runs_in_other_units_are_converted_to_that_of_the_first(tmp_path):
    one = write(tmp_path / "a_1.csv", "t [s],p [kPa],angle [deg]", TIME, PRESSURE, ANGLE)
    other = write(
        tmp_path / "a_2.csv", "t [s],p [psi],angle [rad]", TIME, PRESSURE / PSI, np.radians(ANGLE)
    )
    found = make_set(propose([one, other]), HAND)
    found.write(tmp_path / "set")
    runs = load_measurements(tmp_path / "set").runs
    assert len(runs) == 2
    for run in runs:
        check(run.columns)
    assert found.document["columns"]["pressure"]["unit"] == "kPa"
    assert any("a_2.csv: pressure is in psi, and was converted" in one for one in found.remarks)


@pytest.mark.parametrize(
    ("header", "factor"),
    [
        ("P (psia)", 1.0 / PSI),
        ("pressure [kPa abs]", 1.0),
        ("p [bar (a)]", 0.01),
        ("Absolutdruck [mbar]", 10.0),
        ("p_abs [kPa]", 1.0),
        ("p_abs/hPa", 10.0),
        ("pression absolue (hPa)", 10.0),
    ],
)
@pytest.mark.parametrize("air", [101.325, 96.2])
def test_the_air_is_taken_off_a_pressure_that_is_said_to_be_absolute(tmp_path, header, factor, air):
    absolute = (PRESSURE + air) * factor
    file = write(tmp_path / "r.csv", f"t [s],{header},angle [deg]", TIME, absolute, ANGLE)
    columns, found = made(file, tmp_path / "set")
    check(columns)
    assert any("pressure is absolute" in remark for remark in found.remarks)


def test_absolute_and_gauge_pressures_are_not_put_into_one_set(tmp_path):
    names = {"r1.csv": "p [kPa]", "r2.csv": "p [kPa abs]"}
    files = [
        write(tmp_path / name, f"t [s],{header},angle [deg]", TIME, PRESSURE + 101.0, ANGLE)
        for name, header in names.items()
    ]
    with pytest.raises(DocumentError, match=r"all gauge, got p \(gauge\) and p \(absolute\)"):
        make_set(propose(files), HAND)


def test_the_pressure_of_the_supply_and_counts_are_not_what_was_measured(tmp_path):
    header = "t [s],Supply pressure [kPa],p_amb [kPa],Pressure [kPa],Angle raw [counts],Angle [deg]"
    columns = TIME, 0.0 * TIME + 600.0, 0.0 * TIME + 101.0, PRESSURE, 11.0 * ANGLE, ANGLE
    check(made(write(tmp_path / "r.csv", header, *columns), tmp_path / "set")[0])


def test_a_unit_of_no_pressure_is_named(tmp_path):
    file = write(tmp_path / "r.csv", "t [s],pressure [V],angle [deg]", TIME, PRESSURE, ANGLE)
    (what,) = propose([file]).unsure
    assert what == "the unit of pressure, V in the file"


def test_of_a_printed_topic_the_stamp_of_the_message_is_its_time(tmp_path):
    stamps = [f"{1741079702 + round(1e3 * t) / 1e3:.3f}".replace(".", "") + "000000" for t in TIME]
    late = [str(int(stamp) + 30_000_000) for stamp in stamps]
    header = "%time,field.header.seq,field.header.stamp,field.pressure,field.angle"
    file = write(tmp_path / "r.csv", header, late, range(len(TIME)), stamps, PRESSURE, ANGLE)
    maps = {"pressure": ("field.pressure", "kPa"), "tip_angle": ("field.angle", "deg")}
    (source,) = propose([file], maps=maps).sources
    (time,) = (one for one in source.meanings if one.quantity == "time")
    assert time.column == "field.header.stamp"
    check(made(file, tmp_path / "set", maps=maps)[0])


@pytest.mark.parametrize("unit", ["g", "gf"])
def test_grams_in_a_column_of_forces_are_their_weight(tmp_path, unit):
    force = 0.1 * PRESSURE  # [N]
    file = write(
        tmp_path / "r.csv", f"t [s],p [kPa],force [{unit}]", TIME, PRESSURE, force / 9.80665e-3
    )
    columns, _ = made(file, tmp_path / "set")
    np.testing.assert_allclose(columns["tip_force"], force, atol=1e-6)


def test_rows_that_are_newest_first_are_turned_round(tmp_path):
    columns = (one[::-1] for one in (TIME, PRESSURE, ANGLE))
    file = write(tmp_path / "r.csv", "t [s],p [kPa],angle [deg]", *columns)
    read, found = made(file, tmp_path / "set")
    check(read)
    assert any("begin with the newest" in remark for remark in found.remarks)


def test_rows_that_share_a_stamp_of_a_coarse_clock_are_spread_evenly(tmp_path):
    file = write(tmp_path / "r.csv", "t [s],p [kPa],angle [deg]", np.floor(TIME), PRESSURE, ANGLE)
    read, found = made(file, tmp_path / "set")
    check(read)
    assert any("18 of 24 rows" in remark for remark in found.remarks)


def test_a_clock_that_falls_and_rises_is_refused(tmp_path):
    wrong = np.where(TIME < 3.0, TIME, TIME - 3.0)
    file = write(tmp_path / "r.csv", "t [s],p [kPa],angle [deg]", wrong, PRESSURE, ANGLE)
    with pytest.raises(
        DocumentError, match="begins anew there, at 0 s after 2.75 s; .* --split-restarts"
    ):
        make_set(propose([file]), HAND)


def test_italian_headers_are_read(tmp_path):
    header = "Tempo [s];Pressione [kPa];Angolo [gradi]"
    file = write(tmp_path / "r.csv", header, TIME, PRESSURE, ANGLE, delimiter=";")
    check(made(file, tmp_path / "set")[0])


def test_a_size_with_its_unit_is_refused_with_the_unit_that_is_meant(tmp_path, capsys):
    file = write(tmp_path / "r.csv", "t [s],p [kPa],angle [deg]", TIME, PRESSURE, ANGLE)
    make_set(propose([file])).write(tmp_path / "set")
    document = tmp_path / "set" / "experiment.yaml"
    document.write_text(document.read_text().replace("finger: {}", "finger: {length: 90 mm}"))
    assert main(["compare", str(tmp_path / "set")]) == 2
    said = capsys.readouterr().err
    assert "length: expected a number in m, without its unit, got '90 mm'" in said


def test_a_sensor_that_stands_still_has_no_fit(tmp_path, capsys):
    still = np.full_like(TIME, 12.5)
    file = write(tmp_path / "r.csv", "t [s],p [kPa],angle [deg]", TIME, PRESSURE, still)
    make_set(propose([file]), HAND).write(tmp_path / "set")
    assert main(["compare", str(tmp_path / "set")]) == 0
    said = capsys.readouterr().out
    assert said.startswith("No model can be judged by these data. tip_angle: expected readings")
    assert "%  fitted" not in said and "No wrong unit" not in said


def test_tables_side_by_side_keep_the_clock_of_each(tmp_path):
    seen = np.arange(0.1, 5.5, 0.125)
    angle = np.interp(seen, TIME, ANGLE)
    rows = [f"{t},{p}," for t, p in zip(TIME, PRESSURE, strict=True)]
    rows += [",,"] * (len(seen) - len(rows))
    rows = [f"{row}{t},{a}" for row, t, a in zip(rows, seen, angle, strict=True)]
    header = "Time [s],Pressure [kPa],Time [s],Angle [deg]"
    (tmp_path / "r.csv").write_text("\n".join([header, *rows]) + "\n")
    read, _ = made(tmp_path / "r.csv", tmp_path / "set")
    np.testing.assert_allclose(read["time"], seen, atol=1e-6)
    np.testing.assert_allclose(read["tip_angle"], np.radians(angle), atol=1e-6)
    np.testing.assert_allclose(read["pressure"], 1e3 * np.interp(seen, TIME, PRESSURE), atol=0.5)


def test_dates_of_a_spreadsheet_are_days(tmp_path):
    days = [f"{45720.385439 + t / 86400.0:.12f}" for t in TIME]
    file = write(tmp_path / "r.csv", "Time,p [kPa],angle [deg]", days, PRESSURE, ANGLE)
    check(made(file, tmp_path / "set")[0])


def test_what_the_user_says_of_columns_says_the_experiment(tmp_path):
    header = "t [s],p [kPa],field.position0,effort [N]"
    file = write(tmp_path / "r.csv", header, TIME, PRESSURE, ANGLE, 0.0 * TIME)
    maps = {"tip_angle": ("field.position0", "deg")}
    check(made(file, tmp_path / "set", maps=maps)[0])
    assert propose([file]).experiment == "blocked_tip"


@pytest.mark.parametrize("ending", [".json", ".parquet", ".ods", ".xls"])
def test_a_file_of_another_format_is_refused_with_the_way_out(tmp_path, ending):
    (tmp_path / f"r{ending}").write_text('{"time": [0, 1, 2], "pressure": [1, 2, 3]}')
    with pytest.raises(DocumentError, match=f"got {ending}; save it as CSV"):
        propose([tmp_path / f"r{ending}"])


def test_a_map_names_a_column_as_its_header_writes_it(tmp_path):
    file = write(tmp_path / "r.csv", "t [s],P3 [mbar],angle [deg]", TIME, PRESSURE * 10.0, ANGLE)
    check(made(file, tmp_path / "set", maps={"pressure": ("P3 [mbar]", "")})[0])
    with pytest.raises(DocumentError, match="expected a column of the files"):
        propose([file], maps={"pressure": ("P3 [psi]", "")})


def test_levels_in_names_are_no_repeats_where_another_number_counts_these(tmp_path):
    files = [
        write(
            tmp_path / f"hold{level}_{repeat}.csv",
            "t [s],p [kPa],angle [deg]",
            TIME,
            PRESSURE * level / 40.0,
            ANGLE * level / 40.0,
        )
        for level, repeat in [(30, 1), (40, 1), (40, 2)]
    ]
    runs = make_set(propose(files), HAND).document["runs"]
    assert [run["protocol"] for run in runs.values()] == ["hold30", "hold40", "hold40"]


def test_the_temperature_of_a_run_is_that_of_its_column(tmp_path):
    files = [
        write(
            tmp_path / f"a_{run}.csv",
            "t [s],p [kPa],angle [deg],T_Raum [°C]",
            TIME,
            PRESSURE,
            ANGLE,
            np.round(celsius + 0.1 * np.sin(TIME), 2),
        )
        for run, celsius in [(1, 19.5), (2, 28.0)]
    ]
    found = make_set(propose(files), HAND)
    found.write(tmp_path / "set")
    data = load_measurements(tmp_path / "set")
    assert [run.temperature - 273.15 for run in data.runs] == pytest.approx([19.5, 28.0], abs=0.1)
    assert any("19.5 to 28.0 degC" in remark for remark in found.remarks)


@pytest.mark.parametrize(("rise", "kept"), [(0.5, False), (18.0, True)])
def test_a_temperature_that_changes_within_a_run_stays_a_column(tmp_path, rise, kept):
    celsius = np.linspace(20.0, 20.0 + rise, len(TIME))
    header = "t [s],p [kPa],angle [deg],T_Raum [°C]"
    files = [
        write(tmp_path / f"a_{run}.csv", header, TIME, PRESSURE, ANGLE, celsius) for run in (1, 2)
    ]
    found = make_set(propose(files), HAND)
    found.write(tmp_path / "set")
    data = load_measurements(tmp_path / "set")
    assert all(("temperature" in run.columns) == kept for run in data.runs)
    assert any("changes within runs" in remark for remark in found.remarks) == kept
    if kept:
        np.testing.assert_allclose(data.runs[0].warmth, 273.15 + celsius, atol=1e-3)


def test_repeats_are_counted_by_a_column_wdh(tmp_path):
    words = 2 * len(TIME) * ["duenn"] + 2 * len(TIME) * ["dick"]
    repeat = 2 * (len(TIME) * [1] + len(TIME) * [2])
    columns = (np.tile(values, 4) for values in (TIME, PRESSURE, ANGLE))
    header = "Finger,Wdh,t [s],p [kPa],angle [deg]"
    file = write(tmp_path / "r.csv", header, words, repeat, *columns)
    runs = make_set(propose([file]), HAND).document["runs"]
    assert [run["specimen"] for run in runs.values()] == ["duenn", "duenn", "dick", "dick"]


def test_a_column_for_each_level_of_pressure_makes_a_run_of_each_row(tmp_path):
    file = tmp_path / "force.csv"
    force = np.array([[0.0, 0.51, 1.02, 1.55], [0.01, 0.49, 1.01, 1.52]])
    lines = ["Messung;0 kPa;10 kPa;20 kPa;30 kPa"]
    lines += [f"{n + 1};" + ";".join(f"{x:.2f}" for x in row) for n, row in enumerate(force)]
    file.write_text("\n".join(lines).replace(".", ",") + "\n")
    found = make_set(propose([file], maps={"tip_force": ("values", "N")}))
    assert found.document["experiment"] == "blocked_tip"
    assert [list(run.columns["pressure"]) for run in found.runs] == 2 * [[0.0, 10.0, 20.0, 30.0]]
    np.testing.assert_allclose([run.columns["tip_force"] for run in found.runs], force)
    assert len({run["protocol"] for run in found.document["runs"].values()}) == 1
    assert any("columns are levels of pressure" in remark for remark in found.remarks)


def test_runs_come_in_the_order_of_the_numbers_in_their_names(tmp_path):
    """A shell lists slow_10 before slow_2, and fast_1 before slow_0."""
    names = [*(f"slow_{n}" for n in range(9, 12)), "fast_12"]
    header = "t [s],p [kPa],angle [deg]"
    files = [write(tmp_path / f"{name}.csv", header, TIME, PRESSURE, ANGLE) for name in names]
    found = make_set(propose(sorted(files)), HAND)
    assert list(found.document["runs"]) == names
    assert any(remark.startswith("taken as recorded in this order") for remark in found.remarks)
    chosen = [files[2], files[0], files[3], files[1]]
    assert list(make_set(propose(chosen), HAND).document["runs"]) == [one.stem for one in chosen]


@pytest.mark.parametrize("written", ["%", "percent", "pct", "Prozent"])
def test_percent_may_be_written_in_words(tmp_path, written):
    strain = np.linspace(0.0, 80.0, 30)
    header = "Time [s],Weite,Stress [MPa]"
    file = write(tmp_path / "pull.csv", header, np.arange(30.0), strain, 0.002 * strain)
    found = make_set(propose([file], maps={"strain": ("Weite", written)}))
    np.testing.assert_allclose(found.runs[0].columns["stretch"], 1.0 + strain / 100.0)


def named(folder, names, pressures=None, header="t [s],p [kPa],angle [deg]"):
    """A set of files with these names, with inputs of these factors."""
    factors = pressures or [1.0] * len(names)
    files = [
        write(folder / f"{name}.csv", header, TIME, factor * PRESSURE, factor * ANGLE)
        for name, factor in zip(names, factors, strict=True)
    ]
    return make_set(propose(files), HAND)


@pytest.mark.parametrize(
    ("names", "degrees"),
    [
        (["Finger_8C_1", "Finger_22C_1"], [8.0, 22.0]),
        (["cold_-5degC", "warm_35degC"], [-5.0, 35.0]),
        (["temp20_a", "temp35_a"], [20.0, 35.0]),
        (["Finger_8C_1", "Finger_1"], None),
        (["ramp_T20", "ramp_T35"], None),
    ],
)
def test_temperatures_in_the_names_of_all_files_are_those_of_the_runs(tmp_path, names, degrees):
    found = named(tmp_path, names)
    kelvin = [run.get("temperature") for run in found.document["runs"].values()]
    if degrees is None:
        assert kelvin == [None, None]
    else:
        assert kelvin == pytest.approx([one + 273.15 for one in degrees])
        assert any("as in the names of the runs" in remark for remark in found.remarks)


@pytest.mark.parametrize("word", ["day", "session", "Tag"])
def test_a_day_is_no_specimen(tmp_path, word):
    names = [f"{word}{day}_{level}kPa" for day in (1, 2, 3) for level in (20, 40)]
    runs = named(tmp_path, names, [0.5, 1.0] * 3).document["runs"].values()
    assert len({run["specimen"] for run in runs}) == 1
    assert len({run["protocol"] for run in runs}) == 2


def test_runs_whose_names_number_their_levels_are_no_repeats(tmp_path):
    runs = named(tmp_path, ["peak18", "peak26"], [18.0 / 26.0, 1.0]).document["runs"]
    assert len({run["protocol"] for run in runs.values()}) == 2
    assert len({run["specimen"] for run in runs.values()}) == 1


def test_repeats_whose_numbers_tell_no_level_stay_repeats(tmp_path):
    runs = named(tmp_path, ["pull18", "pull26"]).document["runs"].values()
    assert len({run["protocol"] for run in runs}) == 1


@pytest.mark.parametrize(("a_second", "rate"), [(100, 25), (25, 25), (100, 4), (100, 50)])
def test_a_clock_of_four_parts_counts_hundredths_or_frames(tmp_path, a_second, rate):
    """As Kinovea (0:00:12:08) or a time code of a video writes it."""
    frames = np.arange(6 * rate)
    clock = [f"0:00:{n // rate:02d}:{(n % rate) * a_second // rate:02d}" for n in frames]
    pressure, angle = (np.interp(frames / rate, TIME, one) for one in (PRESSURE, ANGLE))
    file = write(tmp_path / "video.csv", "Time,p [kPa],angle [deg]", clock, pressure, angle)
    columns, found = made(file, tmp_path / "set")
    np.testing.assert_allclose(columns["time"], frames / rate, atol=1e-9)
    assert not any("share a stamp" in remark for remark in found.remarks)


def test_the_clock_of_a_german_testing_machine_is_the_time(tmp_path):
    strain = np.linspace(0.0, 80.0, 30)
    header = "Prüfzeit [s],Dehnung [%],Spannung [MPa]"
    file = write(tmp_path / "zug.csv", header, np.arange(30.0), strain, 0.002 * strain)
    assert "time" in make_set(propose([file])).runs[0].columns
