"""Designed actuators do what was wanted, by the exact model of bending; broken rules are said."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from softhand_design.hand_file import finger_text
from softhand_design.requirements import of_numbers
from softhand_design.sizing import design_actuator
from softhand_model.hand.actuator import load_actuator
from softhand_model.hand.hand import load_hand
from softhand_model.hand.rubber import Rubber, load_rubbers

DRAGON_SKIN = Rubber("Dragon Skin 10", "Smooth-On", "", 11.0, 67e3, 1070.0)
FINGER = {
    "actuation_ratio": 0.93e-3,
    "stiffness": 3.9e-3,
    "length": 0.09,
    "rubber": DRAGON_SKIN,
}
# lambda + lambda**-3 = 2 is lambda**3 = lambda**2 + lambda + 1 beside lambda = 1
RULE_STRETCH = max(np.roots([1, -1, -1, -1]).real)


def designed(**change):
    return design_actuator(of_numbers(**FINGER | change))


def exact_secant(actuator):
    """kappa/p [1/(m Pa)] at the base by the exact model, where the top is stretched to 1.839."""
    low, high = 1.0, 1e7
    for _ in range(200):
        pressure = np.sqrt(low * high)
        curvature = float(actuator.free_curvature(pressure, 0.0))
        too_far = curvature * float(actuator.height(0.0)) > RULE_STRETCH - 1.0
        low, high = (low, pressure) if too_far else (pressure, high)
    return curvature / pressure


@pytest.mark.parametrize(
    ("ratio", "stiffness", "rubber"),
    product(
        (0.5e-3, 0.9e-3, 2e-3),
        (1e-3, 4e-3, 2e-2),
        (DRAGON_SKIN, *(load_rubbers()[f"Dragon Skin {n}"] for n in (20, 30))),
    ),
    ids=str,
)
def test_a_designed_actuator_has_the_wanted_ratio_and_stiffness(tmp_path, ratio, stiffness, rubber):
    design = design_actuator(of_numbers(ratio, stiffness, 0.12, rubber))
    path = tmp_path / "finger.yaml"
    path.write_text(finger_text(design.actuator), encoding="utf-8")
    finger = load_hand(path).chain("finger").actuators["finger"]
    assert finger == design.actuator
    assert exact_secant(finger) == pytest.approx(ratio, rel=1e-5)
    assert float(finger.stiffness(0.0)) == pytest.approx(stiffness, rel=1e-5)
    assert float(finger.height(0.0)) == float(finger.width(0.0))


def test_requirements_of_the_finger_of_rbo_hand_2_gives_its_sizes():
    model = load_actuator("P10.finger")
    ratio, stiffness = float(model.actuation_ratio(0.0)), float(model.stiffness(0.0))
    found = designed(actuation_ratio=ratio, stiffness=stiffness).actuator
    x = np.linspace(0.0, 0.09, 7)
    assert found.wall(x) == pytest.approx(0.002, rel=1e-5)
    for key in ("height", "width", "circumference"):
        np.testing.assert_allclose(getattr(found, key)(x), getattr(model, key)(x), rtol=1e-5)
    assert found.max_pressure == pytest.approx(model.max_pressure, rel=0.05)


def test_the_stiffness_falls_in_a_straight_line_to_that_of_the_tip():
    finger = designed(tip_stiffness=1.3e-3).actuator
    x = np.linspace(0.0, 0.09, 5)
    by_rule = finger.stiffness(x) * finger.side_wall_ratio(x) / finger.side_wall_ratio(0.0)
    np.testing.assert_allclose(by_rule, np.linspace(3.9e-3, 1.3e-3, 5), rtol=1e-5)


def test_a_finger_that_is_as_stiff_at_its_tip_does_not_taper():
    finger = designed(tip_stiffness=3.9e-3).actuator
    assert float(finger.height(0.09)) == float(finger.height(0.0))
    assert finger.stiffness(np.array([0.0, 0.09])) == pytest.approx(3.9e-3, rel=1e-5)


@pytest.mark.parametrize("fixed", [{"height": 0.022}, {"width": 0.018}, {"wall": 0.003}])
def test_one_size_that_a_mould_fixes_leaves_the_stiffness(fixed):
    finger = designed(**fixed).actuator
    assert float(finger.stiffness(0.0)) == pytest.approx(3.9e-3, rel=1e-5)
    if "wall" not in fixed:
        assert float(finger.actuation_ratio(0.0)) == pytest.approx(0.93e-3, rel=1e-5)


def test_at_the_pressure_limit_the_top_is_stretched_to_a_third_of_what_it_bears():
    finger = designed().actuator
    x = finger.quadrature()[0]
    stretch = 1.0 + finger.height(x) * finger.free_curvature(finger.max_pressure, x)
    assert stretch.max() == pytest.approx(0.3 * 11.0, rel=1e-6)


def test_an_actuator_by_the_rules_breaks_none():
    assert designed().broken == ()


TANGO = load_rubbers()["TangoBlack+ FLX980 soft"]


@pytest.mark.parametrize(
    ("change", "rule", "words"),
    [
        ({"wall": 0.003}, 1, "actuation ratio expected at least 0.000837 and at most 0.001023"),
        ({"height": 0.025, "width": 0.025}, 2, "stiffness expected at least 0.00351 and"),
        ({"height": 0.022}, 3, "height over width expected at least 0.9 and at most 1.111, got"),
        ({"stiffness": 1e-4}, 4, "wall over height expected at most 0.5, got"),
        (
            {"rubber": TANGO, "actuation_ratio": 0.3e-3},
            5,
            "index of TangoBlack+ FLX980 soft expected at least 19.94 kPa^0.25, got 8.568",
        ),
    ],
)
def test_each_rule_that_is_broken_is_said_alone(change, rule, words):
    (broken,) = designed(**change).broken
    assert broken.rule == rule
    assert str(broken).startswith(f"rule {rule}: ")
    assert words in str(broken)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"actuation_ratio": 0.1e-3}, "actuation_ratio: expected above 0.0003025 1/(m Pa), at whi"),
        ({"stiffness": 1e-7}, "actuation_ratio: expected above"),
        ({"wall": 0.05}, "wall: expected below 0.007349"),
        ({"height": 0.001}, "height: expected above 0.001 m, for a chamber, got 0.001 m"),
        ({"height": 0.045}, "height: expected below 0.03871 m for this stiffness, got 0.045 m"),
        ({"width": 0.06, "wall": 0.002}, "width: expected below"),
        ({"length": 0.01}, "length: expected above 0.01936 m, the height that"),
        ({"tip_stiffness": 5e-3}, "tip_stiffness: expected 0 to the stiffness at the base, 0.0039"),
        ({"stiffness": -1.0}, "stiffness: expected a number above 0 N m2, got -1 N m2"),
        ({"length": float("nan")}, "length: expected a number above 0 m, got nan m"),
        (
            {"rubber": Rubber("putty", "", "", 1.8, 67e3, 1070.0)},
            "max_stretch: expected above 2 of putty, got 1.8",
        ),
    ],
)
def test_what_cannot_be_had_is_refused(change, words):
    with pytest.raises(ValueError) as caught:
        designed(**change)
    assert words in str(caught.value)


def test_just_above_the_least_actuation_ratio_the_chamber_is_a_millimetre_high():
    with pytest.raises(ValueError, match="actuation_ratio: expected above 0.0003025"):
        designed(actuation_ratio=0.3024e-3)
    base = designed(actuation_ratio=0.3025e-3).actuator
    assert float(base.height(0.0) - base.wall(0.0)) == pytest.approx(1e-3, rel=0.02)


def test_the_rubber_weighs_what_its_density_says():
    heavy = designed(rubber=replace(DRAGON_SKIN, density=1300.0)).actuator
    assert heavy.mass == pytest.approx(1300.0 * heavy.rubber_volume(), rel=1e-6)
