"""Measurement sets come back in SI units; what is wrong with one is said by file, row and key."""

import os
import time
from pathlib import Path

import numpy as np
import pytest
from measurement_folder import ROWS, SPECIMEN, csv_text, document, write_set

from model_lab.comparison.compare import compare
from model_lab.experiments.linear import LinearBase
from model_lab.experiments.uniaxial import Uniaxial
from model_lab.experiments.valve_pulse import ValvePulse
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import OUTPUTS
from model_lab.measurements.save import write_set as save_set
from model_lab.measurements.units import column_unit
from model_lab.report.comparison_text import comparison_text
from softhand_common.documents.yaml_document import DocumentError
from softhand_model.model_file import load_model

REAL = os.environ.get("SOFTHAND_MEASUREMENTS")


def test_columns_come_back_in_si_units(tmp_path):
    run = load_measurements(write_set(tmp_path)).runs[0]
    np.testing.assert_allclose(run.columns["pressure"], [0.0, 1e4, 2e4])
    np.testing.assert_allclose(run.columns["tip_angle"], [0.0, np.pi / 10, np.pi / 5])
    np.testing.assert_array_equal(run.columns["time"], [0.0, 0.1, 0.2])


@pytest.mark.parametrize(
    ("column", "unit", "written", "read"),
    [
        ("pressure", "bar", 0.25, 25000.0),
        ("pressure", "psi", 10.0, 68947.5729),
        ("pressure", "mmHg", 100.0, 13332.2387),
        ("tip_angle", "", 0.5, 0.5),
        ("tip_angle", "mrad", 500.0, 0.5),
        ("room", "degC", 21.5, 294.65),
        ("room", "degF", 70.7, 294.65),
        ("humidity", "percent", 45.0, 0.45),
        ("humidity", "%", 45.0, 0.45),
        ("flow", "liter/min", 6.0, 1e-4),
    ],
)
def test_any_unit_is_converted(tmp_path, column, unit, written, read):
    columns = {"time": [0.0], "pressure": [0.0], "tip_angle": [0.0]} | {column: [written]}
    content = document()
    content["columns"][column] = {"unit": unit}
    run = load_measurements(write_set(tmp_path, content, {"r1.csv": csv_text(columns)})).runs[0]
    assert run.columns[column] == pytest.approx([read], rel=1e-8)


def test_the_noise_is_in_the_unit_of_its_column(tmp_path):
    data = load_measurements(write_set(tmp_path, document(noise={"tip_angle": 0.5})))
    assert data.noise == pytest.approx({"tip_angle": np.radians(0.5)})


def test_an_offset_of_the_unit_does_not_shift_the_noise(tmp_path):
    content = document(noise={"room": 0.5})
    content["columns"]["room"] = {"unit": "degC"}
    rows = "time,pressure,tip_angle,room\n0,0,0,20\n"
    assert load_measurements(write_set(tmp_path, content, {"r1.csv": rows})).noise == {"room": 0.5}


def test_runs_take_what_they_do_not_say_from_the_contract(tmp_path):
    run = load_measurements(write_set(tmp_path, document(runs={"a": _run(file="r1.csv")}))).runs[0]
    assert (run.protocol, run.temperature, run.virgin, run.steady) == ("a", 293.15, False, False)


def test_runs_keep_their_order_and_what_they_say(tmp_path):
    runs = {
        "z": _run(file="z.csv", protocol="ramp", temperature=300.0, virgin=True),
        "a": _run(file="a.csv", protocol="ramp", temperature=300.5, initial="steady"),
    }
    files = {"z.csv": ROWS, "a.csv": ROWS}
    data = load_measurements(write_set(tmp_path, document(runs=runs), files))
    assert [(run.name, run.virgin, run.steady) for run in data.runs] == [
        ("z", True, False),
        ("a", False, True),
    ]
    assert data.groups() == [[0, 1]]
    assert data.folder == tmp_path


def test_specimens_keep_every_key(tmp_path):
    specimen = SPECIMEN | {
        "height": [[0.0, 0.02], [0.09, 0.01]],
        "mount": "base_up",
        "batch": "A",
        "shore": 10,
        "maker": "bench 2",
    }
    data = load_measurements(write_set(tmp_path, document(specimens={"f": specimen})))
    read = data.specimens["f"]
    np.testing.assert_array_equal(read.values["height"], [[0.0, 0.02], [0.09, 0.01]])
    assert (read.mount, read.batch, read.values["shore"]) == ("base_up", "A", 10.0)
    assert read.values["wall"] == 0.002
    assert read.notes == {"maker": "bench 2"}


