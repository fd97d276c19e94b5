"""The linear-time recursions against a dense mass matrix built from Jacobians."""

import numpy as np
import pytest
from random_chain import RandomChain

from softhand_model.dynamics.chain import Equation, give_back, inertial_torque, solve_chains


@pytest.mark.parametrize("n", [1, 2, 7, 30])
def test_inertial_torque_is_the_mass_matrix_times_the_rate(n):
    chain = RandomChain(n, seed=n)
    rate, out = chain.rng.normal(size=(n, 3)), np.empty((n, 3))
    inertial_torque(rate, chain.links, chain.placed, out)
    np.testing.assert_allclose(
        out.ravel(), chain.mass_matrix() @ rate.ravel(), rtol=1e-10, atol=1e-9
    )


@pytest.mark.parametrize("n", [1, 2, 7, 30])
def test_solve_agrees_with_a_dense_solver(n):
    chain = RandomChain(n, seed=100 + n, given=0.6)
    added, right, out = (
        chain.rng.uniform(0.1, 1, (n, 3)),
        chain.rng.normal(size=(n, 3)),
        np.empty((n, 3)),
    )
    solve_chains(Equation(added, right, out), chain.links, chain.placed)
    light = chain.mass_matrix() - chain.given_matrix()
    expected = np.linalg.solve(light + np.diag(added.ravel()), right.ravel())
    np.testing.assert_allclose(out.ravel(), expected, rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("n", [1, 7])
def test_inertia_given_back_counts_absolute_spins_of_joints_and_base(n):
    chain = RandomChain(n, seed=n, given=0.6)
    rate, base_rate = chain.rng.normal(size=(n, 3)), chain.rng.normal(size=(1, 3))
    out, reaction = np.ones((n, 3)), np.empty((1, 3))
    give_back(rate, base_rate, chain.links, chain.placed, out, reaction)
    expected = chain.given_matrix() @ rate.ravel() + chain.given_by_base(base_rate[0])
    np.testing.assert_allclose(out.ravel() - 1.0, expected, rtol=1e-10, atol=1e-9)
    np.testing.assert_allclose(reaction[0], chain.given_reaction(rate, base_rate[0]), rtol=1e-10)
