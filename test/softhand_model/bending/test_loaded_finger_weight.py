"""Weight in the deformed shape against a boundary value problem solved by scipy."""

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from softhand_model.bending.loaded_finger import Weight, running_integral
from softhand_model.effects.stages import SectionShape
from softhand_model.hand.section import free_stretch, side_wall_ratio

LENGTH, WALL, MODULUS = 0.09, 0.0025, 67e3
POINTS = 8


def finger(per_length, taper=0.0, tilt=0.0, at_tip=0.0):
    """Gauss points, shape and weight of one finger, and the load at its tip [N]; height falls in a
    straight line by `taper`.
    """
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    x, weights = LENGTH / 2 * (nodes + 1), LENGTH / 2 * weights
    height = height_at(x, taper)[None, None]
    width = np.full((1, 1, 1), 0.02)
    ratio = side_wall_ratio(height, width, WALL, WALL)
    shape = SectionShape(height, width, WALL, WALL, ratio, MODULUS)
    weight = Weight(
        (per_length * (LENGTH - x) + at_tip)[None, None],
        np.full((1, 1, 1), tilt),
        weights[None, None],
        running_integral(np.array([0.0, LENGTH]), POINTS)[None],
    )
    return weight, shape


def height_at(x, taper):
    return 0.02 * (1 - taper * x / LENGTH)


def side(stretch):
    return stretch - stretch**-3


def tip_angle(per_length, pressure, taper=0.0, tilt=0.0, at_tip=0.0):
    weight, shape = finger(per_length, taper, tilt, at_tip)
    load = pressure * shape.ratio * shape.height / (4 * MODULUS * WALL)
    found = weight.solver(shape)(side, load, None)
    assert found.settled
    return float(np.sum(weight.weights * (found.stretch - 1) / shape.height))


def exact_tip_angle(per_length, pressure, taper=0.0, tilt=0.0, at_tip=0.0):
    """theta' = kappa, M' = -(w*(L - x) + W)*sin(theta + tilt), theta(0) = 0, M(L) = 0."""

    def slopes(x, state):
        height = height_at(x, taper)
        ratio = side_wall_ratio(height, 0.02, WALL, WALL)
        load = pressure * ratio * height / (4 * MODULUS * WALL)
        moment = ratio * state[1] / (2 * MODULUS * height * WALL * 0.02)
        kappa = (free_stretch(load - moment) - 1) / height
        pull = per_length * (LENGTH - x) + at_tip
        return np.stack([kappa, -pull * np.sin(state[0] + tilt)])

    x = np.linspace(0.0, LENGTH, 30)
    guess = np.stack([20.0 * x, 0.0 * x])
    found = solve_bvp(slopes, lambda a, b: np.array([a[0], b[1]]), x, guess, tol=1e-8)
    assert found.success
    return found.y[0, -1]


def test_running_integral_is_exact_for_polynomials_on_each_piece():
    matrix = running_integral(np.array([0.0, 0.02, 0.09]), 4)
    nodes = np.polynomial.legendre.leggauss(4)[0]
    x = np.concatenate([0.01 * (nodes + 1), 0.02 + 0.035 * (nodes + 1)])
    assert matrix @ x**3 == pytest.approx(x**4 / 4, rel=1e-12)
    bent = np.maximum(x - 0.02, 0.0)
    assert matrix @ bent == pytest.approx(bent**2 / 2, rel=1e-12)


@pytest.mark.parametrize(("at_tip", "tilt"), [(0.3, 0.0), (-0.1, 0.0), (0.3, np.pi / 2)])
def test_a_load_at_the_tip_bends_as_the_boundary_value_problem_says(at_tip, tilt):
    for pressure in (5e3, 25e3, 50e3):
        exact = exact_tip_angle(3.8, pressure, 0.4, tilt, at_tip)
        assert tip_angle(3.8, pressure, 0.4, tilt, at_tip) == pytest.approx(exact, rel=1e-6)
        assert abs(exact / exact_tip_angle(3.8, pressure, 0.4, tilt) - 1) > 1e-2


@pytest.mark.parametrize("tilt", [0.0, np.pi / 2])
@pytest.mark.parametrize("taper", [0.0, 0.4])
@pytest.mark.parametrize("per_length", [3.8, -3.8, 15.0])
def test_weight_bends_as_the_boundary_value_problem_says(per_length, taper, tilt):
    for pressure in (5e3, 25e3, 50e3):
        exact = exact_tip_angle(per_length, pressure, taper, tilt)
        assert tip_angle(per_length, pressure, taper, tilt) == pytest.approx(exact, rel=1e-6)
        assert abs(exact / exact_tip_angle(0.0, pressure, taper) - 1) > 1e-3


def test_hanging_straightens_and_standing_bends_further():
    assert tip_angle(3.8, 20e3) < tip_angle(0.0, 20e3) < tip_angle(-3.8, 20e3)


def test_a_level_finger_without_pressure_sags_as_a_cantilever():
    shape = finger(0.01)[1]
    bending = float(2 / shape.ratio[0, 0, 0]) * 4 * 0.02**2 * 0.02 * MODULUS * WALL
    sags = 0.01 * LENGTH**3 / 6 / bending  # slope at the end of a beam under its own weight
    assert tip_angle(0.01, 0.0, tilt=np.pi / 2) == pytest.approx(-sags, rel=1e-3)


def test_small_loads_hang_as_a_linear_beam():
    shape = finger(0.01)[1]
    bending = float(2 / shape.ratio[0, 0, 0]) * 4 * 0.02**2 * 0.02 * MODULUS * WALL
    pressure = 10.0
    kappa = pressure * 0.02**2 * 0.02 / 2 / bending
    # M(x) = w*kappa*int_x^L (L - u)*u du, and the tip turns back by int_0^L M/B dx
    turned = 0.01 * kappa * LENGTH**4 / 12 / bending
    lost = tip_angle(0.0, pressure) - tip_angle(0.01, pressure)
    assert lost == pytest.approx(turned, rel=1e-3)


def test_alike_rows_share_a_matrix_and_have_the_same_answer():
    weight, shape = finger(8.0)
    rows = np.zeros(40, int)
    pressures = np.linspace(0.0, 50e3, 40)[None, :, None]
    load = pressures * shape.ratio * shape.height / (4 * MODULUS * WALL)
    each = weight.of_rows(rows)
    alone = each.solver(shape)(side, load, None).stretch
    together = each.solver(shape, alike=8)(side, load, None).stretch
    assert together == pytest.approx(alone, rel=1e-9)
