"""The noise floor: from repeats, as stated, from the course; and repeats that are no repeats."""

from dataclasses import replace

import numpy as np
import pytest
from toy_forward import toy_forward, toy_set

from model_lab.fitting.noise_floor import REPEATS, SPLINE, STATED, make_spectrum, noise_floor


def floor_of(data):
    """The floor below the true model."""
    forward = toy_forward(data)
    predicted = forward.predict(np.array([[2.0, 0.5]]))[0]
    spectrum = make_spectrum(data.table, predicted)
    return noise_floor(data, spectrum, forward.measured - predicted)


def test_repeats_tell_the_noise_within_and_between_runs():
    floors = [
        floor_of(toy_set(np.random.default_rng(seed), gain=0.02, noise=0.03)) for seed in range(40)
    ]
    size = np.mean(
        toy_forward(toy_set(np.random.default_rng(0), gain=0.0, noise=0.0)).measured ** 2
    )
    assert {floor.source for floor in floors} == {REPEATS}
    within, between = (
        np.sqrt(np.mean([getattr(floor, part) ** 2 for floor in floors]))
        for part in ("within", "between")
    )
    assert within == pytest.approx(0.03, rel=0.03)
    assert between == pytest.approx(0.02 * np.sqrt(size), rel=0.15)


def test_a_wrong_model_does_not_raise_the_floor():
    data = toy_set(np.random.default_rng(1))
    forward = toy_forward(data)
    right = forward.predict(np.array([[2.0, 0.5]]))[0]
    spectrum = make_spectrum(data.table, right)
    wrong = forward.measured - right + 0.3 * np.sin(4.0 * forward.x)
    assert noise_floor(data, spectrum, wrong).total == pytest.approx(floor_of(data).total, rel=0.02)


def slipped(data, index, step):
    """The set with a step in the middle of one run."""
    run = data.runs[index]
    angle = run.columns["tip_angle"] + step * (np.arange(run.samples) > 50)
    runs = list(data.runs)
    runs[index] = replace(run, columns={**run.columns, "tip_angle": angle})
    return replace(data, runs=tuple(runs))


def test_a_run_in_which_something_slipped_does_not_raise_the_floor():
    data = toy_set(np.random.default_rng(2))
    plain = floor_of(data).total
    assert floor_of(slipped(data, 3, 0.5)).total == pytest.approx(plain, rel=0.25)


def test_runs_that_scatter_alike_are_all_kept():
    kept = 0
    for seed in range(100):
        floor = floor_of(toy_set(np.random.default_rng(seed)))
        kept += int(floor.dof[0] == 6)
    assert kept >= 97


def test_stated_noise_counts_without_repeats():
    data = replace(toy_set(np.random.default_rng(3), repeats=1), noise={"tip_angle": 0.07})
    floor = floor_of(data)
    assert (floor.source, floor.gain_known) == (STATED, False)
    assert floor.total == pytest.approx(0.07)


@pytest.mark.parametrize("kinks", [0, 8])
def test_noise_is_told_from_a_course_with_kinks(kinks):
    data = toy_set(np.random.default_rng(4), repeats=1, noise=0.05)
    bent = [
        replace(
            run,
            columns={
                **run.columns,
                "tip_angle": run.columns["tip_angle"]
                + np.abs((np.arange(run.samples) * kinks / 50.0) % 2.0 - 1.0),
            },
        )
        for run in data.runs
    ]
    floor = floor_of(replace(data, runs=tuple(bent)))
    assert floor.source == SPLINE
    assert floor.total == pytest.approx(0.05, rel=0.35)
