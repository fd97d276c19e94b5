"""The example of an effect with memory: closed form, with its kernel and without, and the lab."""

import json
import shutil
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from model_lab.bench.synthesize import EMPTY
from model_lab.cli.main import main
from model_lab.experiments.forward import Forward
from softhand_model.chain.chain import discretise
from softhand_model.effects import effects_in_file
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model

EXAMPLE = Path(__file__).parents[2] / "examples" / "effect_with_memory.py"
FRICTION = effects_in_file(EXAMPLE)["filler_friction"]
FINGER = load_hand("single_finger").chain("finger")
MODEL = """
format: softhand-model/1
base: pneuflex
effects:
  - name: filler_friction
    file: effect_with_memory.py
    parameters: {relative_pressure: 0.2, slip_stretch: 0.1}
"""
AMOUNT, SLIP = 0.2, 0.1
COARSE = AMOUNT / (4.0 * 10**2)  # largest error of so few sliders in place of very many


def without_kernel(effect):
    """The same effect in Python alone."""
    return type(effect.__name__, (effect,), {"kernel": None})


def from_rest(stretch):
    """Stress [-] of very many sliders that were at rest before they were stretched by so much."""
    u = np.minimum(np.abs(stretch) / SLIP, 1.0)
    return AMOUNT * np.sign(stretch) * u * (2.0 - u)


def pulled(stretch):
    """A measurement set of one run of a strip of rubber whose stretch is imposed."""
    data = EMPTY["uniaxial"](np.random.default_rng(0))
    columns = {"time": 0.01 * np.arange(len(stretch)), "stretch": stretch, "stress": 0.0 * stretch}
    return replace(data, runs=(replace(data.runs[0], columns=columns),))


@pytest.mark.parametrize("effect", [FRICTION, without_kernel(FRICTION)])
def test_a_small_loop_within_a_large_one_has_its_closed_form(effect):
    """Up to 1.15, down to 1.07, up to 1.12, and down again: where it turns, the curve starts anew,
    twice as large; past the small loop it goes on as if there had been none.
    """
    turns = np.array([1.0, 1.15, 1.07, 1.12, 1.0])
    stretch = np.concatenate([np.linspace(*ends, 50) for ends in pairwise(turns)])
    forward = Forward(pulled(stretch), effects=[effect])
    with_friction, base = forward.predict(np.array([[1.0, AMOUNT, SLIP], [1.0, 0.0, SLIP]]))
    friction = (with_friction - base) / 67e3  # the strip's shear modulus

    up, down, again, last = np.split(np.arange(200), 4)
    expected = np.empty(200)
    expected[up] = from_rest(stretch[up] - 1.0)
    expected[down] = expected[up[-1]] + 2.0 * from_rest((stretch[down] - 1.15) / 2.0)
    expected[again] = expected[down[-1]] + 2.0 * from_rest((stretch[again] - 1.07) / 2.0)
    inside = stretch[last] >= 1.07
    small = expected[again[-1]] + 2.0 * from_rest((stretch[last] - 1.12) / 2.0)
    large = expected[up[-1]] + 2.0 * from_rest((stretch[last] - 1.15) / 2.0)
    expected[last] = np.where(inside, small, large)
    assert np.abs(friction - expected).max() < 5.0 * COARSE  # from turn to turn errors add up
    assert np.ptp(friction) > 0.3


def test_the_finger_bends_alike_with_the_kernel_and_without():
    data = EMPTY["free_bending"](np.random.default_rng(0))
    found = [
        Forward(data, effects=[effect]).predict(np.array([[1.0, 0.3, 0.05], [0.9, 0.1, 0.2]]))
        for effect in (FRICTION, without_kernel(FRICTION))
    ]
    np.testing.assert_allclose(*found, atol=2e-6)  # [rad]


def test_a_simulated_finger_is_bent_more_on_its_way_back(tmp_path):
    path = tmp_path / "model.yaml"
    path.write_text(MODEL, encoding="utf-8")
    shutil.copy(EXAMPLE, tmp_path)
    chain = discretise(FINGER, 5, load_model(path, allow_effect_files=True))
    pressures = np.concatenate([np.linspace(0.0, 40e3, 41), np.linspace(39e3, 0.0, 40)])
    angle = [chain.step(1e-2, [p], np.zeros((5, 3)))[:, 1].sum() for p in pressures]
    assert angle[60] > angle[20] + 0.1  # [rad], both at 20 kPa


def test_the_lab_finds_the_parameters_in_a_set_and_predicts_it(tmp_path):
    own = ["--effects", str(EXAMPLE)]
    made, model = str(tmp_path / "set"), str(tmp_path / "model.yaml")
    hidden = ["synthesize", "free_bending", "--hide", "--noise", "0.002", "--seed", "2", *own]
    assert main([*hidden, "--out", made]) == 0
    assert main(["add", "filler_friction", "--data", made, *own, "--out", model]) == 0
    told = tmp_path / "told.json"
    assert main(["compare", made, "--model", model, *own, "--json", str(told)]) == 0
    compared = json.loads(told.read_text())
    assert compared["rmse_heldout"] < 1.2 * compared["noise_floor"]
    assert main(["reveal", made, "--json", str(told), "--force"]) == 0
    (truth,) = json.loads(told.read_text())["effects"]
    (added,) = load_model(model, allow_effect_files=True).effects
    assert added.values == pytest.approx(truth["parameters"], rel=0.1)
