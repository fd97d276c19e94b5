"""The judge of the mass bias: what it passes, and that it sees an estimate that runs away."""

import numpy as np
import pytest

from bench.robust.mass_bias import Judge, cycles, grasps

KINDS = {"holding", "released", "vented", "reset"}


def worst(judge):
    return {kind: judge.worst(kind) for kind in judge.biases}


def test_a_grasp_released_against_the_table_and_a_vent_leave_less_than_a_milligram():
    judge = Judge()
    assert grasps(0.1, judge, seed=5) == 1
    assert judge.biases.keys() == KINDS
    assert max(worst(judge).values()) < 1.0
    assert judge.lowest > -1e-6


@pytest.mark.parametrize("poor", [False, True])
def test_cycles_on_the_bench_leave_less_than_a_milligram_with_poor_sensors_too(poor):
    judge = Judge()
    cycles(0.4, judge, poor=poor, seed=2)
    assert max(worst(judge).values()) < 1.0
    assert judge.lowest > -1e-6


def test_an_estimate_that_runs_away_while_vented_is_seen():
    judge = Judge()
    cycles(0.5, judge, sound=False)
    assert judge.worst("vented") > 1.0


def test_the_worst_channel_of_the_worst_rest_counts():
    judge = Judge()
    judge.look("vented", np.array([1e-6, 0.0]), np.array([1e-6, 0.0]))
    judge.look("vented", np.array([0.0, -3e-6]), np.array([0.0, 1e-6]))
    assert judge.worst("vented") == pytest.approx(4.0)
