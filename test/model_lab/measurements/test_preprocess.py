"""Noise of an input is taken off, its course stays."""

import numpy as np
import pytest

from model_lab.measurements.preprocess import noise_of, smoothed

TIME = np.linspace(0.0, 10.0, 500)
COURSES = {
    "ramp": 4e3 * TIME,
    "wave": 2e4 * (1.0 - np.cos(2.0 * np.pi * TIME / 5.0)),
    "triangle": 4e3 * (5.0 - np.abs(TIME - 5.0)),
    "steps": 1e4 * np.floor(TIME / 2.0),
}


def noisy(course, seed=0):
    return course + 100.0 * np.random.default_rng(seed).standard_normal(len(course))


@pytest.mark.parametrize("name", COURSES)
def test_noise_is_known_from_its_fourth_differences(name):
    assert noise_of(noisy(COURSES[name])) == pytest.approx(100.0, rel=0.15)


@pytest.mark.parametrize("name", COURSES)
def test_what_is_left_of_the_noise_is_below_a_half(name):
    left = smoothed(noisy(COURSES[name])) - COURSES[name]
    assert np.sqrt(np.mean(left**2)) < 50.0


@pytest.mark.parametrize("name", COURSES)
def test_a_course_without_noise_stays_as_it_is(name):
    assert np.array_equal(smoothed(COURSES[name]), COURSES[name])


@pytest.mark.parametrize("half", [3, 5, 6, 8, 20])
def test_corners_that_follow_closely_are_no_noise(half):
    course = 1e4 * np.abs((np.arange(300) / half) % 2.0 - 1.0)
    assert np.array_equal(smoothed(course), course)


def test_a_step_stays_where_it_is():
    course = 1e4 * (TIME > 5.0)
    left = smoothed(noisy(course)) - course
    assert np.max(np.abs(left)) < 500.0


def test_what_the_noise_was_does_not_shift_the_course():
    errors = [smoothed(noisy(COURSES["wave"], seed)) - COURSES["wave"] for seed in range(200)]
    assert np.max(np.abs(np.mean(errors, axis=0))) < 40.0
