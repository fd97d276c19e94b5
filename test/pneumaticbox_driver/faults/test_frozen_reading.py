"""A sensor that repeats its reading, against readings that merely look like it."""

import numpy as np
import pytest

from pneumaticbox_driver.faults.fault_watch import LESSON, FrozenReading

STEP = 61.0  # of the converter [Pa]
IN_RANGE = np.ones(1, dtype=bool)


def converted(noise, level, count, seed=0):
    """Readings of a converter whose input is `level` with noise, both in steps."""
    drawn = np.random.default_rng(seed).normal(level, noise, count)
    return STEP * np.round(drawn)


def taught(readings):
    watch = FrozenReading(1)
    for value in readings[:LESSON]:
        watch.look(np.array([value]), IN_RANGE)
    return watch


def samples_marked(watch, readings):
    marked = 0
    for value in readings:
        watch.look(np.array([value]), IN_RANGE)
        marked += bool(watch.frozen[0])
    return marked


@pytest.mark.parametrize("noise", [0.0, 0.05, 0.15, 0.3, 0.5, 1.0, 3.0])
@pytest.mark.parametrize("level", [0.0, 0.25, 0.5])
def test_noise_of_any_size_is_never_taken_for_a_frozen_sensor_wherever_it_goes_on(noise, level):
    watch = taught(converted(noise, level, LESSON))
    for other in (0.0, 0.2, 0.5):
        assert samples_marked(watch, converted(noise, other, 5000, seed=7)) == 0


@pytest.mark.parametrize("noise", [0.7, 1.0, 3.0])
def test_a_noisy_sensor_that_freezes_is_marked_within_half_a_second_of_samples(noise):
    watch = taught(converted(noise, 0.3, LESSON))
    stuck = np.full(250, 5 * STEP)
    assert samples_marked(watch, stuck[:15]) == 0
    assert samples_marked(watch, stuck[15:]) > 0


def test_the_noise_is_learnt_from_steps_so_that_a_slow_drift_does_not_count():
    drift = np.linspace(0, 5000.0, LESSON)
    watch = taught(np.random.default_rng(1).normal(drift, 60.0))
    assert watch.noise[0] == pytest.approx(60.0, rel=0.25)


@pytest.mark.parametrize(("samples", "marked"), [(96, False), (101, True)])
def test_a_run_of_equal_readings_is_judged_by_half_the_share_of_steps_that_was_seen(
    samples, marked
):
    """A step in two samples: at one in four a run of 97 has a chance of 1e-12."""
    lesson = np.zeros(LESSON)
    lesson[3::4] = STEP * np.resize([1, -1, 2], len(lesson[3::4]))
    watch = taught(lesson)
    assert (samples_marked(watch, np.full(samples, 9 * STEP)) > 0) == marked


def test_the_noise_is_learnt_once():
    watch = taught(np.random.default_rng(1).normal(0.0, 60.0, LESSON))
    noise = watch.noise[0]
    samples_marked(watch, np.random.default_rng(1).normal(0.0, 600.0, 2 * LESSON))
    assert watch.noise[0] == noise


def test_a_quiet_sensor_that_drifts_over_steps_at_the_start_may_stand_still_afterwards():
    drift = STEP * np.round(np.linspace(0, 8, LESSON))
    assert samples_marked(taught(drift), np.zeros(2000)) == 0


def test_a_sensor_at_the_end_of_its_range_may_stand_still():
    watch = taught(converted(1.0, 0.0, LESSON))
    for _ in range(500):
        watch.look(np.array([-5000.0]), np.zeros(1, dtype=bool))
    assert not watch.frozen.any()
