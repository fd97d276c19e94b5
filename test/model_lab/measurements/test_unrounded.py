"""The course of an input, of which a coarse sensor shows steps."""

import numpy as np
import pytest
from lab_sets import measured, run

from model_lab.measurements.unrounded import unrounded, without_rounding

TIME = np.arange(0.0, 20.0, 0.05)
COURSES = {  # slow enough for some samples a step; what is held is held at a whole step
    "triangle": 34.0 * (1.0 - np.abs(TIME / 10.0 - 1.0)),
    "held": np.clip(3.0 * (TIME - 4.0), 0.0, 21.0),
    "rise": 30.0 * (1.0 - np.exp(-TIME / 3.0)),
    "wave": 15.0 - 15.0 * np.cos(0.4 * TIME),
}


@pytest.mark.parametrize("step", [0.5, 1.0])
@pytest.mark.parametrize("course", COURSES)
def test_most_of_the_rounding_goes(course, step):
    true = COURSES[course]
    readings = step * np.round(true / step)
    found = unrounded(TIME, readings, step)
    assert np.std(found - true) < 0.5 * np.std(readings - true)
    assert np.abs(found - readings).max() <= 0.5 * step + 1e-9


def test_large_jumps_and_constant_inputs_stay():
    jump = np.where(TIME < 10.0, 0.0, 20.0)
    assert np.array_equal(unrounded(TIME, jump, 0.5), jump)
    assert np.array_equal(unrounded(TIME, 0.0 * TIME, 0.5), 0.0 * TIME)


@pytest.mark.parametrize(("samples_a_step", "rounded"), [(8, True), (1, False)])
def test_levels_that_a_program_made_are_no_rounding(samples_a_step, rounded):
    """Triangles that go a whole step from sample to sample."""
    up = np.arange(0, 30 * samples_a_step + 1) / samples_a_step
    course = 1e3 * np.tile(np.r_[up, up[-2:0:-1]], 4)
    pressure = 1e3 * np.round(course / 1e3)
    data = measured("free_bending", [run("r", np.arange(len(course)) * 0.05, pressure=pressure)])
    found = without_rounding(data)
    assert (found.input_step > 0.0) == rounded
