"""Shortest pulses and pauses of slow valves."""

import numpy as np

from pneumaticbox_driver.control.channels import PulseTiming


def history(wanted):
    """Valves over time in steps of 10 ms, for what is wanted at each (channel 0 of 1)."""
    timing, past = PulseTiming(1, shortest_pulse=0.045, shortest_pause=0.06), []
    valves = np.zeros(1, dtype=np.int8)
    for k, want in enumerate(wanted):
        follow = timing.follow(0.01 * k, valves, np.array([want], dtype=np.int8))
        timing.note(0.01 * k, follow != valves)
        valves = follow
        past.append(int(valves[0]))
    return past


def test_a_short_wish_becomes_a_shortest_pulse():
    assert history([1, *[0] * 9]) == [1, 1, 1, 1, 1, 0, 0, 0, 0, 0]


def test_a_long_wish_is_followed_as_it_is():
    assert history([*[1] * 8, 0, 0]) == [*[1] * 8, 0, 0]


def test_between_pulses_there_is_a_pause():
    assert history([1] * 6 + [0] + [1] * 8) == [1] * 6 + [0] * 6 + [1] * 3


def test_the_other_outlet_follows_only_through_a_pause():
    assert history([1] * 6 + [-1] * 9) == [1] * 6 + [0] * 6 + [-1] * 3


def test_the_inlet_follows_the_outlet_only_through_a_pause():
    assert history([-1] * 6 + [1] * 9) == [-1] * 6 + [0] * 6 + [1] * 3


def test_channels_do_not_wait_for_each_other():
    timing = PulseTiming(2, 0.045, 0.06)
    valves = np.array([1, 0], dtype=np.int8)
    timing.note(0.0, valves != 0)
    assert timing.follow(0.01, valves, np.array([0, -1], dtype=np.int8)).tolist() == [1, -1]
