"""Several models beside one set: which is best, and how far it is above the noise."""

import pytest
from tensile_set import tensile_set

from model_lab.comparison.ladder import compare_models
from model_lab.report.comparison_text import ladder_json, ladder_text
from softhand_model.effects import effect_classes
from softhand_model.model_file import Model


def _gent(jm):
    return Model(effects=(effect_classes()["gent_stiffening"](jm=jm),))


def _stiffened(stretch, _):
    """What Gent's factor 1/(1 - J1/jm) adds at jm = 12."""
    invariant = stretch**2 + 2.0 / stretch - 3.0
    return 50e3 * (stretch - stretch**-2) * (1.0 / (1.0 - invariant / 12.0) - 1.0)


@pytest.fixture
def ladder():
    models = {"base": Model(), "near": _gent(20.0), "right": _gent(12.0)}
    return compare_models(tensile_set(error=_stiffened), models)


def test_the_right_model_reaches_the_noise_floor(ladder):
    errors = [rung.errors.held_out.rmse for rung in ladder.rungs]
    assert errors[0] > errors[1] > errors[2]
    assert ladder.best.name == "right"
    assert errors[2] == pytest.approx(200.0, rel=0.1)
    assert ladder.floor.total == pytest.approx(200.0, rel=0.1)


def test_the_text_has_a_rung_for_each_model_in_their_order(ladder):
    lines = ladder_text(ladder).splitlines()
    assert [line.split()[0] for line in lines[3:]] == ["base", "near", "right", "noise"]
    bars = [line.count("#") for line in lines[3:]]
    assert bars[0] == 40
    assert bars == sorted(bars, reverse=True)


def test_the_json_has_si_units(ladder):
    content = ladder_json(ladder)
    assert content["best"] == "right"
    assert [entry["model"] for entry in content["models"]] == ["base", "near", "right"]
    assert content["models"][2]["effects"] == ["gent_stiffening"]
    assert content["models"][2]["rmse_heldout"] == pytest.approx(200.0, rel=0.1)
    assert content["unit"] == "Pa"


def test_a_model_that_does_not_fit_the_set_is_named():
    with pytest.raises(ValueError, match="model weird: base: expected one of"):
        compare_models(tensile_set(), {"base": Model(), "weird": Model("cubic")})