def test_the_set_is_found_by_its_document_too(tmp_path):
    assert load_measurements(write_set(tmp_path) / "experiment.yaml").title == "one finger"


def test_columns_without_a_unit_are_passed_over(tmp_path):
    rows = "time,pressure,tip_angle,remark\n0,0,0,started\n0.1,1,2,\n"
    run = load_measurements(write_set(tmp_path, files={"r1.csv": rows})).runs[0]
    assert set(run.columns) == {"time", "pressure", "tip_angle"}


def test_numbers_in_exponent_notation_are_numbers(tmp_path):
    folder = write_set(tmp_path)
    text = (folder / "experiment.yaml").read_text().replace("67000.0", "67e3")
    (folder / "experiment.yaml").write_text(text)
    assert load_measurements(folder).specimens["f"].values["shear_modulus"] == 67000.0


def test_the_direction_of_a_pulse_may_be_a_word(tmp_path):
    rows = "direction,duration,p_in,p_out,mass\ninflate,40,350,101,2.5\ndeflate,50,200,101.3,3\n"
    units = {"duration": "ms", "p_in": "kPa", "p_out": "kPa", "mass": "mg"}
    content = document(
        experiment="valve_pulse",
        columns={name: {"unit": unit} for name, unit in units.items()},
        specimens={"f": {}},
    )
    columns = load_measurements(write_set(tmp_path, content, {"r1.csv": rows})).runs[0].columns
    np.testing.assert_array_equal(columns["direction"], [1.0, -1.0])
    np.testing.assert_allclose(columns["duration"], [0.04, 0.05])
    np.testing.assert_allclose(columns["mass"], [2.5e-6, 3e-6])


def test_a_million_samples_load_in_seconds(tmp_path):
    count = 1_000_000
    step = np.arange(count)
    text = "time,pressure,tip_angle\n" + "\n".join(
        f"{index / 1000:.3f},{index % 5000 / 100:.2f},{index % 777 / 10:.1f}"
        for index in step.tolist()
    )
    write_set(tmp_path, files={"r1.csv": text})
    start = time.process_time()
    run = load_measurements(tmp_path).runs[0]
    assert time.process_time() - start < 6.0  # two on an idle machine
    np.testing.assert_allclose(run.columns["time"], step / 1000.0)
    np.testing.assert_allclose(run.columns["pressure"], step % 5000 * 10.0)


@pytest.mark.skipif(REAL is None, reason="SOFTHAND_MEASUREMENTS is not set")
@pytest.mark.parametrize(
    ("name", "runs", "output", "largest"),
    [
        ("silicone_dragon_skin_10", 1, "stress", 533316.0),
        ("silicone_ecoflex_00_30", 1, "stress", 96460.0),
        ("epfl_c5_w7_bending", 1, "tip_angle", 1.19946),
        ("epfl_c5_w7_blocked", 36, "tip_force", 1.6541),
    ],
)
def test_real_sets_load(name, runs, output, largest):
    data = load_measurements(Path(REAL) / name)
    assert len(data.runs) == runs
    found = max(run.columns[output].max() for run in data.runs)
    assert found == pytest.approx(largest, rel=0.02)


# ------------------------------------------------------------------ what is refused
def _run(**entries):
    return {"specimen": "f"} | entries


def _message(folder):
    with pytest.raises(DocumentError) as caught:
        load_measurements(folder)
    message = str(caught.value)
    assert "\n" not in message
    return message


