"""Predicted success: the score on made-up rates, and a model file of a hand that changes trials."""

import numpy as np
import pytest

from bench.hands import prediction
from bench.hands.predicted_rates import draw, error_interval, prediction_error, sampling_error
from model_lab.comparison.add import write_model
from softhand_model.effects.hand_parts import Friction
from softhand_model.model_file import Model, load_model
from softhand_trials.trials import TrialSettings, run_trial

MADE_UP = np.random.default_rng(3).uniform(size=(10, 400)) < np.linspace(0.1, 0.9, 10)[:, None]


def test_the_error_is_that_of_rates_and_not_of_single_trials():
    assert prediction_error([[1, 0, 0, 1]], [[0, 1, 1, 0]]) == 0.0
    assert prediction_error([[1, 1], [0, 0]], [[0, 0], [0, 1]]) == pytest.approx(0.75)


def test_the_interval_of_the_error_shrinks_with_the_root_of_the_seeds():
    other = np.random.default_rng(4).permuted(MADE_UP, axis=1)
    shifted = other | (np.random.default_rng(5).uniform(size=other.shape) < 0.3)
    few, many = (
        np.ptp(error_interval(shifted[:, :seeds], MADE_UP[:, :seeds])) for seeds in (25, 400)
    )
    assert few / many == pytest.approx(4.0, rel=0.4)
    low, high = error_interval(shifted, MADE_UP)
    assert low < prediction_error(shifted, MADE_UP) < high


def test_the_standard_error_of_a_rate_is_that_of_the_binomial():
    rates = np.linspace(0.1, 0.9, 10)
    expected = np.sqrt(np.mean(rates * (1.0 - rates)) / 400)
    assert sampling_error(MADE_UP) == pytest.approx(expected, rel=0.05)


def test_a_model_file_of_a_hand_changes_its_trials(tmp_path):
    """Nearly without friction nothing is lifted by what lifts it otherwise."""
    oily = tmp_path / "oily.yaml"
    write_model(oily, Model(effects=(*load_model().effects, Friction(factor=0.05))))
    usual = TrialSettings(step=0.005, early_end=True, engine="mujoco", offset=0.0)
    slippery = TrialSettings(
        step=0.005, early_end=True, engine="mujoco", offset=0.0, model=str(oily)
    )
    assert run_trial(0, usual).result.gripped
    assert not run_trial(0, slippery).result.gripped


def made_up_results(folder, gripped):
    """Results of made-up trials, and the models; friction is not named."""
    models = {name: folder / name for name in (*prediction.CASES, prediction.WRONG_FINGER)}
    models |= {
        prediction.BASE: None,
        **{prediction.mended(case): None for case in prediction.CASES},
    }
    for case in ("finger soft", "palm stiff"):
        models[prediction.mended(case)] = folder / case
    for cell in prediction.planned(models, 0):
        count = 4
        row = [int(number < gripped(cell.model, cell.engine) * count) for number in range(count)]
        prediction.append({"key": cell.key, "gripped": row, "cpu": 1.0}, folder / "results.jsonl")
    return prediction.Results(folder, models)


def test_a_mended_model_that_is_right_meets_the_target_and_one_of_another_case_does_not(tmp_path):
    rate = {"base": 1.0, "friction 0.7": 0.5, "finger soft": 0.5, "palm stiff": 0.0}
    rate |= {prediction.WRONG_FINGER: 1.0}
    rate |= {"mended, finger soft": 0.5, "mended, palm stiff": 0.25}
    results = made_up_results(tmp_path, lambda model, engine: rate[model])
    assert results.named == ["finger soft", "palm stiff"]
    lines = list(prediction.report(results))
    soft, slippery, stiff = (
        next(line for line in lines if line.startswith(f"| {case} ")) for case in prediction.CASES
    )
    assert soft.startswith("| finger soft | 0.500 (") and "| 0.000 (" in soft
    assert soft.endswith(" 0.00, met |")
    assert "1.00, missed (not named)" in slippery
    assert "0.25, met" in stiff
    assert any(line.startswith("| mean | 0.667 | 0.250 |") for line in lines)
    assert any("help (below 0.8 of base): 3 of 4" in line for line in lines)


def test_the_picture_has_a_panel_for_each_case(tmp_path):
    rates = {"one": {"true": [0.1, 0.9], "base": [0.5, 0.5]}, "two": {"true": [1.0, 0.0]}}
    draw(rates, ["ball", "rod"], tmp_path / "rates.png")
    assert (tmp_path / "rates.png").stat().st_size > 5000
