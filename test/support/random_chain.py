"""A random serial chain with the dense mass matrix that its Jacobians give."""

import numpy as np
from scipy.spatial.transform import Rotation

from softhand_model.dynamics.chain import Links, not_placed, place_links


class RandomChain:
    """A random serial chain, its dense joint-space mass matrix, and that of the share `given` of
    the inertia that is given back."""

    def __init__(self, n, seed, given=0.0):
        rng = np.random.default_rng(seed)
        self.n, self.rng = n, rng
        self.q = Rotation.from_rotvec(rng.normal(size=(n, 3))).as_quat()
        self.offset, self.com = rng.normal(size=(n, 3)), rng.normal(size=(n, 3))
        self.inertia, self.mass = rng.uniform(0.1, 1, (n, 3)), rng.uniform(0.5, 2, n)
        start, self.placed = np.array([0, n]), not_placed(n)
        self.given = given * self.inertia
        self.links = Links(start, self.offset, self.com, self.inertia, self.mass, self.given)
        place_links(self.q, self.links, self.placed)

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

    def given_matrix(self):
        return sum(spin.T @ own @ spin for spin, own in self._given())

    def given_by_base(self, rate):
        """Torques (3n,) of the given inertia when the base turns at this rate (3,)."""
        return sum(spin.T @ own @ rate for spin, own in self._given())

    def given_reaction(self, rates, base_rate):
        """Moment (3,) that turns the given inertia of all links."""
        return sum(own @ (spin @ rates.ravel() + base_rate) for spin, own in self._given())

    def _given(self):
        for i, frame, _, angular in self.jacobians():
            yield angular, frame @ np.diag(self.given[i]) @ frame.T
