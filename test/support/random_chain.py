"""A random serial chain with the dense mass matrix that its Jacobians give."""

import numpy as np
from scipy.spatial.transform import Rotation

from pneuflex_sim.dynamics.chain import Links, not_placed, place_links


class RandomChain:
    """A random serial chain and its dense joint-space mass matrix."""

    def __init__(self, n, seed):
        rng = np.random.default_rng(seed)
        self.n, self.rng = n, rng
        self.q = Rotation.from_rotvec(rng.normal(size=(n, 3))).as_quat()
        self.offset, self.com = rng.normal(size=(n, 3)), rng.normal(size=(n, 3))
        self.inertia, self.mass = rng.uniform(0.1, 1, (n, 3)), rng.uniform(0.5, 2, n)
        start, self.placed = np.array([0, n]), not_placed(n)
        self.links = Links(start, self.offset, self.com, self.inertia, self.mass)
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
