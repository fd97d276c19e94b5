"""Which runs were driven alike, and so repeat each other."""

import numpy as np
import pytest

from model_lab.measurements.drives import drive_of, driven_alike

TIME = np.linspace(0.0, 12.0, 600)
FIRST_RISE = TIME <= 3.0


def triangles(level=1.0, slower=1.0, late=0.0, kept=None):
    """Two triangles up to 40 kPa with noise, as a pump that is driven by hand makes them."""
    kept = np.ones(len(TIME), bool) if kept is None else kept
    course = np.interp((TIME - late) % 6.0, [0.0, 3.0, 6.0], [0.0, 40e3, 0.0]) * (late <= TIME)
    noise = 200.0 * np.random.default_rng(1).standard_normal(len(TIME))
    columns = {"time": slower * TIME[kept], "pressure": (level * course + noise)[kept]}
    return drive_of(columns, {}, "pressure")


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        ({"level": 1.1, "slower": 0.7}, True),  # by hand
        ({"late": 1.0}, True),  # the recording began earlier
        ({"kept": FIRST_RISE}, True),  # ... or ended earlier
        ({"kept": FIRST_RISE, "slower": 1.01}, True),
        ({"level": 0.8}, True),  # the sensor was changed
        ({"level": 0.5}, False),
        ({"slower": 3.0}, False),
        ({"slower": 3.0, "kept": FIRST_RISE}, False),
        ({"level": 6.9}, True),  # in another unit, which is no other drive
        ({"slower": 1e3}, True),  # a clock in ms
    ],
)
def test_repeats_are_told_from_other_levels_and_paces(other, expected):
    first, second = triangles(), triangles(**other)
    assert driven_alike(first, second) == driven_alike(second, first) == expected


def held(levels, slower=1.0, seed=0):
    """Held levels, with noise."""
    time = np.linspace(0.0, 2.0 * len(levels), 200 * len(levels))
    value = np.asarray(levels, float)[np.minimum(time // 2.0, len(levels) - 1).astype(int)]
    value += 0.02 * np.random.default_rng(seed).standard_normal(len(time))
    return drive_of({"time": slower * time, "pressure": np.r_[0.0, value[1:]]}, {}, "pressure")


@pytest.mark.parametrize(
    ("levels", "expected"),
    [
        ([0.25, 0.5, 0.75, 1.0, 0.0], True),
        ([0.3, 0.52, 0.7, 1.05, 0.0], True),  # by hand
        ([1.0, 0.3, 0.6, 1.0, 0.0], False),
        ([0.25, 0.75, 0.25, 1.0, 0.0], False),
    ],
)
def test_repeats_go_to_the_same_levels_in_the_same_order(levels, expected):
    first, second = held([0.25, 0.5, 0.75, 1.0, 0.0]), held(levels, slower=1.1, seed=1)
    assert driven_alike(first, second) == driven_alike(second, first) == expected


def test_runs_that_hold_their_input_repeat_those_of_the_same_level():
    noise = 0.1 * np.random.default_rng(0).standard_normal(len(TIME))
    rest, low, high, higher = (
        drive_of({"time": TIME, "pressure": level + level * noise / 10.0}, {}, "pressure")
        for level in (0.0, 10.0, 35.0, 36.0)
    )
    assert driven_alike(high, higher) and not driven_alike(low, high)
    assert not driven_alike(rest, low) and driven_alike(rest, rest)


def test_a_table_without_a_clock_is_told_by_its_range():
    levels = np.linspace(0.0, 40.0, 9)
    half, whole, finer = (
        drive_of({"pressure": values}, {}, "pressure")
        for values in (0.5 * levels, levels, np.linspace(0.0, 40.0, 17))
    )
    assert driven_alike(whole, finer) and not driven_alike(whole, half)


def test_a_spike_of_the_sensor_is_no_other_level():
    spiked = np.where(np.arange(len(TIME)) == 100, 90.0, np.minimum(TIME, 6.0))
    plain = drive_of({"time": TIME, "pressure": np.minimum(TIME, 6.0)}, {}, "pressure")
    assert driven_alike(drive_of({"time": TIME, "pressure": spiked}, {}, "pressure"), plain)
