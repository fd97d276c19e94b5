"""Wild samples: what is taken for one, and what is not."""

from dataclasses import replace

import numpy as np
import pytest

from bench.hidden.cases import all_cases
from model_lab.diagnosis.diagnose import diagnose
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import MeasurementSet, Run
from model_lab.measurements.wild_samples import without_wild_samples
from softhand_model.model_file import load_model

TIME = np.linspace(0.0, 12.0, 240)
COURSES = {
    "ramp up and down": 1.0 - np.abs(TIME / 6.0 - 1.0),
    "steps": np.floor(TIME / 2.0) % 2,
    "steps that a lag rounds": np.where(TIME < 3.0, 0.0, 1.0 - np.exp(-(TIME - 3.0) / 0.1)),
    "fast sine": np.sin(8.0 * TIME),
    "held": np.full(240, 0.3),
    "coarse steps of a sensor": np.round(20.0 * np.sin(TIME)) / 20.0,
}


def set_of(readings, pressure=TIME):
    columns = {"time": TIME, "pressure": 1e3 * pressure, "tip_angle": readings}
    run = Run("r1", "finger", "p", 293.15, columns)
    return MeasurementSet("free_bending", "", {}, (run,))


@pytest.mark.parametrize("name", COURSES)
@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_a_course_without_wild_samples_stays_as_it_is(name, noise):
    random = np.random.default_rng(2)
    data = set_of(COURSES[name] + noise * random.standard_normal(240))
    assert without_wild_samples(data) is data


@pytest.mark.parametrize("name", ["ramp up and down", "steps that a lag rounds", "held"])
def test_single_and_paired_readings_far_off_are_replaced_by_what_lies_around_them(name):
    random = np.random.default_rng(4)
    clean = COURSES[name] + 0.003 * random.standard_normal(240)
    places = [30, 31, 90, 151, 200]
    wild = clean.copy()
    wild[places] += [1.5, 1.3, -2.0, 3.0, -1.2]
    found = without_wild_samples(set_of(wild))
    assert [sample.sample for sample in found.wild] == places
    np.testing.assert_allclose(found.runs[0].columns["tip_angle"], clean, atol=0.25)
    np.testing.assert_allclose([s.moved for s in found.wild], (clean - wild)[places], atol=0.25)


def test_a_reading_that_follows_a_jump_of_the_input_is_none():
    pulse = np.where(np.arange(240) == 100, 1.0, 0.0)
    assert without_wild_samples(set_of(pulse)).wild
    assert not without_wild_samples(set_of(pulse, pressure=pulse)).wild


def test_about_a_model_small_ones_are_found_on_a_steep_course():
    course = 50.0 * np.sin(8.0 * TIME)
    wild = course + 0.01 * np.random.default_rng(1).standard_normal(240)
    wild[77] += 2.0
    assert not without_wild_samples(set_of(wild)).wild
    (sample,) = without_wild_samples(set_of(wild), course).wild
    assert sample.sample == 77 and sample.moved == pytest.approx(-2.0, abs=0.1)


def test_sets_without_time_stay_as_they_are():
    data = set_of(COURSES["held"])
    columns = {key: value for key, value in data.runs[0].columns.items() if key != "time"}
    data = replace(data, runs=(replace(data.runs[0], columns=columns),))
    assert without_wild_samples(data) is data


@pytest.mark.parametrize(
    ("name", "samples", "verdict"),
    [
        ("wild_3_%/blocked_tip/nothing", 100, "adequate"),
        ("wild_3_%/blocked_tip/tube_lag", 200, "effects_missing"),
    ],
)
def test_a_set_with_wild_samples_is_diagnosed_as_one_without_and_says_so(
    name, samples, verdict, tmp_path
):
    case = next(case for case in all_cases() if case.name == name)
    replace(case, options={**case.options, "samples": samples}).make(tmp_path / "set", 3, 0.01)
    found = diagnose(load_measurements(tmp_path / "set"), load_model("base")).diagnosis
    assert found.verdict == verdict
    assert any("do not count" in notice["text"] for notice in found.notices)
