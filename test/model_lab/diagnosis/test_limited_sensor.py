"""A pressure sensor at its limit is told, and the rest is judged without what it read there."""

from dataclasses import replace

import numpy as np
import pytest
from lab_sets import measured, run
from measurement_folder import csv_text, document, write_set

from model_lab.diagnosis.diagnose import diagnose
from model_lab.experiments.forward import Forward
from model_lab.measurements.limited_input import limit_reached, within_limit
from model_lab.measurements.load import load_measurements
from model_lab.report.sentences import verdict_sentence
from softhand_common.documents.yaml_document import DocumentError
from softhand_model.effects import effect_classes
from softhand_model.model_file import Model

CLASSES = {n: effect_classes()[n] for n in ("gent_stiffening", "tube_lag", "pressure_gain")}
TIME = np.arange(0.0, 40.0, 0.25)
NOISE, LIMIT = 0.005, 25e3  # [rad], [Pa]


def read(limit=np.inf):
    """Two repeats each of triangles and of a staircase."""
    levels = np.array([0.0, 30.0, 30.0, 15.0, 15.0, 29.0, 29.0, 0.0, 0.0])
    changes = [0.0, 1.0, 9.0, 10.0, 19.0, 20.0, 31.0, 32.0, 40.0]
    courses = {
        "triangles": 30e3 * np.abs(np.sin(np.pi * TIME / 20.0)),
        "stairs": np.interp(TIME, changes, 1e3 * levels),
    }
    names = [f"{name}_{repeat}" for name in courses for repeat in (1, 2)]
    made = [run(name, TIME, pressure=courses[name[:-2]]) for name in names]
    data = measured("free_bending", [replace(one, protocol=one.name[:-2]) for one in made])
    forward = Forward(data, "pneuflex", (), [], {})
    angles = forward.predict(forward.start()[None])[0].reshape(4, -1)
    noise = NOISE * np.random.default_rng(3).standard_normal(angles.shape)
    shown = [
        {**one.columns, "pressure": np.minimum(one.columns["pressure"], limit), "tip_angle": angle}
        for one, angle in zip(data.runs, angles + noise, strict=True)
    ]
    runs = [replace(one, columns=columns) for one, columns in zip(data.runs, shown, strict=True)]
    return replace(data, runs=tuple(runs))


def test_the_limit_is_where_the_input_stays_while_the_output_goes_on():
    found = limit_reached(read(LIMIT), NOISE)
    assert found.reading == LIMIT
    assert {0, 1} <= set(found.runs)  # the triangles
    assert limit_reached(read(), NOISE) is None


def test_the_parts_below_the_limit_are_driven_with_all_that_was_read_before():
    data = read(LIMIT)
    parts = within_limit(data, LIMIT).runs
    assert all(part.columns["pressure"].max() < LIMIT for part in parts)
    first, second = [part for part in parts if part.name.startswith("triangles_1")][:2]
    assert not first.lead
    before, whole = len(second.lead["time"]), data.runs[0].columns
    np.testing.assert_array_equal(
        second.lead["pressure"], data.runs[0].columns["pressure"][:before]
    )
    assert second.columns["time"][0] == whole["time"][before]


def test_a_sensor_at_its_limit_is_the_first_that_is_said():
    found = diagnose(read(LIMIT), Model("pneuflex"), CLASSES).diagnosis
    assert [slip.name for slip in found.slips] == ["limit"]
    assert found.verdict_mended == "adequate"
    said = verdict_sentence(found)
    assert said.startswith("The sensor of the pressure stands at its limit of 25 kPa")
    assert "columns: {pressure: {unit: Pa, limit: 25000.0}}" in said


def test_a_stated_limit_leaves_these_samples_out(tmp_path):
    time = np.arange(40.0)
    pressure = np.minimum(np.r_[2.0 * time[:20], 2.0 * time[20:0:-1]], 25.0)
    content = document()
    content["columns"]["pressure"]["limit"] = 25.0
    text = csv_text({"time": time, "pressure": pressure, "tip_angle": time})
    parts = load_measurements(write_set(tmp_path, content, {"r1.csv": text})).runs
    assert [part.samples for part in parts] == [13, 12]
    assert max(part.columns["pressure"].max() for part in parts) == pytest.approx(24e3)


def test_an_output_has_no_limit_of_this_kind(tmp_path):
    content = document()
    content["columns"]["tip_angle"]["limit"] = 90.0
    with pytest.raises(DocumentError, match="limit` only for pressure, stretch"):
        load_measurements(write_set(tmp_path, content))