WRONG_ROWS = {
    "text": ("0,0,0\n0.1,ten,18\n", "row 2 (line 3 of the file), column pressure", "got 'ten'"),
    "nan": ("0,0,0\n0.1,1,nan\n", "row 2 (line 3 of the file), column tip_angle", "got 'nan'"),
    "infinity": ("0,0,inf\n", "row 1 (line 2 of the file), column tip_angle", "finite"),
    "empty cell": ("0,0,0\n0.1,,18\n", "row 2 (line 3 of the file), column pressure", "empty"),
    "lost frame": ("0,0,0\n0.1,1,nan\n", "row 2 (line 3 of the file)", "remove the row"),
    "short row": ("0,0,0\n0.1,1\n0.2,2,2\n", "row 2 (line 3 of the file)", "3 cells, got 2"),
    "long row": ("0,0,0\n0.1,1,2,3\n", "row 2 (line 3 of the file)", "3 cells, got 4"),
    "uneven rows": ("0,0,0\n0.1,1,2,3\n0.2,1\n", "row 2 (line 3", "3 cells, got 4"),
    "unsorted time": ("0.2,0,0\n0.1,1,2\n", "row 2 (line 3 of the file), column time", "sort"),
    "repeated time": ("0.1,0,0\n0.1,1,2\n", "row 2 (line 3 of the file), column time", "again"),
    "no rows": ("", "r1.csv", "expected rows"),
    "blank rows": ("\n\n", "r1.csv", "expected rows"),
    "other digits": ("0,0,0\n0.1,1_0,18\n", "row 2 (line 3 of the file)", "got '1_0'"),
    "1e308 Pa": ("0,0,0\n0.1,1e308,18\n", "row 2 (line 3 of the file), column pressure", "got inf"),
    "1e15 Pa": ("0,0,0\n0.1,1e15,18\n", "row 2 (line 3 of the file), column pressure", "1e+12 at"),
    "a long cell": (
        f"0,0,0\n0.1,{'1' * 140_000},18\n",
        "line 3: expected cells of at most 131072 characters",
        "larger than field limit",
    ),
    "comment": ("0,0,0\n# stopped\n", "row 2 (line 3 of the file)", "3 cells, got 1"),
}


@pytest.mark.parametrize(("rows", "place", "got"), WRONG_ROWS.values(), ids=WRONG_ROWS)
def test_wrong_rows_are_located(tmp_path, rows, place, got):
    message = _message(write_set(tmp_path, files={"r1.csv": "time,pressure,tip_angle\n" + rows}))
    assert str(tmp_path / "r1.csv") in message
    assert place in message
    assert got in message


def test_a_wrong_row_is_located_behind_blank_lines_and_quotes(tmp_path):
    rows = 'time,"pressure",tip_angle\n0,0,0\n\n0.1,"1",2\n0.2,"x",2\n'
    assert "row 3 (line 5 of the file), column pressure" in _message(
        write_set(tmp_path, files={"r1.csv": rows})
    )


def test_blank_lines_quotes_spaces_and_windows_line_ends_are_read(tmp_path):
    rows = '\ufefftime , "pressure",tip_angle\r\n0, 0,0\r\n\r\n0.1,"10",18\r\n\r\n'
    run = load_measurements(write_set(tmp_path, files={"r1.csv": rows})).runs[0]
    np.testing.assert_allclose(run.columns["pressure"], [0.0, 1e4])


WRONG_HEADERS = {
    "missing": ("time,pressure\n0,0\n", "column tip_angle, got time, pressure"),
    "twice": ("time,pressure,tip_angle,time\n0,0,0,0\n", "got time twice"),
    "semicolons": ("time;pressure;tip_angle\n0;0;0\n", "semicolons, `model-lab import FILE..."),
    "preamble": ("Machine;X\n\ntime,pressure,tip_angle\n0,0,0\n", "line 3 has it: where other"),
    "none": ("0,0,0\n1,1,1\n", "names of the columns into the first line"),
    "empty file": ("", "expected names of the columns"),
}


@pytest.mark.parametrize(("text", "part"), WRONG_HEADERS.values(), ids=WRONG_HEADERS)
def test_wrong_headers_are_named(tmp_path, text, part):
    message = _message(write_set(tmp_path, files={"r1.csv": text}))
    assert str(tmp_path / "r1.csv") in message
    assert part in message


def test_an_experiment_that_the_lab_does_not_know_is_refused_before_its_runs_are_read(tmp_path):
    folder = write_set(tmp_path, document(experiment="pumping", runs={"r1": {"mode": "slow"}}))
    assert _message(folder) == (
        f"{folder / 'experiment.yaml'}:2: experiment: expected one of {', '.join(OUTPUTS)}, "
        "got 'pumping'"
    )


def _unit(column, unit):
    columns = document()["columns"] | {column: {"unit": unit}}
    return document(columns=columns)


