"""Model files: what they hold, and what is said about broken ones."""

import pytest

from softhand_model.effects.effect import Effect
from softhand_model.hand.joint_stiffness import SpringModel
from softhand_model.model_file import Model, load_model, model_names

HEADER = "format: softhand-model/1\nbase: pneuflex\n"


def written(tmp_path, text):
    path = tmp_path / "model.yaml"
    path.write_text(HEADER + text, encoding="utf-8")
    return path


def test_shipped_models():
    assert model_names() == ["base", "gravity", "linear", "rbo_hand_1"]
    assert load_model("linear").base == "linear"
    assert load_model("base").effects == ()
    assert load_model().gravity_scale == 1.0


def test_without_gravity_actuators_have_no_weight():
    assert load_model("base").gravity_scale == 0.0
    assert Model().gravity_scale == 0.0


def test_gravity_takes_its_scale_from_the_file(tmp_path):
    path = written(tmp_path, "effects: [{name: gravity, parameters: {mass_scale: 1.2}}]\n")
    assert load_model(path).gravity_scale == 1.2


@pytest.mark.parametrize(
    ("text", "scale"),
    [
        ("", 1.0),
        ("calibration: {modulus_scale: 1.1}\n", 1.1),
        ("calibration: {modulus_scale: {A: 1.03}}\n", 1.03),
    ],
)
def test_modulus_scale_without_a_batch(tmp_path, text, scale):
    assert load_model(written(tmp_path, text)).modulus_scale() == scale


def test_modulus_scale_of_several_batches_needs_one_named(tmp_path):
    model = load_model(written(tmp_path, "calibration: {modulus_scale: {A: 1.03, B: 0.95}}\n"))
    assert model.modulus_scale("B") == 0.95
    for batch in (None, "C"):
        with pytest.raises(ValueError, match=f"expected one of the batches A, B, got {batch}"):
            model.modulus_scale(batch)


def test_linear_base_loads_with_its_coefficients(tmp_path):
    path = tmp_path / "model.yaml"
    text = "format: softhand-model/1\nbase: linear\ncalibration: {coefficient: {s1: 2.0e-5}}\n"
    path.write_text(text, encoding="utf-8")
    model = load_model(path)
    assert model.base == "linear"
    assert model.calibration["coefficient"] == {"s1": 2e-5}


def test_standard_errors_are_kept(tmp_path):
    text = "effects: [{name: gravity, parameters: {mass_scale: 1.0}, std: {mass_scale: 0.1}}]\n"
    assert load_model(written(tmp_path, text)).std == {"gravity": {"mass_scale": 0.1}}


def test_springs_are_those_of_the_thesis_unless_the_file_says_otherwise(tmp_path):
    assert load_model().springs == SpringModel("rule", 1.0, 1.0)
    text = "springs: {bending: curvature, twist: section}\n"
    assert load_model(written(tmp_path, text)).springs == SpringModel("curvature", 1.0, "section")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("effects: [{name: levity}]\n", "got 'levity'"),
        (
            "effects: [{name: gravity}]\n",
            "effects[0]: effect gravity: parameters: expected mass_sc",
        ),
        (
            "effects: [{name: gravity, parameters: {mass_scale: -1}}]\n",
            "mass_scale: expected a number from 0 to 10, got -1",
        ),
        (
            "effects: [{name: gravity, parameters: {mass: 1}}]\n",
            "parameters: expected only mass_scale, got mass",
        ),
        (
            "effects: [{name: gravity, parameters: {mass_scale: 1}},"
            " {name: gravity, parameters: {mass_scale: 1}}]\n",
            "effects[1].name: expected every effect once, got 'gravity'",
        ),
        ("effects: {}\n", "effects: expected a list, got {}"),
        (
            "calibration: {modulus_scale: 0}\n",
            "calibration.modulus_scale: expected a number at lea",
        ),
        ("calibration: {modulus_scale: {}}\n", "modulus_scale: expected at least one entry"),
        ("surprise: 1\n", "got surprise"),
        ("springs: {bending: soft}\n", "springs.bending: expected one of rule, curvature, got"),
        ("springs: {twist: none}\n", "springs.twist: expected a number above 0 or section, got"),
        ("springs: {lateral: 0}\n", "springs.lateral: expected"),
        ("springs: {length: 1}\n", "got length"),
        ("effects: [{name: a, file: none.py}]\n", "none.py: expected a Python file with an effect"),
        (
            "effects: [{name: a, file: ../a.py}]\n",
            "effects[0].file: expected a file in the model file's folder, got '../a.py'",
        ),
    ],
)
def test_broken_model_is_named(tmp_path, text, message):
    path = written(tmp_path, text)
    with pytest.raises(ValueError) as caught:
        load_model(path, allow_effect_files=True)
    assert str(tmp_path) in str(caught.value)
    assert message in str(caught.value)


def test_unknown_base_and_name_are_answered_with_lists(tmp_path):
    path = tmp_path / "model.yaml"
    path.write_text("format: softhand-model/1\nbase: cubic\n", encoding="utf-8")
    with pytest.raises(ValueError, match="base: expected one of pneuflex, linear, got 'cubic'"):
        load_model(path)
    with pytest.raises(
        ValueError, match="expected one of base, gravity, linear, rbo_hand_1 or the path"
    ):
        load_model("everything")


def test_effects_run_in_the_order_of_the_stages():
    class Late(Effect):
        name, stage = "late", "output"

    class Early(Effect):
        name, stage = "early", "input"

    assert [effect.name for effect in Model(effects=(Late(), Early())).effects] == ["early", "late"]
