from dataclasses import replace

import numpy as np
import pytest
from toy_forward import ToyForward, ToyParameter, toy_forward, toy_set

from model_lab.experiments.own_errors import OwnErrors
from model_lab.fitting.fit import Likelihood, fit
from model_lab.fitting.held_out import _refitted, hold_out
from model_lab.fitting.noise_floor import make_spectrum, noise_floor
from model_lab.fitting.scales import Scales


def problem_of(data, forward=None):
    forward = forward or toy_forward(data)
    design = np.stack([forward.x ** (k + 1) for k in range(len(forward.parameters))], axis=1)
    ordinary = np.linalg.lstsq(design, forward.measured, rcond=None)[0]
    spectrum = make_spectrum(data.table, design @ ordinary)
    floor = noise_floor(data, spectrum, forward.measured - design @ ordinary)
    return Likelihood(forward, spectrum, floor.variance), floor


def test_intervals_hold_the_truth_as_often_as_stated_though_whole_runs_scatter():
    inside = np.zeros(2)
    for seed in range(60):
        likelihood, _ = problem_of(toy_set(np.random.default_rng(seed), gain=0.03, noise=0.01))
        found = fit(likelihood, np.array([[0.5, 0.1]]))
        spread = np.sqrt(np.diag(found.covariance))
        inside += np.abs(found.values - [2.0, 0.5]) < 2.2 * spread
    assert np.all(inside >= 52)  # 57 expected; ordinary least squares gives about 25


@pytest.mark.parametrize("apart", [False, True])
def test_intervals_hold_the_truth_though_predictions_have_an_error_that_repeats_share(apart):
    inside, without = np.zeros(2), np.zeros(2)
    for seed in range(60):
        random = np.random.default_rng(seed)
        data = toy_set(random, gain=0.0, noise=0.01)
        table, x = data.table, toy_forward(data).x
        course = 0.1 * np.sin(3.0 * x)
        each = random.standard_normal(1 + table.group.max())
        drawn = each[table.group] if apart else each[0]
        forward = ToyForward(x, data.table.value + drawn * course)
        likelihood, _ = problem_of(data, forward)
        rows = course[None]
        own = OwnErrors(np.zeros((0, len(x))), rows) if apart else OwnErrors(rows)
        found = fit(replace(likelihood, own=own), np.array([[0.5, 0.1]]))
        plain = fit(likelihood, np.array([[0.5, 0.1]]))
        assert found.values == pytest.approx(plain.values)
        off = np.abs(found.values - [2.0, 0.5])
        inside += off < 2.2 * np.sqrt(np.diag(found.covariance + found.own_covariance))
        without += off < 2.2 * np.sqrt(np.diag(plain.covariance))
    assert np.all(inside >= 52) and np.all(without < 45)


def test_a_fit_ignores_noise_of_white_samples_within_a_gain_error():
    likelihood, _ = problem_of(toy_set(np.random.default_rng(1), gain=0.0, noise=0.05))
    found = fit(likelihood, np.array([[0.1, 3.0]]))
    assert found.values == pytest.approx([2.0, 0.5], abs=0.05)
    assert found.rmse == pytest.approx(0.05, rel=0.05)


def test_a_bound_holds_and_is_reported():
    data = toy_set(np.random.default_rng(2), gain=0.0)
    plain = toy_forward(data)
    tight = (ToyParameter("a", high=1.5), ToyParameter("b"))
    likelihood, _ = problem_of(data, ToyForward(plain.x, plain.measured, tight))
    found = fit(likelihood, np.array([[0.5, 0.1]]))
    assert found.values[0] == pytest.approx(1.5, abs=1e-3)  # AT_LIMIT
    assert found.at_limit.tolist() == [True, False]


def test_where_the_model_has_no_result_the_search_ends_and_asks_for_numbers_alone():
    data = toy_set(np.random.default_rng(2), gain=0.0)

    class Folding(ToyForward):
        def predict(self, values):
            assert np.isfinite(values).all()
            return np.where(values[:, :1] > 4.0, np.nan, super().predict(values))

    plain = toy_forward(data)
    likelihood, _ = problem_of(data, Folding(plain.x, plain.measured))
    found = fit(likelihood, np.array([[0.5, 0.1], [4.5, 0.1]]))
    assert found.values == pytest.approx([2.0, 0.5], abs=0.05)
    lost = fit(likelihood, np.array([[4.5, 0.1]]))
    assert not np.isfinite(lost.rmse)


