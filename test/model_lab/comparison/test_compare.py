"""A comparison says how large an error is, of what it consists and where it lies."""

import json
import time

import numpy as np
import pytest
from tensile_set import tensile_set

from model_lab.comparison.compare import accuracy, compare
from model_lab.report.comparison_text import comparison_json, comparison_text
from softhand_common.documents.output_file import plain
from softhand_model.model_file import Model


def test_the_calibration_is_fitted_where_the_file_has_none():
    found = compare(tensile_set(scale=1.06), Model())
    assert found.errors.calibrated
    assert found.errors.calibration["modulus_scale"]["A"] == pytest.approx(1.06, abs=0.003)
    assert found.errors.as_is.rmse == pytest.approx(200.0, rel=0.1)
    assert found.errors.held_out.rmse == pytest.approx(200.0, rel=0.1)


def test_a_calibration_of_the_file_stays_as_it_is():
    found = compare(tensile_set(scale=1.06), Model(calibration={"modulus_scale": {"A": 1.0}}))
    assert not found.errors.calibrated
    stretch = np.concatenate([run.columns["stretch"] for run in found.data.runs])
    expected = np.sqrt(np.mean((0.06 * 50e3 * (stretch - stretch**-2)) ** 2) + 200.0**2)
    assert found.errors.as_is.rmse == pytest.approx(expected, rel=0.02)
    assert found.errors.held_out.rmse == pytest.approx(200.0, rel=0.1)


def test_the_noise_floor_is_that_of_the_repeats():
    found = compare(tensile_set(scatter=0.01, protocols=8, repeats=3), Model())
    stress = np.concatenate([run.columns["stress"] for run in found.data.runs])
    between = 0.01 * np.sqrt(np.mean(stress**2))
    floor = found.errors.floor
    assert floor.within == pytest.approx(200.0, rel=0.15)
    assert floor.between == pytest.approx(between, rel=0.5)
    assert floor.total == pytest.approx(np.hypot(200.0, between), rel=0.3)


def test_an_error_at_large_stretch_is_located():
    data = tensile_set(error=lambda stretch, _: 8e3 * np.maximum(stretch - 1.7, 0.0))
    found = compare(data, Model())
    assert found.errors.held_out.rmse > 2.0 * found.errors.floor.total
    assert "pressure" in [axis.against for axis in found.localisation.failures]
    text = comparison_text(found, "base")
    assert "pressure (stretch)" in text
    assert "times the noise floor" in text
    assert "`diagnose` also tests such mistakes together with effects" in text


def test_noise_is_said_to_be_noise():
    text = comparison_text(compare(tensile_set(), Model()), "base")
    assert "The held-out error lies within the noise floor." in text
    assert "nothing beyond chance" in text
    assert "tries them" not in text


def test_parts_add_up_to_the_whole():
    found = compare(tensile_set(specimens=("a", "b", "c")), Model())
    assert [part.name for part in found.specimens] == ["a", "b", "c"]
    assert [part.name for part in found.runs] == [run.name for run in found.data.runs]
    for parts in (found.runs, found.specimens, found.outputs):
        squares = sum(part.held_out.samples * part.held_out.rmse**2 for part in parts)
        assert squares == pytest.approx(
            found.errors.held_out.samples * found.errors.held_out.rmse**2
        )


def test_a_run_of_its_own_error_stands_out():
    data = tensile_set(error=lambda stretch, index: 2e3 * (index == 3) + 0.0 * stretch)
    found = compare(data, Model())
    worst = max(found.runs, key=lambda part: part.held_out.rmse)
    assert worst.name == "r3"
    assert worst.held_out.bias == pytest.approx(2e3, rel=0.2)


def test_the_json_holds_what_the_text_says():
    found = compare(tensile_set(), Model())
    content = json.loads(json.dumps(plain(comparison_json(found, "base")), allow_nan=False))
    assert content["format"] == "softhand-comparison/1"
    assert content["rmse_heldout"] == content["held_out"]["rmse"] == found.errors.held_out.rmse
    assert content["noise_floor"] == found.errors.floor.total
    assert content["unit"] == "Pa"
    assert [run["name"] for run in content["runs"]] == [f"r{index}" for index in range(8)]
    assert {axis["against"] for axis in content["axes"]} >= {"pressure", "run_order"}


def test_the_same_seed_gives_the_same_answer():
    first, again = (comparison_json(compare(tensile_set(), Model(), 3), "m") for _ in range(2))
    assert json.dumps(plain(first)) == json.dumps(plain(again))


def test_of_many_runs_the_worst_are_listed():
    data = tensile_set(
        protocols=15, samples=40, error=lambda stretch, i: 3e3 * (i == 17) + 0 * stretch
    )
    text = comparison_text(compare(data, Model()), "base")
    rows = text.split("worst runs")[1].splitlines()
    assert rows[1].split()[0] == "r17"
    assert len([row for row in rows[1:] if row.startswith("  r")]) == 12


def test_one_run_without_repeats_is_held_out_by_blocks():
    found = compare(tensile_set(protocols=1, repeats=1, samples=300), Model())
    assert found.errors.holdout == "blocks"
    assert "fitted to the other blocks of the runs" in comparison_text(found, "base")


def test_a_million_samples_take_seconds():
    data = tensile_set(protocols=6, repeats=6, samples=28_000)
    start = time.process_time()
    compare(data, Model())
    assert time.process_time() - start < 18.0  # four on an idle machine


def test_accuracy_is_what_it_is_defined_to_be():
    measured = np.array([1.0, 3.0, 10.0, 10.0])
    found = accuracy(measured, np.array([0.5, -0.5, 0.0, 1.0]), np.array([0, 0, 1, 1]))
    assert found.rmse == pytest.approx(np.sqrt(1.5 / 4.0))
    # about the means 2 and 10 of the two outputs
    assert found.fit == pytest.approx(100.0 * (1.0 - np.sqrt(1.5) / np.sqrt(2.0)))
    assert found.bias == 0.25
    assert found.largest == 1.0


def test_an_output_that_does_not_vary_has_no_fit():
    one = np.zeros(3, int)
    assert np.isnan(accuracy(np.ones(3), np.ones(3), one).fit)
