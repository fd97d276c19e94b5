"""Lag and loops of a residual are those that were put in."""

import numpy as np
import pytest

from model_lab.localisation.input_relation import input_relation
from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen

TIME = np.linspace(0.0, 10.0, 1001)


def _set(course, count=1, experiment="free_bending", timed=True):
    columns = {"pressure": course, "tip_angle": 0.0 * course} | ({"time": TIME} if timed else {})
    if experiment == "base_torque":
        columns |= {f"torque_{axis}": 0.0 * course for axis in "xyz"}
    runs = tuple(Run(f"r{i}", "s", f"p{i}", 293.15, columns) for i in range(count))
    return MeasurementSet(experiment, "", {"s": Specimen("s")}, runs)


def test_a_residual_that_follows_the_input_later_shows_its_lag():
    course = np.exp(-((TIME - 5.0) ** 2))
    later = np.exp(-((TIME - 5.3) ** 2))
    relation = input_relation(_set(course, 3), -np.tile(later, 3))
    lag, correlation = relation.strongest()
    assert lag == pytest.approx(0.3, abs=0.02)
    assert correlation == pytest.approx(-1.0, abs=0.01)


def test_the_loop_of_an_ellipse_has_its_area():
    angle = 2.0 * np.pi * TIME / 10.0
    course, residual = 5.0 - 5.0 * np.cos(angle), -0.2 * np.sin(angle)
    relation = input_relation(_set(course), residual)
    assert relation.loop_area["r0"] == pytest.approx([np.pi * 5.0 * 0.2], rel=1e-4)
    # larger on the way down by the area over the span of 10
    assert relation.loop_width["r0"] == pytest.approx([np.pi * 0.1], rel=1e-4)


def test_the_width_of_loops_does_not_grow_with_their_number():
    triangle = np.abs((TIME / 2.5) % 2.0 - 1.0)
    falling = np.gradient(triangle) < 0.0
    relation = input_relation(_set(triangle), 0.1 * falling)
    assert relation.loop_width["r0"] == pytest.approx([0.1], rel=0.02)


def test_a_residual_without_loop_has_no_area():
    triangle = np.abs((TIME / 2.5) % 2.0 - 1.0)
    relation = input_relation(_set(triangle), triangle**3)
    assert relation.loop_area["r0"] == pytest.approx([0.0], abs=1e-12)


def test_every_output_has_its_own_relation():
    course = np.sin(TIME)
    residual = np.concatenate([course, -course, 0.0 * course])
    relation = input_relation(_set(course, 1, "base_torque"), residual)
    assert [relation.strongest(output)[1] for output in range(3)] == pytest.approx([1.0, -1.0, 0.0])


def test_without_time_lags_are_in_samples():
    relation = input_relation(_set(np.sin(TIME), timed=False), np.cos(TIME))
    assert relation.lag_unit == "samples"
    assert relation.lag[-1] == 100.0


def test_a_run_that_does_not_come_back_has_no_loop():
    relation = input_relation(_set(TIME), TIME**2)
    assert np.isnan(relation.loop_area["r0"]).all()
    assert np.isnan(relation.loop_width["r0"]).all()
