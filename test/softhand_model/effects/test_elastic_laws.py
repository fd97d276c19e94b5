"""Laws of rubber against the derivatives of their energies, in every mode."""

import numpy as np
import pytest
from scipy.optimize import brentq

from softhand_model.effects import effect_classes
from softhand_model.effects.stages import Strain

EFFECTS = effect_classes()
PRINCIPAL = {
    "uniaxial": lambda lam: (lam, lam**-0.5, lam**-0.5),
    "pure_shear": lambda lam: (lam, 1.0, 1.0 / lam),
    "equibiaxial": lambda lam: (lam, lam, lam**-2.0),
}
PULLED = {"uniaxial": 1, "pure_shear": 1, "equibiaxial": 2}  # directions that do work
SLOPES = {"uniaxial": 3.0, "pure_shear": 4.0, "equibiaxial": 6.0}
STRETCHES = (0.7, 0.95, 1.2, 1.7, 2.4)


def invariants(stretches):
    squares = np.square(stretches)
    return np.sum(squares) - 3.0, np.sum(1.0 / squares) - 3.0


def inverse_langevin(x):
    return brentq(lambda b: 1.0 / np.tanh(b) - 1.0 / b - x, 1e-6, 1e4, xtol=1e-13)


def eight_chains(j1, links):
    """Arruda and Boyce with the exact inverse Langevin function, over the modulus at no strain."""
    share, rest = np.sqrt((j1 + 3.0) / (3.0 * links)), np.sqrt(1.0 / links)
    b = inverse_langevin(share)
    modulus = inverse_langevin(rest) / rest / 3.0
    return links * (share * b + np.log(b / np.sinh(b))) / modulus


ENERGIES = {  # over the shear modulus, of J1, J2 and the principal stretches
    ("gent_stiffening", 30.0): lambda p, j1, j2, lam: -p / 2 * np.log(1 - j1 / p),
    ("yeoh_stiffening", 0.05): lambda p, j1, j2, lam: (j1 + p * j1**2) / 2,
    ("yeoh_third_order", 0.01): lambda p, j1, j2, lam: (j1 + p * j1**3) / 2,
    ("mooney_rivlin", 0.4): lambda p, j1, j2, lam: (j1 + p * j2) / (2 + 2 * p),
    ("second_invariant", 0.5): lambda p, j1, j2, lam: (
        (j1 / 2 + p * np.sum(np.square(np.log(lam)))) / (1 + p)
    ),
    ("ogden", 3.3): lambda p, j1, j2, lam: 2 / p**2 * np.sum(np.power(lam, p)),
    ("ogden", 1.4): lambda p, j1, j2, lam: 2 / p**2 * np.sum(np.power(lam, p)),
    ("arruda_boyce", 8.0): lambda p, j1, j2, lam: eight_chains(j1, p),
}


def law(name, value):
    return EFFECTS[name](**{EFFECTS[name].parameters[0].name: value})


def stress_of(effects, stretch, mode):
    """Stress over G at stretches under factors that act one after the other."""
    strain = Strain(np.asarray(stretch, float), mode)
    stress = strain.elastic_term
    for effect in effects:
        stress = effect.stress(stress, strain, None, {}, 0.0)
    return stress


@pytest.mark.parametrize("mode", PRINCIPAL)
@pytest.mark.parametrize(("name", "value"), ENERGIES)
def test_stress_is_the_derivative_of_the_energy(name, value, mode):
    energy = ENERGIES[name, value]

    def of(stretch):
        principal = PRINCIPAL[mode](stretch)
        return energy(value, *invariants(principal), principal)

    slopes = [(of(lam + 1e-4) - of(lam - 1e-4)) / 2e-4 / PULLED[mode] for lam in STRETCHES]
    tolerance = 3e-3 if name == "arruda_boyce" else 1e-6
    found = stress_of([law(name, value)], STRETCHES, mode)
    assert found == pytest.approx(slopes, rel=tolerance, abs=1e-7)


@pytest.mark.parametrize("mode", PRINCIPAL)
@pytest.mark.parametrize(("name", "value"), ENERGIES)
def test_the_shear_modulus_is_that_of_no_strain(name, value, mode):
    near = stress_of([law(name, value)], [1.0 - 1e-5, 1.0, 1.0 + 1e-5], mode)
    assert near[1] == pytest.approx(0.0, abs=1e-12)
    assert (near[2] - near[0]) / 2e-5 == pytest.approx(SLOPES[mode], rel=1e-6)


@pytest.mark.parametrize("mode", PRINCIPAL)
def test_invariants_are_those_of_the_principal_stretches(mode):
    for stretch in STRETCHES:
        strain = Strain(stretch, mode)
        expected = invariants(PRINCIPAL[mode](stretch))
        assert (strain.invariant, strain.second_invariant) == pytest.approx(expected)


def test_both_terms_of_yeoh_add_up_in_any_order():
    from softhand_model.effects.pipeline import in_order

    third, second = law("yeoh_third_order", 0.01), law("yeoh_stiffening", 0.05)
    strain = Strain(np.array(STRETCHES), "uniaxial")
    factor = 1.0 + 0.1 * strain.invariant + 0.03 * strain.invariant**2
    for both in ([third, second], [second, third]):
        found = stress_of(in_order(both), STRETCHES, "uniaxial")
        assert found == pytest.approx(strain.elastic_term * factor)


def test_ogden_of_exponent_two_is_the_base_and_chains_without_end_too():
    for mode in PRINCIPAL:
        base = Strain(np.array(STRETCHES), mode).elastic_term
        assert stress_of([law("ogden", 2.0)], STRETCHES, mode) == pytest.approx(base)
        long = stress_of([law("arruda_boyce", 1000.0)], STRETCHES, mode)
        assert long == pytest.approx(base, rel=0.02)


def test_chains_lock_without_a_pole():
    locked = stress_of([law("arruda_boyce", 2.0)], np.linspace(1.0, 4.0, 400), "pure_shear")
    assert np.isfinite(locked).all() and np.all(np.diff(locked) > 0.0)


@pytest.mark.parametrize("name", ["arruda_boyce", "ogden", "second_invariant", "yeoh_third_order"])
@pytest.mark.parametrize("end", ["low", "high"])
def test_the_elastic_side_grows_within_the_bounds_in_bending(name, end):
    effect = law(name, getattr(EFFECTS[name].parameters[0], end))
    grown = stress_of([effect], np.linspace(1.0, 4.0, 61), "pure_shear")
    assert np.all(np.diff(grown) > 0.0)
