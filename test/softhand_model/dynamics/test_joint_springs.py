"""Springs of a joint against their energy and eq. 3.24, and one implicit step of a chain's."""

import numpy as np
import pytest
from random_chain import RandomChain
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

from softhand_model.dynamics.joint_springs import (
    Actuation,
    Joints,
    Springs,
    elastic_torque,
    look_at_joints,
    nothing_before,
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


@pytest.mark.parametrize("size", [0.0099, 0.0101])
def test_series_of_small_angles_and_closed_form_meet(size):
    stiffness, error = np.array([0.7, 2.0, 0.3]), size * np.array([0.6, 0.0, 0.8])
    along = stiffness * error
    share = (1 - 0.5 * size / np.tan(0.5 * size)) / size**2
    again = np.cross(error, np.cross(error, along))
    expected = -along + 0.5 * np.cross(error, along) - share * again
    found, *factors = elastic_torque(error, 0.5, stiffness, 0.0)
    assert found == pytest.approx(expected, rel=1e-11)
    assert factors == [1.0, 1.0]


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
        before = nothing_before(n, 1)._replace(placed=chain.placed)
        before.torque[:] = -stiffness * deflection  # the load balances the spring, at v = 0
        spring_torques(
            step,
            False,
            chain.links,
            Springs(rest, stiffness, np.zeros(n), 0.01 * stiffness),
            Joints(chain.q, np.zeros((n, 3)), np.array([False])),
            Actuation(np.zeros((n, 3)), np.full((n, 3), 5.0)),
            before,
        )
        np.testing.assert_allclose(before.torque, -stiffness * deflection, rtol=1e-9)


class Step:
    """One step of a random chain, and the same by a dense solver from the text of the module."""

    def __init__(self, n=3, seed=7, stretching=0.0, deflection=0.2, speed=0.5, bend=0.1):
        chain = RandomChain(n, seed, given=0.6)
        self.chain, self.shape = chain, (n, 3)
        self.rest = (
            Rotation.from_quat(chain.q)
            * Rotation.from_rotvec(-deflection * chain.rng.normal(size=self.shape))
        ).as_quat()
        self.stiffness, self.damping, self.gas = (
            chain.rng.uniform(0.5, 2.0, self.shape) * size for size in (1.0, 0.03, 4.0)
        )
        self.stretching = np.full(n, stretching)
        self.v = speed * chain.rng.normal(size=self.shape)
        self.bend = bend * chain.rng.normal(size=self.shape)
        self.v_before = speed * chain.rng.normal(size=self.shape)
        self.torque_before, self.carried_before = chain.rng.normal(size=(2, n, 3))
        self.base_rate = chain.rng.normal(size=(1, 3))

    def found(self, dt, first_step=False, heavy=False):
        """Torques of the step, and the velocities that it leaves to the next."""
        self.before = nothing_before(len(self.v), 1)._replace(placed=self.chain.placed)
        self.before.v[:], self.before.torque[:] = self.v_before, self.torque_before
        self.before.carried[:] = self.carried_before
        self.before.base_rate[:] = self.base_rate
        spring_torques(
            dt,
            first_step,
            self.chain.links,
            Springs(self.rest, self.stiffness, self.stretching, self.damping),
            Joints(self.chain.q, self.v, np.array([heavy])),
            Actuation(self.bend, self.gas),
            self.before,
        )
        return self.before.torque

    def errors(self):
        """Rotation vectors of the joints from rest, and what `elastic_torque` says of them."""
        rest = Rotation.from_quat(self.rest) * Rotation.from_rotvec(self.bend)
        errors = (rest.inv() * Rotation.from_quat(self.chain.q)).as_rotvec()
        said = [
            elastic_torque(error, bend[1], stiffness, stretching)
            for error, bend, stiffness, stretching in zip(
                errors, self.bend, self.stiffness, self.stretching, strict=True
            )
        ]
        return errors, said

    def expected(self, dt, first_step=False, heavy=False, more_torque=0.0, more_added=0.0):
        mass = self.chain.mass_matrix()
        share = 0.0 if heavy else 1.0
        given = share * self.chain.given_matrix()
        _, said = self.errors()
        bending = [np.array([[1.0, entry[k], 1.0] for entry in said]) for k in (1, 2)]
        tangent, gas = self.stiffness * bending[0], self.gas * bending[1]
        torque = np.array([entry[0] for entry in said]) + more_torque
        torque -= (dt * tangent + self.damping + dt * gas) * self.v
        added = dt * (self.damping + dt * gas + dt * tangent) + more_added
        external = mass @ (self.v - self.v_before).ravel() / dt
        external -= (self.torque_before - self.carried_before).ravel()
        right = torque.ravel() + (0.0 if first_step else external)
        acceleration = np.linalg.solve(mass - given + np.diag(added.ravel()), right)
        back = given @ acceleration + share * self.chain.given_by_base(self.base_rate[0])
        return torque - added * acceleration.reshape(self.shape) + back.reshape(self.shape)


@pytest.mark.parametrize(("first_step", "heavy"), [(True, False), (False, False), (False, True)])
@pytest.mark.parametrize("stretching", [0.0, 0.9])
def test_a_step_solves_the_implicit_equation_with_the_load_of_the_step_before(
    stretching, first_step, heavy
):
    step = Step(stretching=stretching)
    found = step.found(2e-3, first_step, heavy)
    expected = step.expected(2e-3, first_step, heavy)
    np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-9)
    np.testing.assert_array_equal(step.before.v, step.v)


