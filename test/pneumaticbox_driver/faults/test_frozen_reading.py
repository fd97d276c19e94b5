"""A sensor that repeats its reading, against readings that merely look like it."""

import math

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import binom, norm

from pneumaticbox_driver.faults.frozen_reading import FROZEN_CHANCE, LEARNING_SAMPLES, FrozenReading

STEP = 61.0  # of the converter [Pa]
IN_RANGE = np.ones(1, dtype=bool)


def converted(noise, level, count, seed=0):
    """Readings of a converter whose input is `level` with noise, both in steps."""
    drawn = np.random.default_rng(seed).normal(level, noise, count)
    return STEP * np.round(drawn)


def taught(readings):
    watch = FrozenReading(1)
    for value in readings[:LEARNING_SAMPLES]:
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
    watch = taught(converted(noise, level, LEARNING_SAMPLES))
    for other in (0.0, 0.2, 0.5):
        assert samples_marked(watch, converted(noise, other, 5000, seed=7)) == 0


@pytest.mark.parametrize("noise", [0.7, 1.0, 3.0])
def test_a_noisy_sensor_that_freezes_is_marked_within_half_a_second_of_samples(noise):
    watch = taught(converted(noise, 0.3, LEARNING_SAMPLES))
    stuck = np.full(250, 5 * STEP)
    assert samples_marked(watch, stuck[:15]) == 0
    assert samples_marked(watch, stuck[15:]) > 0


def test_the_noise_is_learnt_from_steps_so_that_a_slow_drift_does_not_count():
    drift = np.linspace(0, 5000.0, LEARNING_SAMPLES)
    watch = taught(np.random.default_rng(1).normal(drift, 60.0))
    assert watch.noise[0] == pytest.approx(60.0, rel=0.25)


def samples_until_marked(watch):
    """Repeats of a reading at which a sensor is marked, infinite where it never is."""
    marked = (n for n in range(500) if samples_marked(watch, np.full(1, 9e3)))
    return next(marked, math.inf)


def test_with_many_repeats_the_upper_confidence_limit_of_their_share_counts():
    lesson = np.zeros(LEARNING_SAMPLES)
    lesson[3::4] = STEP * np.resize([1, -1, 2], len(lesson[3::4]))
    equal = int(np.sum(np.diff(lesson) == 0))
    longest = samples_until_marked(taught(lesson))
    # chance of a run, by the share of repeats at which so few would be seen once in a thousand
    shares = [FROZEN_CHANCE ** (1 / n) for n in (longest - 1, longest)]
    fits = [binom.cdf(equal, LEARNING_SAMPLES - 1, share) < 1e-3 for share in shares]
    assert fits == [False, True]


@pytest.mark.parametrize("noise", [0.7, 1.0, 2.0])
@pytest.mark.parametrize("level", [0.0, 0.25, 0.5])
def test_a_coarse_sensor_is_judged_as_if_its_pressure_lay_in_the_middle_of_a_step(noise, level):
    edges = norm.cdf((np.arange(-30, 31) + 0.5) / noise)
    repeats = np.sum(np.diff(edges) ** 2)  # of white noise, where they are most frequent
    for seed in range(20):
        watch = taught(converted(noise, level, LEARNING_SAMPLES, seed))
        assert samples_until_marked(watch) > math.log(FROZEN_CHANCE) / math.log(repeats)


def test_a_fine_sensor_that_freezes_is_marked_within_a_dozen_samples():
    for seed in range(20):
        watch = taught(np.random.default_rng(seed).normal(0.0, 150.0, LEARNING_SAMPLES).round(1))
        assert 9 <= samples_until_marked(watch) <= 12


@pytest.mark.parametrize("correlation", [0.3, 0.6])
def test_noise_that_is_correlated_is_not_taken_for_a_frozen_sensor(correlation):
    for seed in range(20):
        drawn = np.random.default_rng(seed).normal(0.0, 1.0, LEARNING_SAMPLES + 5000)
        correlated = STEP * np.round(lfilter([1.0], [1.0, -correlation], drawn))
        assert samples_marked(taught(correlated), correlated[LEARNING_SAMPLES:]) == 0


