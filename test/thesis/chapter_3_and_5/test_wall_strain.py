"""Bounds of chapter 3, and strain through the wall against its equation."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from softhand_model.hand.rubber import strain_invariant
from thesis.chapter_3_and_5.wall_strain import (
    deformed_depth,
    gent_factor,
    mooney_rivlin_energy_error,
    mooney_rivlin_stiffness_error,
    wall_strain_invariant,
    wall_stretches,
)


def derivative(function, x, step=1e-4):
    return (function(x + step) - function(x - step)) / (2.0 * step)


def gent_energy(stretch, modulus, jm):
    """Energy per volume [J/m3] in pure shear (section 3.4.7, with its minus sign)."""
    return -0.5 * modulus * jm * np.log1p(-strain_invariant(stretch) / jm)


def test_gent_factor_is_the_gradient_ratio_of_the_energies():
    jm, modulus, stretch = 100.0, 67e3, 3.0
    gent = derivative(lambda lam: gent_energy(lam, modulus, jm), stretch)
    neo = derivative(lambda lam: modulus / 2 * strain_invariant(lam), stretch)
    assert gent / neo == pytest.approx(gent_factor(stretch, jm))
    assert gent / neo == pytest.approx(1.0765, abs=1e-4)


def test_mooney_rivlin_bounds_at_three():
    c10, c01, c20 = 1.0, 0.02, 0.002

    def energy(j1):
        return c10 * j1 + c01 * j1 + c20 * j1**2

    j1 = strain_invariant(3.0)
    assert energy(j1) / (c10 * j1) - 1 == pytest.approx(mooney_rivlin_energy_error(3.0))
    assert derivative(energy, j1) / c10 - 1 == pytest.approx(mooney_rivlin_stiffness_error(3.0))
    assert mooney_rivlin_energy_error(3.0) == pytest.approx(0.034, abs=5e-4)
    assert mooney_rivlin_stiffness_error(3.0) == pytest.approx(0.048, abs=5e-4)


@pytest.mark.parametrize("bend", [0.0, 0.5, 2.0])
def test_deformed_depth_solves_equation_3_44(bend):
    def slope(depth, moved):
        return (1 - depth) / (moved**2 * bend - moved * (2 * bend + 1) + 1 + bend)

    depths = np.linspace(0.0, 0.6, 7)
    solved = solve_ivp(slope, (0.0, 0.6), [0.0], t_eval=depths, rtol=1e-10, atol=1e-12)
    assert deformed_depth(depths, bend) == pytest.approx(solved.y[0], abs=1e-8)


@pytest.mark.parametrize(("depth", "invariant"), [(0.0, 7.111), (0.3, 6.689), (0.5, 7.386)])
def test_strain_at_twice_the_height(depth, invariant):
    assert wall_strain_invariant(depth, 2.0) == pytest.approx(invariant, abs=5e-4)


def test_outer_face_is_in_pure_shear():
    along, across, around = wall_stretches(0.0, 1.3)
    assert (along, across, around) == pytest.approx((2.3, 1 / 2.3, 1.0))
    assert wall_strain_invariant(0.0, 1.3) == pytest.approx(strain_invariant(2.3))


def test_rubber_keeps_its_volume():
    assert np.prod(wall_stretches(np.linspace(0, 0.6, 9), 1.7), axis=0) == pytest.approx(np.ones(9))
