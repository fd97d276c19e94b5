"""Two plugs exchanged once, in sets of the second author with two repeats, and sets without."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.second_author.rig import new_rig, write
from bench.second_author.series_faults import exchanged, recorded
from model_lab.diagnosis.search import score_base
from model_lab.fitting.problem import pose_problem
from model_lab.measurements.load import load_measurements
from model_lab.series.events import ODD_RUN, examine, group_of_runs
from model_lab.series.exchange import exchanged_pair
from softhand_model.model_file import load_model

SEEDS = range(1100, 1112)


@pytest.fixture
def series(tmp_path):
    """Data, residual of the base model, its floor within runs, and the truth of a seed."""

    def made(seed, fault, repeats=2):
        rng = np.random.default_rng([seed, 7])
        rig = new_rig(rng, "free_bending", specimens=2, protocols=2, repeats=repeats)
        truth = fault(rng, rig)
        folder = tmp_path / f"{fault.__name__}_{seed}"
        write(rig, folder)
        problem, _ = pose_problem(load_measurements(folder), load_model("base"), {})
        return problem.data, score_base(problem, []).fit.residual, problem.floor.within, truth

    return made


def test_exchanged_plugs_show_with_two_repeats(series):
    found = 0
    for seed in SEEDS:
        data, residual, within, truth = series(seed, exchanged)
        odd = [event for event in examine(data, residual, within).events if event.kind == ODD_RUN]
        found += len(odd) == 2 and all({event.run, event.other} & set(truth.runs) for event in odd)
    assert found >= 10


def test_nothing_is_exchanged_in_a_day_without_a_fault(series):
    assert not any(examine(*series(seed, recorded)[:3]).events for seed in SEEDS)


def test_chance_of_an_agreement_among_specimens_that_are_alike(series):
    """Every run has the same course times a gain of normal scatter: p-values are uniform."""
    data, *_ = series(1100, recorded)
    group, rng = group_of_runs(data), np.random.default_rng(5)
    course = np.linspace(0.1, 1.0, data.runs[0].samples)
    small = 0
    for _ in range(200):
        runs = tuple(
            replace(run, columns={**run.columns, "tip_angle": course * gain})
            for run, gain in zip(data.runs, 1.0 + 0.01 * rng.standard_normal(8), strict=True)
        )
        scattered = replace(data, runs=runs)
        found = exchanged_pair(scattered, scattered.table.value - np.tile(course, 8), group)
        small += found is not None and found[1] <= 0.1
    assert 8 <= small <= 33  # 20 expected, 3 sigma
