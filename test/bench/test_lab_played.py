"""How the plays of proposed experiments are counted, and what is measured in them."""

import numpy as np
import pytest

import bench.lab  # noqa: F401  (puts the generator on the path)
import model_lab as lab
from bench.lab.played import NOISE, Played, measured, parted, summary


def answer(*groups):
    effects = [{"name": group[0]} for group in groups]
    return {"effects": effects, "tied": [list(group[1:]) for group in groups]}


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        (answer(("tube_lag",)), True),
        (answer(("creep", "tube_lag")), True),
        (answer(("tube_lag",), ("hysteresis",)), True),
        (answer(("tube_lag", "hysteresis")), False),
        (answer(("hysteresis",)), False),
        (answer(), False),
    ],
)
def test_a_pair_is_parted_when_the_truth_is_named_and_the_other_not_tied_with_it(said, expected):
    assert parted(said, "tube_lag", "hysteresis") is expected


def plays(planned, repeated, count=10):
    return [Played("c", 1, "a", "b", n < planned, n < repeated) for n in range(count)]


def test_target_and_control_are_judged():
    assert "(target 90%: met)" in summary(plays(9, 8), 1) and "fewer: met" in summary(
        plays(9, 8), 1
    )
    assert "(target 90%: MISSED)" in summary(plays(8, 8), 1)
    assert "fewer: MISSED" in summary(plays(8, 8), 1)
    assert "(target 90%: MISSED)" in summary([], 1)


def test_only_the_new_runs_are_predicted_and_they_have_noise():
    data = lab.synthesize("free_bending").set
    old = data.runs[:-1]
    both = measured(type(data)(**{**vars(data), "runs": old}), data, np.random.default_rng(0))
    assert both.runs[:-1] == old
    change = both.runs[-1].columns["tip_angle"] - data.runs[-1].columns["tip_angle"]
    most = max(float(np.abs(run.columns["tip_angle"]).max()) for run in old)
    assert np.std(change) == pytest.approx(NOISE * most, rel=0.3)
    assert np.array_equal(both.runs[-1].columns["pressure"], data.runs[-1].columns["pressure"])
