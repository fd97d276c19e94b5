"""The linear-time recursions against a dense mass matrix built from Jacobians."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pneuflex_sim import spring_kernel


class Chain:
    """A random serial chain and its dense joint-space mass matrix."""

    def __init__(self, n, seed):
        rng = np.random.default_rng(seed)
        self.n, self.rng = n, rng
        self.q = Rotation.from_rotvec(rng.normal(size=(n, 3))).as_quat()
        self.offset, self.com = rng.normal(size=(n, 3)), rng.normal(size=(n, 3))
        self.inertia, self.mass = rng.uniform(0.1, 1, (n, 3)), rng.uniform(0.5, 2, n)
        self.placed = (np.empty((n, 3, 3)), np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3)))
        spring_kernel.place_joints(0, n, self.q, self.offset, self.com, self.inertia, *self.placed)

    def jacobians(self):
        frames = []
        turn, origin, origins = Rotation.identity(), np.zeros(3), []
        for q, offset in zip(self.q, self.offset, strict=True):
            origin = origin + turn.apply(offset)
            turn = turn * Rotation.from_quat(q)
            frames.append(turn.as_matrix())
            origins.append(origin)
        for i in range(self.n):
            linear, angular = np.zeros((3, 3 * self.n)), np.zeros((3, 3 * self.n))
            center = origins[i] + frames[i] @ self.com[i]
            for j in range(i + 1):
                for k in range(3):
                    axis = frames[j][:, k]
                    linear[:, 3 * j + k] = np.cross(axis, center - origins[j])
                    angular[:, 3 * j + k] = axis
            yield i, frames[i], linear, angular

    def mass_matrix(self):
        total = np.zeros((3 * self.n, 3 * self.n))
        for i, frame, linear, angular in self.jacobians():
            own = frame @ np.diag(self.inertia[i]) @ frame.T
            total += self.mass[i] * linear.T @ linear + angular.T @ own @ angular
        return total


@pytest.mark.parametrize("n", [1, 2, 7, 30])
def test_inertial_torque_is_the_mass_matrix_times_the_rate(n):
    chain = Chain(n, seed=n)
    rate, out = chain.rng.normal(size=(n, 3)), np.empty((n, 3))
    spring_kernel.inertial_torque(0, n, rate, chain.mass, *chain.placed, out)
    np.testing.assert_allclose(
        out.ravel(), chain.mass_matrix() @ rate.ravel(), rtol=1e-10, atol=1e-9
    )


@pytest.mark.parametrize("n", [1, 2, 7, 30])
def test_solve_agrees_with_a_dense_solver(n):
    chain = Chain(n, seed=100 + n)
    added, right, out = (
        chain.rng.uniform(0.1, 1, (n, 3)),
        chain.rng.normal(size=(n, 3)),
        np.empty((n, 3)),
    )
    spring_kernel.solve_chains(np.array([0, n]), added, right, chain.mass, *chain.placed, out)
    expected = np.linalg.solve(chain.mass_matrix() + np.diag(added.ravel()), right.ravel())
    np.testing.assert_allclose(out.ravel(), expected, rtol=1e-7, atol=1e-9)


def test_at_rest_the_torque_is_minus_stiffness_times_deflection_whatever_the_step():
    chain = Chain(4, seed=3)
    n, deflection = chain.n, 0.1 * chain.rng.normal(size=(4, 3))
    rest = (Rotation.from_quat(chain.q) * Rotation.from_rotvec(-deflection)).as_quat()
    stiffness = np.repeat(chain.rng.uniform(0.5, 2, (n, 1)), 3, axis=1)
    for step in (1e-3, 1e-2):
        torque = -stiffness * deflection  # the load balances the spring: the step before left v = 0
        spring_kernel.spring_torques(
            step,
            False,
            np.array([0, n]),
            chain.q,
            np.zeros((n, 3)),
            rest,
            np.zeros((n, 3)),
            stiffness,
            np.zeros(n),
            np.full((n, 3), 5.0),
            0.01 * stiffness,
            chain.offset,
            chain.com,
            chain.inertia,
            chain.mass,
            np.zeros((n, 3)),
            *chain.placed,
            torque,
        )
        np.testing.assert_allclose(torque, -stiffness * deflection, rtol=1e-9)