WRONG_DOCUMENTS = {
    "unknown unit": (_unit("pressure", "kilopaskal"), "columns.pressure.unit", "'kilopaskal'"),
    "case of a unit": (_unit("pressure", "KPa"), "columns.pressure.unit", "perhaps kPa"),
    "broken unit": (_unit("pressure", "kPa)"), "columns.pressure.unit", "'kPa)'"),
    "wrong quantity": (_unit("pressure", "deg"), "columns.pressure.unit", "'deg'"),
    "charge": (_unit("temperature", "C"), "columns.temperature.unit", "write degC"),
    "no unit": (_unit("pressure", None), "columns.pressure.unit", "a unit as text"),
    "column without unit": (
        document(columns={"time": {"unit": "s"}, "pressure": {"unit": "kPa"}}),
        "columns",
        "the column tip_angle, which free_bending needs",
    ),
    "experiment": (document(experiment="bending"), "experiment", "free_bending, blocked_tip"),
    "format": (document(format="softhand-measurement/2"), "format", "softhand-measurement/1"),
    "no runs": (document(runs={}), "runs", "at least one run"),
    "runs as a list": (document(runs=["r1"]), "runs", "a mapping"),
    "run without a name": (document(runs={1: _run(file="r1.csv")}), "runs", "write '1'"),
    "specimen": (
        document(runs={"r1": {"specimen": "g", "file": "r1.csv"}}),
        "runs.r1.specimen",
        "f",
    ),
    "no file": (document(runs={"r1": _run()}), "runs.r1", "got neither"),
    "both": (document(runs={"r1": _run(file="r1.csv", bag="b")}), "runs.r1", "got both"),
    "missing file": (document(runs={"r1": _run(file="r9.csv")}), "r9.csv", "No such file"),
    "a slip": (
        document(runs={"r1": _run(file="r1.csv", protcol="x")}),
        "runs.r1",
        "write protocol",
    ),
    "file twice": (
        document(runs={"r1": _run(file="r1.csv"), "r2": _run(file="r1.csv")}),
        "runs.r2.file",
        "as in runs.r1.file",
    ),
    "degrees": (
        document(runs={"r1": _run(file="r1.csv", temperature=20)}),
        "runs.r1.temperature",
        "20 degC are 293.15",
    ),
    "initial": (
        document(runs={"r1": _run(file="r1.csv", initial="x")}),
        "runs.r1.initial",
        "steady",
    ),
    "virgin": (document(runs={"r1": _run(file="r1.csv", virgin="x")}), "runs.r1.virgin", "True"),
    "noise": (document(noise={"angle": 1}), "noise.angle", "time, pressure, tip_angle"),
    "negative noise": (document(noise={"tip_angle": -1}), "noise.tip_angle", "above 0"),
    "mount": (document(specimens={"f": {"mount": "up"}}), "specimens.f.mount", "base_up"),
    "wall": (document(specimens={"f": {"wall": 0}}), "specimens.f.wall", "above 0"),
    "text": (document(specimens={"f": {"wall": "2mm"}}), "specimens.f.wall", "'2mm'"),
    "height": (document(specimens={"f": {"height": []}}), "specimens.f.height", "[x, value]"),
    "profile": (
        document(specimens={"f": {"height": [[0.1, 0.02], [0.0, 0.02]]}}),
        "specimens.f.height",
        "rising x",
    ),
    "no specimens": (document(specimens={}), "specimens", "at least one specimen"),
    "bag without topics": (document(runs={"r1": _run(bag="b")}), "runs.r1", "add topics"),
}


@pytest.mark.parametrize(
    ("content", "place", "part"), WRONG_DOCUMENTS.values(), ids=WRONG_DOCUMENTS
)
def test_what_is_wrong_with_a_document_is_named(tmp_path, content, place, part):
    message = _message(write_set(tmp_path, content))
    assert str(tmp_path) in message
    assert place in message
    assert part in message


def test_a_run_given_twice_is_named(tmp_path):
    folder = write_set(tmp_path)
    text = (folder / "experiment.yaml").read_text()
    (folder / "experiment.yaml").write_text(text + "  r1: {specimen: f, file: r1.csv}\n")
    assert "the key r1 twice" in _message(folder)


def test_a_missing_set_is_named(tmp_path):
    message = _message(tmp_path / "none")
    assert str(tmp_path / "none") in message
    assert "No such file" in message


