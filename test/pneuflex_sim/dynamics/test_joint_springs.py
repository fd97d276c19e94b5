"""Springs of a joint against their energy and eq. 3.24, and one implicit step of a chain's."""

import numpy as np
import pytest
from random_chain import RandomChain
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

from pneuflex_sim.dynamics.joint_springs import (
    Actuation,
    Before,
    Joints,
    Springs,
    elastic_torque,
    spring_torques,
)


def elastic_energy(turn, rest_bend, stiffness, stretching):
    """Energy [J] of a joint turned by `turn` from its rest shape; quadrature of q over the bend."""
    x, y, z = turn.as_rotvec()
    energy = 0.5 * (stiffness[0] * x * x + stiffness[2] * z * z)
    if not stretching:
        return energy + 0.5 * stiffness[1] * y * y

    def moment(bend):
        here, rest = (1 + stretching * angle for angle in (bend, rest_bend))
        return stiffness[1] / (2 * stretching) * ((here - here**-3) - (rest - rest**-3))

    return energy + quad(moment, rest_bend, rest_bend + y, epsabs=1e-14, epsrel=1e-13)[0]


@pytest.mark.parametrize("stretching", [0.0, 1.1])
@pytest.mark.parametrize("size", [1e-4, 0.3, 1.5])
def test_torque_of_a_spring_is_minus_the_gradient_of_its_energy(size, stretching):
    rng = np.random.default_rng(5)
    stiffness = np.array([0.7, 2.0, 0.3])
    error = size * np.array([0.4, -0.2, 0.9]) if size > 1 else size * rng.normal(size=3)
    torque, _, _ = elastic_torque(error, 0.5, stiffness, stretching)
    start, small = Rotation.from_rotvec(error), 1e-5
    slope = [
        elastic_energy(start * Rotation.from_rotvec(small * axis), 0.5, stiffness, stretching)
        - elastic_energy(start * Rotation.from_rotvec(-small * axis), 0.5, stiffness, stretching)
        for axis in np.eye(3)
    ]
    np.testing.assert_allclose(torque, -np.array(slope) / (2 * small), rtol=1e-6, atol=1e-9)


def test_rubber_is_twice_as_stiff_as_the_rule_when_straight_and_half_as_stiff_far_bent():
    """The factor (1 + 3*(1 + h*kappa)**-4)/2 of eq. 3.24, by differences of the torque."""
    stiffness, stretching = np.array([1.0, 3.0, 1.0]), 0.8

    def torque(bend):
        error = np.array([0.0, bend - 0.4, 0.0])
        found, *factors = elastic_torque(error, 0.4, stiffness, stretching)
        return found[1], tuple(factors)

    for bend in (0.0, 0.2, 1.0, 12.0):
        slope = (torque(bend + 1e-5)[0] - torque(bend - 1e-5)[0]) / 2e-5
        factor = (1 + 3 * (1 + stretching * bend) ** -4) / 2
        assert -slope == pytest.approx(3.0 * factor, rel=1e-6)
        assert torque(bend)[1] == pytest.approx((factor, (1 + 3 * 1.32**-4) / 2), rel=1e-12)
    assert torque(0.4)[0] == 0.0  # at its rest


def test_rubber_pressed_together_stays_finite_and_stiffens_no_further():
    torques = []
    for bend in (-0.6, -1.5, -2.4):
        torque, _, _ = elastic_torque(np.array([0.0, bend, 0.0]), 0.0, np.ones(3), 1.0)
        torques.append(torque[1])
    assert np.isfinite(torques).all()
    assert torques[2] - torques[1] == pytest.approx(torques[1] - torques[0])


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
