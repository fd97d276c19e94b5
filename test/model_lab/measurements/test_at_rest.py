"""Readings at rest, of courses of which the truth is known."""

import numpy as np
import pytest

from model_lab.measurements.at_rest import beginning, lowest


@pytest.mark.parametrize("course", [lambda t: np.maximum(t - 1.0, 0.0), lambda t: 0.3 * t])
def test_the_zero_of_a_noisy_course_is_not_its_first_frame(course):
    """A finger that rests for a second, and one that moves at once, seen by a camera of 30 Hz."""
    rng, time, sigma = np.random.default_rng(1), np.arange(0.0, 6.0, 1.0 / 30.0), 0.017
    found = [beginning(course(time) + sigma * rng.standard_normal(len(time))) for _ in range(100)]
    assert np.sqrt(np.mean(np.square(found))) < 0.5 * sigma


def test_the_zero_of_a_ramp_that_bends_is_not_too_low():
    """A finger of rubber bends ever faster on an even ramp of pressure; a straight line through it
    begins 0.8 sigma too low.
    """
    rng, time, sigma = np.random.default_rng(3), np.arange(0.0, 6.0, 1.0 / 40.0), 0.007
    course = 0.2 * time + 0.03 * time**2
    found = [beginning(course + sigma * rng.standard_normal(len(time))) for _ in range(100)]
    assert abs(np.mean(found)) < 0.25 * sigma
    assert np.sqrt(np.mean(np.square(found))) < 0.8 * sigma


def test_a_course_without_noise_begins_with_its_first_sample():
    for course in (np.linspace(1.0, 2.0, 50) ** 3, np.repeat([0.0, 1.0], 20), np.zeros(1)):
        assert beginning(course) == pytest.approx(course[0], abs=2e-3)


def test_a_coarse_smooth_course_has_no_noise():
    course = 20.0 * (1.0 - np.cos(np.linspace(0.0, 2.0 * np.pi, 24)))
    assert beginning(course) == course[0] == lowest(course)[0]


def test_the_air_s_pressure_is_not_the_lowest_reading():
    rng, time = np.random.default_rng(2), np.arange(0.0, 20.0, 0.02)
    for rest, back in ((1.0, 0.0), (0.0, 1.0)):  # it rests before, or after, or only touches zero
        course = 101325.0 + 3e3 * np.clip(np.minimum(time - rest, 20.0 - time - back), 0.0, None)
        readings = course + 60.0 * rng.standard_normal(len(time))
        assert abs(np.median(lowest(readings)) - 101325.0) < 60.0 < 101325.0 - readings.min()
    middle = 101325.0 + 3e3 * np.abs(time - 10.0)  # where neither end is the lowest
    assert lowest(middle) == [middle.min()]
