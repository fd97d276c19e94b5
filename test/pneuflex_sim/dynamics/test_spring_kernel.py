"""One implicit step of the springs of a chain."""

import numpy as np
from random_chain import RandomChain
from scipy.spatial.transform import Rotation

from pneuflex_sim.dynamics.joint_springs import (
    Actuation,
    Before,
    Joints,
    Springs,
    spring_torques,
)


def test_at_rest_the_torque_is_minus_stiffness_times_deflection_whatever_the_step():
    chain = RandomChain(4, seed=3)
    n, deflection = chain.n, 0.1 * chain.rng.normal(size=(4, 3))
    rest = (Rotation.from_quat(chain.q) * Rotation.from_rotvec(-deflection)).as_quat()
    stiffness = np.repeat(chain.rng.uniform(0.5, 2, (n, 1)), 3, axis=1)
    for step in (1e-3, 1e-2):
        torque = -stiffness * deflection  # the load balances the spring: the step before left v = 0
        spring_torques(
            step,
            False,
            chain.links,
            Springs(rest, stiffness, np.zeros(n), 0.01 * stiffness),
            Joints(chain.q, np.zeros((n, 3))),
            Actuation(np.zeros((n, 3)), np.full((n, 3), 5.0)),
            Before(np.zeros((n, 3)), torque, chain.placed),
        )
        np.testing.assert_allclose(torque, -stiffness * deflection, rtol=1e-9)