def test_held_out_predictions_equal_refits_for_a_linear_model():
    data = toy_set(np.random.default_rng(3))
    likelihood, _ = problem_of(data)
    found = fit(likelihood, np.array([[0.5, 0.1]]))
    design = np.stack([likelihood.forward.x, likelihood.forward.x**2], axis=1)
    fold_of = likelihood.spectrum.table.fold
    held = hold_out(found)
    for fold in range(6):
        kept = fold_of != fold
        refit = np.linalg.lstsq(design[kept], likelihood.forward.measured[kept], rcond=None)[0]
        left = likelihood.forward.measured - design @ refit
        assert held.residual[~kept] == pytest.approx(left[~kept], abs=1e-6)


def test_a_fold_is_not_predicted_by_parameters_at_which_the_model_has_no_result():
    data = toy_set(np.random.default_rng(3))
    plain = toy_forward(data)
    best = fit(problem_of(data)[0], np.array([[0.5, 0.1]])).values[0]

    class Folding(ToyForward):
        def predict(self, values):
            return np.where(values[:, :1] > best + 0.017, np.nan, super().predict(values))

    likelihood, _ = problem_of(data, Folding(plain.x, plain.measured))
    found = fit(likelihood, np.array([[0.5, 0.1]]))
    held = hold_out(found)
    assert np.isfinite(held.residual).all() and np.isfinite(held.mean_square).all()
    fold_of = likelihood.spectrum.table.fold
    as_of_all = [
        held.residual[fold_of == fold] == pytest.approx(found.residual[fold_of == fold])
        for fold in range(6)
    ]
    assert any(as_of_all) and not all(as_of_all)


class Saturating(ToyForward):
    """y = 1 - exp(-a*x), of which one step from the fit of all does not reach the fit of half."""

    def predict(self, values):
        return 1.0 - np.exp(-values * self.x)


def test_parameters_are_fitted_anew_to_the_folds_that_are_kept():
    data = toy_set(np.random.default_rng(6), runs=4, samples=40)
    x, fold_of = toy_forward(data).x, data.table.fold
    measured = 1.0 - np.exp(-np.where(fold_of == 0, 0.4, 6.0) * x)
    likelihood, _ = problem_of(data, Saturating(x, measured, (ToyParameter("a"),)))
    found = fit(likelihood, np.array([[1.0]]))
    for fold, rate in enumerate((0.4, 6.0)):
        residual = _refitted(found, fold_of == fold)
        assert residual == pytest.approx(measured - 1.0 + np.exp(-rate * x), abs=1e-4)
    assert hold_out(found, anew=True).rmse <= hold_out(found).rmse


def test_noise_floor_has_its_two_parts():
    likelihood, floor = problem_of(
        toy_set(np.random.default_rng(4), runs=60, gain=0.03, noise=0.02)
    )
    size = np.sqrt(np.mean(likelihood.forward.measured**2))
    assert floor.source == "repeats"
    assert floor.within == pytest.approx(0.02, rel=0.1)
    assert floor.between == pytest.approx(0.03 * size, rel=0.25)
    assert floor.total == pytest.approx(np.hypot(0.02, 0.03 * size), rel=0.25)


def test_noise_floor_does_not_see_what_repeats_share():
    data = toy_set(np.random.default_rng(5), gain=0.0, noise=0.02)
    forward = toy_forward(data)
    spectrum = make_spectrum(data.table, 1.5 * forward.x)
    wrong = forward.measured - 1.5 * forward.x
    assert noise_floor(data, spectrum, wrong).total == pytest.approx(0.02, rel=0.1)


def test_without_repeats_the_floor_is_what_a_smoothing_spline_leaves():
    data = toy_set(np.random.default_rng(6), gain=0.0, noise=0.02, repeats=1)
    forward = toy_forward(data)
    spectrum = make_spectrum(data.table, 1.5 * forward.x)
    floor = noise_floor(data, spectrum, forward.measured - 1.5 * forward.x)
    assert floor.source == "spline"
    assert floor.total == pytest.approx(0.02, rel=0.15)


def test_the_spectrum_keeps_squares_and_turns_a_gain_error_into_one_coefficient():
    data = toy_set(np.random.default_rng(7))
    forward = toy_forward(data)
    spectrum = make_spectrum(data.table, forward.measured)
    random = np.random.default_rng(0).standard_normal((2, len(forward.x)))
    assert np.sum(spectrum.coefficients(random) ** 2) == pytest.approx(np.sum(random**2))
    gained = spectrum.coefficients(forward.measured[None])[0]
    assert np.count_nonzero(np.abs(gained) > 1e-9) == len(data.runs)


def test_logarithmic_coordinates_turn_back_into_values():
    scales = Scales.of([ToyParameter("a"), ToyParameter("t", 1e-3, 1e3, 1.0, (0.1, 10.0), True)])
    values = np.array([0.3, 20.0])
    assert scales.outward(scales.inward(values)) == pytest.approx(values)
