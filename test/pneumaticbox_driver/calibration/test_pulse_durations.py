"""Durations of Algorithm 1: exponential, balanced, and carrying a channel through its range."""

from dataclasses import replace

import numpy as np
import pytest

from pneumaticbox_driver.calibration.recording import PulseDurations, PulseRanges

THESIS = PulseRanges(
    shortest=0.045, longest=4.0, mean_duration=1.0, high_pressure=60e3, skew_factor=2.0
)
INFLATING = 4e3  # rise of pressure in a bottle of 0.5 L [Pa/s]


class PrintedDurations(PulseDurations):
    """Algorithm 1 as it is printed: the speed ratio upside down."""

    def next(self, gauge):
        inflation, deflation = super().next(gauge)
        shortest, ratio = self._plan.shortest, self._plan.speed_ratio
        return inflation, shortest + (deflation - shortest) * ratio**2


def pressures(durations, cycles, speed_ratio, channels=20):
    """Gauge pressures (cycles, channels) of bottles whose deflation is so much faster."""
    gauge, course = np.zeros(channels), []
    for _ in range(cycles):
        inflation, deflation = durations.next(gauge)
        gauge = gauge + INFLATING * inflation
        # the speeds compare half way up; towards ambient pressure deflation slows down
        flow = INFLATING * speed_ratio * np.sqrt(gauge / 30e3)
        gauge = np.maximum(gauge - flow * deflation, 0.0)
        course.append(gauge)
    return np.array(course)


def test_the_pressure_range_is_covered_where_the_printed_form_sticks_at_ambient():
    plan = replace(THESIS, speed_ratio=5.0)
    right = pressures(PulseDurations(plan, 20, seed=1), 400, 5.0)
    printed = pressures(PrintedDurations(plan, 20, seed=1), 400, 5.0)
    for channel in right.T:
        counts, _ = np.histogram(channel, bins=5, range=(0.0, plan.high_pressure))
        assert (counts > 15).all()
    assert np.quantile(printed, 0.95) < 0.05 * plan.high_pressure


def test_with_the_few_points_of_the_thesis_s_adverse_case_the_defaults_cover_the_range():
    plan = PulseRanges()
    course = pressures(PulseDurations(plan, 20, seed=1), 25, plan.speed_ratio)
    assert (course.max(axis=0) > 0.7 * plan.high_pressure).all()
    thesis = pressures(PulseDurations(replace(plan, skew_factor=2.0), 20, seed=1), 25, 4.0)
    assert not (thesis > 0.7 * plan.high_pressure).any()


def test_the_faster_deflation_gets_the_shorter_pulses_and_the_skew_reverses():
    plan = PulseRanges()
    durations = PulseDurations(plan, 4000, seed=1)
    up = durations.next(np.full(4000, 1e3))
    down = durations.next(np.full(4000, 150e3))
    kept = durations.next(np.full(4000, 50e3))
    beyond = [np.mean(drawn) - plan.shortest for drawn in (*up, *down, *kept)]
    assert beyond[0] / beyond[2] == pytest.approx(plan.skew_factor, rel=0.1)
    assert beyond[3] / beyond[1] == pytest.approx(plan.skew_factor, rel=0.1)
    assert beyond[0] / beyond[3] == pytest.approx(plan.speed_ratio, rel=0.1)
    assert beyond[4] == pytest.approx(beyond[2], rel=0.1)


def test_durations_are_exponential_so_that_short_pulses_are_most():
    plan = replace(THESIS, skew_factor=1.0)
    drawn = PulseDurations(plan, 4000, seed=1).next(np.full(4000, 50e3))[0]
    assert plan.shortest <= drawn.min() and drawn.max() <= plan.longest
    assert np.mean(drawn < plan.shortest + plan.mean_duration) == pytest.approx(0.645, abs=0.02)


def test_no_pulse_is_shorter_than_a_valve_can_follow_whatever_the_skew():
    plan = PulseRanges()
    durations = PulseDurations(plan, 1000, seed=3)
    for gauge in (0.0, 200e3):
        for drawn in durations.next(np.full(1000, gauge)):
            assert drawn.min() >= plan.shortest
