"""Openings of the valves within the last 10 s."""

import numpy as np

from pneumaticbox_driver.box.diagnostics import ValveActivity


def test_openings_that_are_long_past_are_forgotten():
    activity = ValveActivity(2)
    for time in np.arange(0.0, 40.0, 0.01):
        # channel 0 opens 3 times a second for the first 10 s only, channel 1 all the time
        counts = [int(3 * min(time, 10.0)), int(3 * time)]
        activity.note(float(time), np.array(counts))
    assert activity.recent[0] == 0
    assert activity.recent[1] == 30


def test_before_a_sample_there_are_none():
    activity = ValveActivity(3)
    activity.note(float("nan"), np.array([0, 0, 0]))
    np.testing.assert_array_equal(activity.recent, 0)
    assert not activity.chatters.any()


def test_a_clock_that_is_set_back_begins_anew():
    activity = ValveActivity(1)
    activity.note(100.0, np.array([0]))
    activity.note(105.0, np.array([200]))
    activity.note(0.0, np.array([200]))
    activity.note(1.0, np.array([203]))
    assert activity.recent == 3
