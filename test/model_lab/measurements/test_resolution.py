"""Steps of coarse sensors are seen, and how uncertain they leave the output."""

from dataclasses import replace

import numpy as np
import pytest
from toy_forward import toy_set

from model_lab.fitting.noise_floor import make_spectrum, noise_floor
from model_lab.measurements.resolution import rounding_errors, sensor_step

STEP = 0.01  # of the largest reading
COURSE = np.linspace(0.0, 1.0, 400)
ROUNDED = 1.0 / np.sqrt(12.0)  # standard deviation of what rounding to steps of 1 takes off


def rounded(course, step=STEP):
    return step * np.round(course / step)


def made_of(pressure, tip_angle):
    """A set without repeats in which every run has these readings (n,)."""
    data = toy_set(np.random.default_rng(0), samples=len(pressure))
    runs = [
        replace(
            run,
            protocol=run.name,
            columns={**run.columns, "pressure": pressure, "tip_angle": tip_angle},
        )
        for run in data.runs
    ]
    return replace(data, runs=tuple(runs), noise={"tip_angle": 1e-4})


def test_the_step_of_a_coarse_sensor_is_seen():
    found = sensor_step([3e4 * rounded(COURSE), 2e4 * rounded(COURSE, 0.015)])
    assert found == pytest.approx(300.0, rel=1e-4)


@pytest.mark.parametrize(
    "course",
    [
        COURSE,  # of a fine sensor
        rounded(COURSE, 0.1),  # set points
        np.r_[rounded(COURSE)[:-1], 0.99637],  # one reading between the steps
        np.ones(400),
    ],
)
def test_other_readings_have_no_step(course):
    assert sensor_step([course, course]) == 0.0
    assert rounding_errors(made_of(course, COURSE), np.tile(COURSE, 12)) is None


@pytest.mark.parametrize(
    ("pressure", "tip_angle", "size"),
    [
        (3e4 * rounded(COURSE), COURSE, STEP * ROUNDED),
        (3e4 * COURSE, rounded(COURSE), STEP * ROUNDED),
        (3e4 * rounded(COURSE), rounded(COURSE), np.sqrt(2.0) * STEP * ROUNDED),
    ],
)
def test_the_floor_of_a_set_without_repeats_knows_the_steps_of_its_sensors(
    pressure, tip_angle, size
):
    data = made_of(pressure, tip_angle)
    predicted = np.tile(COURSE, data.table.runs)
    assert np.std(rounding_errors(data, predicted)) == pytest.approx(size, rel=0.06)
    spectrum = make_spectrum(data.table, predicted)
    floor = noise_floor(data, spectrum, data.table.value - predicted)
    assert floor.total == pytest.approx(np.hypot(1e-4, size), rel=0.06)


def test_repeats_that_fall_on_the_same_steps_do_not_hide_them():
    coarse = rounded(COURSE, 0.06)
    data = made_of(3e4 * COURSE, coarse)
    data = replace(data, runs=tuple(replace(run, protocol="pull") for run in data.runs), noise={})
    predicted = np.tile(COURSE, data.table.runs)
    floor = noise_floor(data, make_spectrum(data.table, predicted), data.table.value - predicted)
    assert floor.total == pytest.approx(0.06 * ROUNDED, rel=0.06)


def test_readings_that_flicker_need_no_rounding():
    flicker = rounded(COURSE) + STEP * (np.arange(400) % 2)
    data = made_of(3e4 * COURSE, flicker)
    assert sensor_step([flicker]) == pytest.approx(STEP, rel=1e-4)
    assert not np.any(rounding_errors(data, np.tile(COURSE, data.table.runs)))


def test_what_is_held_is_uncertain_by_the_steps_of_its_sensor_in_all_repeats():
    """Levels held between whole steps, read alike in all repeats, and ramps between them."""
    levels = np.random.default_rng(4).uniform(0.1, 1.0, 40)
    held = np.repeat(levels, 10)
    pressure = 3e4 * rounded(held, 1 / 22)
    data = made_of(pressure, held)
    runs = tuple(replace(run, protocol="stairs") for run in data.runs)
    coarse = replace(data, runs=runs, noise={}, input_step=3e4 / 22)
    off = rounded(held, 1 / 22) - held

    def total(read):
        residual = np.tile(off, len(runs)) + np.random.default_rng(5).normal(0.0, 1e-3, 12 * 400)
        return noise_floor(read, make_spectrum(read.table, read.table.value), residual)

    assert total(coarse).total == pytest.approx(np.std(off), rel=0.15)
    assert total(replace(coarse, input_step=0.0)).total < 0.1 * np.std(off)
    assert total(coarse).upper > 1.02 * total(coarse).total  # few levels tell it