def of_three(noise, level, count, seed=0, common=0.0):
    """Readings (count, 3) of converters whose inputs share a part of their noise."""
    drawn = np.random.default_rng(seed).normal(0.0, noise, (count, 4))
    own, shared = math.sqrt(1 - common), math.sqrt(common)
    return STEP * np.round(level + own * drawn[:, :3] + shared * drawn[:, 3:])


def runs_until_marked(lesson, still):
    """Repeats at which sensors of a lesson (n, 3) are marked when the `still` ones stand still."""
    watch = FrozenReading(3)
    going_on = of_three(1.0, 0.3, 500, seed=99)
    for readings in (*lesson, *np.where(still, 9e3, going_on)):
        watch.look(readings, np.ones(3, dtype=bool))
        if watch.frozen.any():
            return watch.run.max()
    return math.inf


def test_coarse_sensors_that_stand_still_together_are_marked_sooner_than_each_of_them():
    for seed in range(20):
        lesson = of_three(1.0, 0.3, LEARNING_SAMPLES, seed)
        alone = [runs_until_marked(lesson, still) for still in np.eye(3, dtype=bool)]
        together = 1.0 / np.sum(1.0 / np.array(alone))  # as their chances multiply
        assert abs(runs_until_marked(lesson, [True, True, True]) - together) <= 1.0
        assert runs_until_marked(lesson, [True, True, False]) == min(alone[:2])


def test_fine_sensors_of_a_board_that_repeats_itself_for_a_moment_are_not_marked():
    lesson = np.random.default_rng(0).normal(0.0, 150.0, (LEARNING_SAMPLES, 3)).round(1)
    assert runs_until_marked(lesson, [True, True, True]) > 10


def test_sensors_with_noise_in_common_are_judged_one_by_one():
    for seed in range(20):
        lesson = of_three(1.0, 0.3, LEARNING_SAMPLES, seed, common=0.8)
        alone = min(runs_until_marked(lesson, still) for still in np.eye(3, dtype=bool))
        assert runs_until_marked(lesson, [True, True, True]) == alone


@pytest.mark.parametrize("noise", [0.5, 0.7, 1.0, 3.0])
@pytest.mark.parametrize("common", [0.0, 0.3])
def test_noise_of_several_sensors_is_never_taken_for_sensors_that_stand_still(noise, common):
    for seed in range(3):
        watch = FrozenReading(3)
        lesson = of_three(noise, 0.25, LEARNING_SAMPLES, seed, common)
        after = [of_three(noise, at, 2000, seed + 50, common) for at in (0.0, 0.25, 0.5)]
        for readings in (*lesson, *np.concatenate(after)):
            watch.look(readings, np.ones(3, dtype=bool))
            assert not watch.frozen.any()


def test_the_noise_is_learnt_once():
    watch = taught(np.random.default_rng(1).normal(0.0, 60.0, LEARNING_SAMPLES))
    noise = watch.noise[0]
    samples_marked(watch, np.random.default_rng(1).normal(0.0, 600.0, 2 * LEARNING_SAMPLES))
    assert watch.noise[0] == noise


def test_a_quiet_sensor_that_drifts_over_steps_at_the_start_may_stand_still_afterwards():
    drift = STEP * np.round(np.linspace(0, 8, LEARNING_SAMPLES))
    assert samples_marked(taught(drift), np.zeros(2000)) == 0


@pytest.mark.parametrize(("turns", "marked"), [([0, 1, 2, 1], False), ([0, 1, 2, 3, 2, 1], True)])
def test_noise_shows_in_four_readings_at_least(turns, marked):
    watch = taught(STEP * np.resize(turns, LEARNING_SAMPLES))
    assert (samples_marked(watch, np.full(500, 9 * STEP)) > 0) == marked


def test_a_course_that_never_turns_back_is_no_noise_however_fast_it_is():
    assert samples_marked(taught(STEP * np.arange(LEARNING_SAMPLES)), np.zeros(2000)) == 0


def test_a_sensor_at_the_end_of_its_range_may_stand_still():
    watch = taught(converted(1.0, 0.0, LEARNING_SAMPLES))
    for _ in range(500):
        watch.look(np.array([-5000.0]), np.zeros(1, dtype=bool))
    assert not watch.frozen.any()
