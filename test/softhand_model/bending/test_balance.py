"""The balance of elastic side and load against bisection, and where there is none."""

import numpy as np
import pytest
from scipy.optimize import brentq

from softhand_model.bending.balance import (
    HIGHEST_ROOT,
    Balanced,
    balance,
    rough_root,
    rough_stretch,
)
from softhand_model.hand.section import free_stretch

SIDES = {
    "neo-hookean": lambda lam: lam - lam**-3,
    "locking": lambda lam: (lam - lam**-3) * (1 + 20 * np.maximum(lam - 1.5, 0) ** 2),
    "kinked": lambda lam: lam - lam**-3 + 0.3 * np.clip(20 * (lam - 1.4), -1, 1),
    "softer": lambda lam: 0.1 * (lam - lam**-3) + 0.05 * np.tanh(30 * (lam - 2)),
    "steep": lambda lam: np.sinh(3 * (lam - 1)),
}


@pytest.mark.parametrize("name", SIDES)
def test_balance_is_the_root_that_bisection_finds(name):
    side = SIDES[name]
    loads = np.array([-3.0, -0.2, 0.0, 1e-6, 0.1, 0.5, 1.0, 2.0, 4.0])
    if name == "softer":
        loads = 0.1 * loads
    roots = [brentq(lambda lam, load=load: side(lam) - load, 0.05, 59.0) for load in loads]
    found = balance(side, loads)
    assert found.settled
    assert found.stretch == pytest.approx(np.array(roots), rel=1e-9)


def test_a_start_far_away_leads_to_the_same_root():
    loads = np.linspace(0.0, 3.0, 50)
    start = Balanced(np.full(50, 5.0), np.full(50, 0.1))
    found = balance(SIDES["neo-hookean"], loads, start)
    assert found.stretch == pytest.approx(free_stretch(loads), rel=1e-10)


def test_a_start_nearby_takes_few_evaluations():
    calls = []

    def counted(stretch):
        calls.append(1)
        return stretch - stretch**-3

    loads = np.linspace(0.1, 3.0, 50)
    exact = free_stretch(loads)
    found = balance(counted, loads, Balanced(exact + 1e-4, 1 + 3 * exact**-4))
    assert len(calls) <= 3
    assert found.stretch == pytest.approx(exact, rel=1e-11)


def test_a_load_that_nothing_carries_is_told_and_stays_finite():
    found = balance(lambda lam: np.tanh(lam - 1.0), np.array([0.5, 2.0]))
    assert not found.settled
    assert found.stretch[0] == pytest.approx(1.0 + np.arctanh(0.5), rel=1e-9)
    assert 0.9 * HIGHEST_ROOT < found.stretch[1] <= HIGHEST_ROOT


def test_rough_stretch_is_near_the_root():
    loads = np.linspace(-3.0, 10.0, 500)
    assert rough_stretch(loads) == pytest.approx(free_stretch(loads), rel=0.05)
    roots = [rough_root(load) for load in loads]
    assert roots == pytest.approx(rough_stretch(loads), rel=1e-14)
