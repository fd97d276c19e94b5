"""The blocked tip against closed forms, nested bisection, and a boundary value problem."""

import numpy as np
import pytest
from scipy.integrate import solve_bvp
from scipy.optimize import brentq

from softhand_model.bending.loaded_finger import (
    Blocked,
    BlockedSolver,
    bulging,
    running_integral,
)
from softhand_model.effects.stages import SectionShape
from softhand_model.hand.section import (
    bending_load,
    bending_moment,
    free_stretch,
    side_wall_ratio,
)

LENGTH, HEIGHT, WIDTH, WALL, MODULUS = 0.09, 0.02, 0.018, 0.0025, 67e3
NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)
X, WEIGHTS = LENGTH / 2 * (NODES + 1), LENGTH / 2 * WEIGHTS
REACH = LENGTH - X
RUNNING = running_integral(np.array([0.0, LENGTH]), 12)[None]
RATIO = float(side_wall_ratio(HEIGHT, WIDTH, WALL, WALL))


def side(stretch):
    return stretch - stretch**-3


def section_shape():
    sides = np.full((1, 1, 1), HEIGHT), np.full((1, 1, 1), WIDTH)
    return SectionShape(*sides, WALL, WALL, RATIO, MODULUS)


def solver(compliance=0.0, factor=None):
    blocked = Blocked(REACH[None, None], WEIGHTS[None, None], compliance, RUNNING)
    return BlockedSolver(blocked, section_shape(), factor)


def force(pressure, compliance=0.0, factor=None):
    solve = solver(compliance, factor)
    load = np.full((1, 1, 1), float(bending_load(pressure, HEIGHT, WALL, RATIO, MODULUS)))
    assert solve(side, load, None).settled
    return float(solve.force[0, 0, 0])


def exact_force(pressure, compliance=0.0, ratio=1.0):
    """Bisection for the force around bisections for the curvature, from the moment of 3.4.3."""

    def curvature(moment):
        def excess(kappa):
            carried = bending_moment(pressure, kappa, HEIGHT, WIDTH, WALL, WALL, MODULUS)
            return ratio * float(carried) - moment

        return brentq(excess, -45.0, 500.0, xtol=1e-13)

    def gap(tip_force):
        kappa = np.array([curvature(tip_force * reach) for reach in REACH])
        return float(np.sum(WEIGHTS * kappa * REACH)) - compliance * tip_force

    return brentq(gap, 0.0, 20.0, xtol=1e-12)


@pytest.mark.parametrize("pressure", [1e3, 10e3, 40e3])
def test_every_section_is_in_balance_and_the_tip_does_not_move(pressure):
    assert force(pressure) == pytest.approx(exact_force(pressure), rel=1e-8)


def test_gauge_that_yields_takes_force_away():
    yielding = force(30e3, compliance=1 / 50.0)
    assert yielding == pytest.approx(exact_force(30e3, 1 / 50.0), rel=1e-8)
    assert yielding < 0.9 * force(30e3)


def test_small_loads_carry_the_moment_of_a_straight_section():
    """A beam of even stiffness with the moment h**2*z*p/2: F = 1.5*M/L."""
    straight = HEIGHT**2 * WIDTH * 10.0 / 2
    assert force(10.0) == pytest.approx(1.5 * straight / LENGTH, rel=1e-3)


def test_slack_layer_carries_less():
    def slack(bend, rest):
        return np.where(bend < rest, 0.6, 1.0)

    assert force(30e3, factor=slack) == pytest.approx(exact_force(30e3, ratio=0.6), rel=1e-8)
    with_gauge = force(30e3, 0.02, slack)
    assert with_gauge == pytest.approx(exact_force(30e3, 0.02, 0.6), rel=1e-8)


def test_linear_springs_have_a_closed_form():
    blocked = Blocked(REACH, WEIGHTS, 0.0, RUNNING)
    found = blocked.spring_force(np.full(12, 20.0), np.full(12, 4e-3), lambda bend, rest: 1.0)
    assert found[0] == pytest.approx(1.5 * 4e-3 * 20.0 / LENGTH, rel=1e-12)
    soft = Blocked(REACH, WEIGHTS, LENGTH**3 / 3 / 4e-3, RUNNING)
    halved = soft.spring_force(np.full(12, 20.0), np.full(12, 4e-3), lambda bend, rest: 1.0)
    assert halved[0] == pytest.approx(found[0] / 2, rel=1e-12)
    slack = blocked.spring_force(
        np.full(12, 20.0), np.full(12, 4e-3), lambda bend, rest: np.where(bend < rest, 0.3, 1.0)
    )
    assert slack[0] == pytest.approx(0.3 * found[0], rel=1e-12)


@pytest.mark.parametrize("compliance", [0.0, 1 / 150.0])
@pytest.mark.parametrize("pressure", [5e3, 20e3, 40e3])
def test_a_finger_bulges_as_the_beam_of_finite_rotations(pressure, compliance):
    """theta' = kappa(F*(x(L) - x)), x' = cos(theta), y' = sin(theta), y(L) = F*compliance."""
    per_moment = RATIO / (2.0 * MODULUS * HEIGHT * WALL * WIDTH)

    def beam(finite):
        def slopes(s, state, parameters):
            angle, x, _ = state
            force, end = parameters
            load = bending_load(pressure, HEIGHT, WALL, RATIO, MODULUS)
            kappa = (free_stretch(load - per_moment * force * (end - x)) - 1.0) / HEIGHT
            turned = (np.cos(angle), np.sin(angle)) if finite else (np.ones_like(s), angle)
            return np.vstack([kappa, *turned])

        def ends(base, tip, parameters):
            force, end = parameters
            return np.array([*base, tip[1] - end, tip[2] - compliance * force])

        s, begun = np.linspace(0.0, LENGTH, 60), 0.8 * force(pressure, compliance)
        guess = np.vstack([0.0 * s, s, 0.0 * s])
        found = solve_bvp(slopes, ends, s, guess, p=[begun, LENGTH], tol=1e-9, max_nodes=20_000)
        assert found.success
        return found.p[0]

    assert beam(finite=False) == pytest.approx(force(pressure, compliance), rel=1e-6)
    load = np.full((1, 1, 12), float(bending_load(pressure, HEIGHT, WALL, RATIO, MODULUS)))
    blocked = Blocked(REACH[None, None], WEIGHTS[None, None], compliance, RUNNING)
    found = float(bulging(load, section_shape(), blocked)[0, 0, 0])
    assert found == pytest.approx(beam(finite=True) / beam(finite=False), abs=2e-4)
    assert compliance or found > 1.0
