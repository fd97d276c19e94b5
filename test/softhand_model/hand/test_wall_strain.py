"""Strain through the wall: the cubic against the differential equation that the thesis prints."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from softhand_model.hand.rubber import (
    deformed_depth,
    strain_invariant,
    wall_strain_invariant,
    wall_stretches,
)


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
