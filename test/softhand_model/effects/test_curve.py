"""Curves by values at knots, and what a value has done so far."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from softhand_model.effects.curve import course, levels, smooth_curve

KNOTS = (0.0, 1.0, 2.5, 3.0)
heights = st.lists(st.floats(-5.0, 5.0), min_size=4, max_size=4)


def _curve(values, place):
    return smooth_curve(KNOTS, dict(enumerate(values)), np.asarray(place, float))


@given(heights)
def test_it_goes_through_its_knots_and_is_constant_beyond(values):
    assert _curve(values, KNOTS) == pytest.approx(np.array(values))
    assert _curve(values, [-9.0, 9.0]) == pytest.approx(np.array([values[0], values[-1]]))


@given(heights, heights)
def test_it_is_linear_in_its_values(first, second):
    place = np.linspace(-1.0, 4.0, 40)
    both = _curve(np.array(first) + 2.0 * np.array(second), place)
    assert both == pytest.approx(_curve(first, place) + 2.0 * _curve(second, place), abs=1e-9)


def test_it_is_exact_for_straight_lines_and_has_no_kink():
    place = np.linspace(0.0, 3.0, 3001)
    assert _curve([0.0, 2.0, 5.0, 6.0], place) == pytest.approx(2.0 * place)
    slopes = np.diff(_curve([0.0, 1.0, 0.0, 3.0], place)) / np.diff(place)
    assert np.abs(np.diff(slopes)).max() < 0.03


def test_lanes_have_curves_of_their_own():
    values = {
        "a": np.array([0.0, 1.0]).reshape(-1, 1, 1),
        "b": np.array([2.0, 5.0]).reshape(-1, 1, 1),
    }
    found = smooth_curve((0.0, 1.0), values, np.full((1, 3, 1), 0.5))
    assert found.shape == (2, 3, 1)
    assert found[:, 0, 0].tolist() == [1.0, 3.0]
    assert smooth_curve((0.0, 1.0), values, 0.5).shape == (2, 1, 1)


def test_one_number_stays_one():
    values = {"a": 0.0, "b": 2.0}
    assert smooth_curve((0.0, 1.0), values, np.asarray(0.5)).shape == ()
    assert smooth_curve((0.0, 1.0), values, 0.5) == 1.0


def test_names_have_values_and_unknown_ones_the_neutral():
    given_names = np.array(["b", "c"]).reshape(1, -1, 1)
    assert levels(("a", "b"), {"x": 2.0, "y": 3.0}, given_names, 1.0).ravel().tolist() == [3.0, 1.0]
    assert levels(("a", "b"), {"x": 2.0, "y": 3.0}, None, 1.0) == 1.0


def test_a_course_knows_rate_direction_and_rest():
    memory, time = {}, np.arange(0.0, 10.0, 0.1)
    values = np.where(time < 5.0, 2.0 * time, 10.0)
    steps = np.diff(time, prepend=0.0)
    seen = [course(np.array(v), memory, dt, 0.2, 0.5) for v, dt in zip(values, steps, strict=True)]
    assert seen[40].rate == pytest.approx(2.0, rel=1e-3)
    assert seen[40].direction == 1.0
    assert seen[40].since == 0.0
    assert seen[-1].direction == pytest.approx(0.0, abs=1e-3)
    assert 4.0 < seen[-1].since < 5.0
    assert seen[-1].time == pytest.approx(9.9)


def test_a_course_tells_at_once_that_a_value_rests_or_moves_again():
    memory, time = {}, np.arange(0.0, 10.0, 0.1)
    values = np.interp(time, [0.0, 2.0, 7.0, 10.0], [0.0, 20.0, 20.0, 50.0])
    steps = np.diff(time, prepend=0.0)
    seen = [course(np.array(v), memory, dt, 0.07, 0.5) for v, dt in zip(values, steps, strict=True)]
    since = [float(one.since) for one in seen]
    assert since[20] == 0.0
    assert since[21] == pytest.approx(0.1)
    assert since[70] == pytest.approx(5.0)
    assert since[71] == 0.0
