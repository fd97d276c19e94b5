"""The linear-time recursions against a dense mass matrix built from Jacobians."""

import numpy as np
import pytest
from random_chain import RandomChain

from pneuflex_sim.dynamics import chain as chain_kernel


@pytest.mark.parametrize("n", [1, 2, 7, 30])
def test_inertial_torque_is_the_mass_matrix_times_the_rate(n):
    chain = RandomChain(n, seed=n)
    rate, out = chain.rng.normal(size=(n, 3)), np.empty((n, 3))
    chain_kernel.inertial_torque(0, n, rate, chain.mass, *chain.placed, out)
    np.testing.assert_allclose(
        out.ravel(), chain.mass_matrix() @ rate.ravel(), rtol=1e-10, atol=1e-9
    )


@pytest.mark.parametrize("n", [1, 2, 7, 30])
def test_solve_agrees_with_a_dense_solver(n):
    chain = RandomChain(n, seed=100 + n)
    added, right, out = (
        chain.rng.uniform(0.1, 1, (n, 3)),
        chain.rng.normal(size=(n, 3)),
        np.empty((n, 3)),
    )
    chain_kernel.solve_chains(np.array([0, n]), added, right, chain.mass, *chain.placed, out)
    expected = np.linalg.solve(chain.mass_matrix() + np.diag(added.ravel()), right.ravel())
    np.testing.assert_allclose(out.ravel(), expected, rtol=1e-7, atol=1e-9)
