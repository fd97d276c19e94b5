"""The order in which lanes are solved: every lane once, after the near one it begins from."""

import numpy as np
import pytest

from model_lab.experiments.base_torque import lane_values, neutral_lane, waves
from softhand_model.effects import effect_classes

SLACK = effect_classes()["passive_layer_slack"]
GENT = effect_classes()["gent_stiffening"]


def test_every_lane_follows_one_that_has_been_solved():
    values = np.random.default_rng(0).normal(size=(20, 3))
    solved = {0, 1}
    for lanes, starts in waves(values, 2):
        assert set(starts) <= solved
        solved |= set(lanes.tolist())
    assert solved == set(range(20))


def test_lanes_of_a_jacobian_begin_at_their_centre_and_a_grid_goes_step_by_step():
    centres = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0]])
    shifted = centres + [[0.0, 1e-4]]
    begun = {
        int(lane): int(start)
        for lanes, starts in waves(np.concatenate([centres, shifted]), 1)
        for lane, start in zip(lanes, starts, strict=True)
    }
    assert [begun[lane] for lane in (1, 2)] == [0, 1]
    assert all(begun[4 + lane] == lane for lane in range(4))


def test_the_scale_of_a_parameter_does_not_matter():
    values = np.random.default_rng(1).normal(size=(9, 2))
    for plain, scaled in zip(waves(values, 1), waves(values * [1e9, 1e-9], 1), strict=True):
        assert np.array_equal(plain, scaled)


def test_values_and_what_does_nothing_stand_side_by_side():
    effects = [SLACK.in_lanes({"ratio": [0.4, 0.7]}), GENT.in_lanes({"jm": [3.0, 9.0]})]
    values = lane_values({"modulus_scale[A]": np.array([0.9])}, effects)
    assert values == pytest.approx(np.array([[0.9, 0.4, 3.0], [0.9, 0.7, 9.0]]))
    plain = neutral_lane(values, {"modulus_scale[A]": np.array([0.9])}, effects, {})
    assert plain == pytest.approx(np.array([[1.0, 1.0, 3.0]]))
    given = neutral_lane(values, {"modulus_scale[A]": 0.9}, effects, {"ratio": 0.5})
    assert given == pytest.approx(np.array([[1.0, 0.5, 3.0]]))
