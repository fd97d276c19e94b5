"""Table 3.2, and the strain in pure shear."""

import pytest

from softhand_model.hand import rubber
from softhand_model.hand.rubber import load_rubbers


@pytest.mark.parametrize(
    ("name", "index"),
    [
        ("Dragon Skin 10", 26.6),
        ("Dragon Skin 20", 20.2),
        ("Dragon Skin 30", 13.5),
        ("Ecoflex 00-30", 19.7),
        ("Ecoflex 00-50", 22.5),
        ("Elastosil M4125", 23.5),
        ("TangoBlack+ FLX980 stiff", 8.0),
        ("TangoBlack+ FLX980 soft", 8.6),
    ],
)
def test_suitability_of_table_3_2(name, index):
    assert load_rubbers()[name].suitability == pytest.approx(index, abs=0.06)


def test_elastosil_as_printed_would_be_less_suitable():
    assert rubber.suitability(6.0, 333e3) == pytest.approx(21.4, abs=0.05)


def test_elastosil_makes_an_actuator_45_percent_slimmer():
    """Same stiffness and curvature: h ~ lambda_max - 1 at equal kappa_max (eq. 3.5)."""
    table = load_rubbers()
    dragon, elastosil = table["Dragon Skin 10"], table["Elastosil M4125"]
    slimmer = 1 - (elastosil.max_stretch - 1) / (dragon.max_stretch - 1)
    assert slimmer == pytest.approx(0.45)


def test_both_suitability_indices_agree_for_a_linear_rubber():
    stretch, modulus = 5.0, 80e3
    strength = modulus * (stretch - 1)
    assert rubber.suitability_by_tear_strength(stretch, strength) == pytest.approx(
        rubber.suitability(stretch, modulus)
    )


def test_strain_invariant_at_three():
    assert rubber.strain_invariant(3.0) == pytest.approx(7.111, abs=5e-4)
    assert rubber.strain_invariant(1.0) == 0.0