WRONG_VALUES = {
    "below -90 %": ("uniaxial", {"stretch": -95.0, "stress": 0.0}, "stretch", "strain + 1"),
    "beyond percent": ("uniaxial", {"stretch": 6e3, "stress": 0.0}, "stretch", "strain + 1"),
    "below nothing": ("valve_pulse", {"p_out": -120e3}, "column p_out", "absolute"),
    "duration": ("valve_pulse", {"duration": -1.0}, "column duration", "above 0"),
    "direction": ("valve_pulse", {"direction": 2.0}, "column direction", "inflate"),
}


@pytest.mark.parametrize(
    ("experiment", "values", "place", "part"), WRONG_VALUES.values(), ids=WRONG_VALUES
)
def test_values_that_cannot_be_are_located(tmp_path, experiment, values, place, part):
    usual = {
        "uniaxial": {"stretch": 1.0, "stress": 0.0},
        "valve_pulse": {"direction": 1.0, "duration": 1.0, "p_in": 1.0, "p_out": 1.0, "mass": 1.0},
    }[experiment]
    units = {"stress": "Pa", "p_in": "Pa", "p_out": "Pa", "duration": "s", "mass": "kg"}
    columns = {name: {"unit": units.get(name, "")} for name in usual}
    row = usual | values
    rows = csv_text({name: [usual[name], row[name]] for name in usual})
    content = document(experiment=experiment, columns=columns)
    message = _message(write_set(tmp_path, content, {"r1.csv": rows}))
    assert place in message
    assert part in message
    assert "row 2 (line 3 of the file)" in message


@pytest.mark.parametrize("value", [0.0, -300.0], ids="{:g}".format)
def test_gauge_pressures_of_pulses_are_kept_but_drive_no_model(tmp_path, value):
    units = {"direction": "", "duration": "s", "p_in": "Pa", "p_out": "Pa", "mass": "kg"}
    columns = {name: {"unit": unit} for name, unit in units.items()}
    usual = {name: [1.0, 1.0] for name in units}
    rows = csv_text(usual | {"p_in": [200.0, 200.0], "p_out": [1.0, value]})
    content = document(experiment="valve_pulse", columns=columns)
    data = load_measurements(write_set(tmp_path, content, {"r1.csv": rows}))
    (doubt,) = data.doubts
    for part in ("r1.csv: row 2 (line 3 of the file), column p_out", "is: gauge", f"{value:g}"):
        assert part in doubt
    with pytest.raises(DocumentError, match="row 2.*absolute"):
        ValvePulse(data)


@pytest.mark.parametrize("value", [0.0, 0.05, -0.3, 150.0], ids="{:g}".format)
def test_what_may_be_strain_or_percent_is_kept_but_drives_no_model(tmp_path, value):
    content = document(
        experiment="uniaxial",
        specimens={"f": {"shear_modulus": 8e4}},
        columns={"stretch": {"unit": ""}, "stress": {"unit": "Pa"}},
    )
    rows = csv_text({"stretch": [1.0, value], "stress": [0.0, 0.0]})
    data = load_measurements(write_set(tmp_path, content, {"r1.csv": rows}))
    assert data.runs[0].columns["stretch"].tolist() == [1.0, value]
    (doubt,) = data.doubts
    for part in ("r1.csv: row 2 (line 3 of the file), column stretch", "strain + 1", f"{value:g}"):
        assert part in doubt
    for model in (Uniaxial, LinearBase):
        with pytest.raises(DocumentError, match="row 2.*strain"):
            model(data)


STRIP = {
    "experiment": "uniaxial",
    "specimens": {"f": {"shear_modulus": 8e4}},
    "columns": {"stretch": {"unit": ""}, "stress": {"unit": "Pa"}},
}
PULL = {"r1.csv": csv_text({"stretch": [1.0, 2.0], "stress": [0.0, 1e5]})}


def test_how_far_a_strip_was_stretched_before_is_read_written_and_told(tmp_path):
    pull = _run(file="r1.csv", stretched_to=2.5)
    content = document(**STRIP, runs={"r1": pull}, noise={"stress": 1e3})
    data = load_measurements(write_set(tmp_path / "a", content, PULL))
    assert data.runs[0].stretched_to == 2.5
    save_set(data, tmp_path / "b")
    again = load_measurements(tmp_path / "b")
    assert again.runs[0].stretched_to == 2.5
    assert "stretched to 2.5 before" in comparison_text(compare(again, load_model("base")), "base")