@pytest.mark.parametrize(("angle", "over"), [(2.39, 0.0), (2.5, 0.1), (-2.5, -0.1), (-2.39, 0.0)])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_joint_far_from_rest_meets_a_stop_twenty_times_as_stiff(axis, angle, over):
    step, turn = Step(n=1, speed=0.0, bend=0.0), np.zeros((1, 3))
    turn[0, axis] = angle
    step.rest = (Rotation.from_quat(step.chain.q) * Rotation.from_rotvec(-turn)).as_quat()
    stop, dt = np.zeros((1, 3)), 2e-3
    if over:
        stop[0, axis] = 20.0 * step.stiffness[0, axis]
    expected = step.expected(dt, True, more_torque=-stop * over, more_added=dt * dt * stop)
    np.testing.assert_allclose(step.found(dt, True), expected, rtol=1e-8, atol=1e-9)


def test_the_stop_is_met_by_bend_deflection_and_what_the_speed_adds_in_a_step():
    step, dt = Step(n=1, speed=0.0, bend=0.0), 2e-3
    step.rest = (Rotation.from_quat(step.chain.q) * Rotation.from_rotvec([0, -2.3, 0])).as_quat()
    step.bend, step.v = np.array([[0.0, 1.3, 0.0]]), np.array([[0.0, 60.0, 0.0]])
    # 1.3 of pressure, 1.0 of deflection and 0.12 of motion make 2.42 [rad]; the brake at 50 rad/s
    stop = np.array([[0.0, 20.0 * step.stiffness[0, 1], 0.0]])
    brake = np.array([[0.0, 0.3 * step.stiffness[0, 1], 0.0]])
    expected = step.expected(
        dt,
        True,
        more_torque=-stop * 0.02 - brake * 10.0,
        more_added=dt * dt * stop + dt * brake,
    )
    np.testing.assert_allclose(step.found(dt, True), expected, rtol=1e-8, atol=1e-9)


@pytest.mark.parametrize(("asked", "least"), [(3.0, 2.4), (-3.0, -2.4), (2.0, 2.0)])
def test_no_pressure_turns_the_rest_beyond_the_stop(asked, least):
    step = Step(n=1, bend=0.0)
    step.bend[0] = asked, 0.1, -asked
    step.found(1e-3)
    assert step.bend[0] == pytest.approx([least, 0.1, -least])


@pytest.mark.parametrize(("dt", "fastest"), [(1e-3, 50.0), (6e-3, 0.2 / 6e-3), (0.02, 20.0)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_joint_that_would_turn_too_far_in_a_step_is_braked(dt, fastest, sign):
    step = Step(n=1, deflection=0.0, bend=0.0, speed=0.0)
    step.damping = step.damping * 0.01
    step.v = sign * np.array([[2.0 * fastest, 0.5 * fastest, 0.0]])
    brake = np.array([[0.3 * step.stiffness[0, 0], 0.0, 0.0]])
    expected = step.expected(dt, True, more_torque=-brake * sign * fastest, more_added=dt * brake)
    np.testing.assert_allclose(step.found(dt, True), expected, rtol=1e-8, atol=1e-9)


def test_the_joints_are_seen_against_their_rest_with_the_greatest_speed():
    chain, turns = (
        RandomChain(3, seed=1),
        np.array([[0.1, 0.0, 0.4], [0.0, -0.2, 0.0], [1.0, 0, 0]]),
    )
    q = (Rotation.from_quat(chain.q) * Rotation.from_rotvec(turns)).as_quat()
    v, rotations = np.array([[1.0, -5.0, 0.0], [0.0, 2.0, 0.0], [3.0, 0.0, 4.0]]), np.empty((3, 3))
    assert look_at_joints(chain.q, q, v, rotations) == 5.0
    assert rotations == pytest.approx(turns)
    v[1, 1] = np.nan
    assert np.isnan(look_at_joints(chain.q, q, v, rotations))
    assert look_at_joints(chain.q, q, np.zeros((3, 3)), rotations) == 0.0
