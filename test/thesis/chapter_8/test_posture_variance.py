"""Posture against actuation: what the analysis says of postures that are made up."""

from functools import cache

import numpy as np
import pytest
from scipy.optimize import check_grad

from bench.dexterity import posture
from thesis.chapter_8.gaussian_process import GaussianProcess, cross_validated_errors
from thesis.chapter_8.posture_variance import (
    INTERACTION,
    LINEAR,
    NONLINEAR,
    Estimate,
    GraspPostures,
    components_to,
    correlations,
    noise_floor,
    participation_ratio,
    residual_variance,
)

made_up = cache(posture.made_up)


@pytest.mark.parametrize("kind", [LINEAR, NONLINEAR, INTERACTION])
def test_each_kind_of_made_up_postures_is_told_for_what_it_is(kind):
    assert [made_up(kind, seed).kind for seed in (1, 2, 3)] == [kind] * 3


def test_noisier_trials_with_the_object_are_no_interaction():
    assert made_up(NONLINEAR, 1, held_noise=4e-3).kind == NONLINEAR
    assert made_up(LINEAR, 1, held_noise=4e-3).kind == LINEAR


def test_a_regression_predicts_a_curved_map_of_actuation_but_not_the_object():
    curved, touched = made_up(NONLINEAR, 1), made_up(INTERACTION, 1)
    assert not curved.unpredicted_excess.shown
    assert touched.unpredicted_excess.shown
    assert touched.unpredicted["held"] > touched.unpredicted["empty"] + 0.05


def test_postures_that_are_linear_in_actuation_are_predicted_to_a_thousandth():
    assert abs(made_up(LINEAR, 1).unpredicted["held"]) < 1e-3


def test_residual_variance_falls_from_all_to_nothing():
    points = np.random.default_rng(0).normal(size=(30, 15))
    left = residual_variance(points)
    assert left.shape == (16,)
    assert left[0] == pytest.approx(1.0) and left[-1] == 0.0
    assert (np.diff(left) < 0).all()


def test_residual_variance_is_that_of_principal_components():
    points = np.random.default_rng(1).normal(size=(12, 6)) @ np.diag([5, 4, 3, 2, 1, 0.5])
    values = np.linalg.svd(points - points.mean(axis=0), compute_uv=False) ** 2
    assert residual_variance(points)[2] == pytest.approx(values[2:].sum() / values.sum())


def test_fewer_grasps_than_coordinates_leave_nothing_beyond_their_number():
    left = residual_variance(np.random.default_rng(2).normal(size=(5, 15)))
    assert left[4] == pytest.approx(0.0, abs=1e-12)
    assert left.shape == (16,)


def test_a_residual_that_is_all_noise_is_at_the_noise_floor():
    draw = np.random.default_rng(3)
    plane = draw.normal(size=(400, 2)) @ draw.normal(size=(2, 15))
    trials = plane + draw.normal(0.0, 0.1, (2, 400, 15))
    residual, floor = residual_variance(trials.mean(axis=0)), noise_floor(trials)
    assert residual[2] == pytest.approx(floor[2], rel=0.1)


def test_components_and_participation_ratio_count_the_dimensions_of_a_cloud():
    cloud = np.random.default_rng(4).normal(size=(4000, 3)) @ np.eye(3, 15)
    assert participation_ratio(cloud) == pytest.approx(3.0, abs=0.05)
    assert components_to(cloud) == 3
    assert components_to(cloud, 0.6) == 2


def test_an_estimate_is_shown_when_hardly_a_resample_is_zero_or_less():
    assert Estimate.of(1.0, np.linspace(0.1, 2.0, 999)).p == pytest.approx(0.001)
    assert not Estimate.of(1.0, np.linspace(-1.0, 9.0, 999)).shown


def test_the_same_seed_gives_the_same_intervals():
    first, again = (posture.made_up(INTERACTION, 5, 20).excess for _ in range(2))
    assert first == again


def test_empty_trials_of_another_shape_are_refused():
    trials = np.zeros((2, 8, 15))
    with pytest.raises(ValueError, match=r"empty: expected shape \(2, 8, 15\), got \(2, 7, 15\)"):
        GraspPostures(np.zeros((8, 4)), trials, trials[:, 1:])


def test_channels_that_go_together_correlate_and_one_that_stands_still_does_not():
    a = np.random.default_rng(6).uniform(size=50)
    found = correlations(np.column_stack([a, 2 * a + 1, np.full(50, 0.5)]))
    assert found[0, 1] == pytest.approx(1.0)
    assert (found[2] == [0, 0, 1]).all()


def test_pure_noise_is_not_predicted():
    draw = np.random.default_rng(7)
    inputs, outputs = draw.uniform(size=(30, 4)), draw.normal(size=(30, 15))
    share = cross_validated_errors(inputs, outputs).sum() / (outputs**2).sum()
    assert 0.9 < share < 1.2


def test_the_slope_of_the_likelihood_is_that_of_its_differences():
    draw = np.random.default_rng(8)
    process = GaussianProcess(draw.uniform(size=(15, 2)), draw.normal(size=(15, 3)))
    at = np.log([0.7, 1.3, 0.2, 0.5, 0.8])
    _, slope = process._unlikeliness(at)
    error = check_grad(
        lambda x: process._unlikeliness(x)[0], lambda x: process._unlikeliness(x)[1], at
    )
    assert error < 1e-5 * np.linalg.norm(slope)


def test_an_interval_of_a_residual_lies_about_its_value():
    for name in ("held", "empty"):
        value, low, high = made_up(INTERACTION, 1).curve(name)
        assert (low[1:10] < value[1:10]).all() and (value[1:10] < high[1:10]).all()


def test_a_resample_of_one_grasp_alone_spans_nothing():
    same = np.ones((2, 4, 3))
    assert (residual_variance(same[0]) == 0.0).all() and (noise_floor(same) == 0.0).all()