@pytest.mark.parametrize(
    ("entry", "part"),
    [
        ({"stretched_to": 0.5}, "strain + 1"),
        ({"stretched_to": 150}, "strain + 1"),
        ({"stretched_to": 2.0, "virgin": True}, "virgin"),
    ],
)
def test_a_stretch_before_that_cannot_be_is_refused(tmp_path, entry, part):
    content = document(**STRIP, runs={"r1": _run(file="r1.csv", **entry)})
    message = _message(write_set(tmp_path, content, PULL))
    assert "runs.r1.stretched_to" in message and part in message


@pytest.mark.parametrize(
    "unit", ["9**9**9 kPa", "kPa**9**9**9", "(9)**(9)**(9)*kPa", "m" * 100, "km**999", "k" * 10**5]
)
def test_a_unit_that_has_to_be_calculated_is_refused_at_once(tmp_path, unit):
    folder = write_set(tmp_path, _unit("other", unit))
    begun = time.process_time()
    message = _message(folder)
    assert time.process_time() - begun < 2.0
    assert "columns.other.unit: expected a unit" in message and len(message) < 700


@pytest.mark.parametrize("unit", ["m/s**2", "1/(s*Pa)", "m^-3", "cmH2O", "N m", "m**0.5", "%"])
def test_units_with_exponents_are_known(unit):
    assert column_unit("other", unit).scale > 0.0


# ------------------------------------------------------------------ inputs before the first output
LATE = "time,pressure,tip_angle\n-0.2,5,\n-0.1,6,\n0,7,18\n0.1,10,20\n"


def test_rows_before_the_first_output_are_the_lead(tmp_path):
    run = load_measurements(write_set(tmp_path, files={"r1.csv": LATE})).runs[0]
    assert run.samples == 2
    np.testing.assert_allclose(run.columns["tip_angle"], np.radians([18.0, 20.0]))
    np.testing.assert_allclose(run.lead["time"], [-0.2, -0.1])
    np.testing.assert_allclose(run.lead["pressure"], [5e3, 6e3])
    assert "tip_angle" not in run.lead


def test_a_lead_is_written_and_read_again(tmp_path):
    data = load_measurements(write_set(tmp_path / "a", files={"r1.csv": LATE}))
    save_set(data, tmp_path / "b")
    again = load_measurements(tmp_path / "b").runs[0]
    for name in ("columns", "lead"):
        given, found = getattr(data.runs[0], name), getattr(again, name)
        assert given.keys() == found.keys()
        for column in given:
            np.testing.assert_allclose(found[column], given[column])


@pytest.mark.parametrize("rows", ["0,0,0\n0.1,1,\n", "0,0,\n0.1,1,\n"])
def test_outputs_that_are_missing_later_or_everywhere_are_refused(tmp_path, rows):
    text = "time,pressure,tip_angle\n" + rows
    message = _message(write_set(tmp_path, files={"r1.csv": text}))
    assert "tip_angle" in message
    assert "empty cell" in message


def test_a_clock_that_jumps_back_while_the_pull_goes_on_is_not_to_be_sorted(tmp_path):
    time, stretch = 0.1 * np.arange(60.0), 1.0 + 0.01 * np.arange(60.0)
    time[40:] -= 0.85
    rows = csv_text({"time": time, "stretch": stretch, "stress": stretch - 1.0})
    content = document(
        experiment="uniaxial",
        specimens={"f": {"shear_modulus": 67e3}},
        columns={"time": {"unit": "s"}, "stretch": {"unit": ""}, "stress": {"unit": "MPa"}},
    )
    message = _message(write_set(tmp_path / "a", content, {"r1.csv": rows}))
    assert "leave `time` out of `columns`, or mend the clock" in message
    mixed = np.random.default_rng(0).permutation(60)
    rows = csv_text({"time": 0.1 * mixed, "stretch": stretch[mixed], "stress": stretch[mixed]})
    message = _message(write_set(tmp_path / "b", content, {"r1.csv": rows}))
    assert "sort the rows" in message
    assert "leave `time` out" not in message
