"""The static finger against closed forms and against another way to solve it."""

import numpy as np
import pytest
from scipy.optimize import minimize

from softhand_model.chain.chain import discretise
from softhand_model.hand import section
from softhand_model.hand.actuator import Actuator, load_actuator
from softhand_model.hand.hand import load_hand
from softhand_model.hand.profile import ConstantProfile, TaperedProfile
from softhand_model.model_file import Model
from thesis.chapter_3_and_5.planar import (
    PlanarFinger,
    Stop,
    equilibrium,
    exact_springs,
    linear_springs,
    planar_finger,
)

STRAIGHT = Stop((-1.0, 0.0), 0.0)


def finger_with(segments):
    return discretise(load_hand("single_finger").chain("finger"), segments, Model())


def test_free_finger_takes_its_rest_angles():
    chain = finger_with(5)
    rest = chain.rest_rotation([31e3])[:, 1]
    found = equilibrium(
        planar_finger(chain.segments), linear_springs(chain.segments.stiffness[:, 1], rest)
    )
    assert found.angles == pytest.approx(rest, abs=1e-9)
    assert found.tip_force == 0.0


def test_pendulum_with_a_spring_balances_its_weight():
    """One joint, weight across: k*theta = -m*g*l*cos(theta)."""
    bar = PlanarFinger(np.array([0.0]), 0.1, np.array([0.2]), np.array([[0.0, 0.05]]))
    found = equilibrium(bar, linear_springs([0.15], [0.0]), gravity=(-9.81, 0.0))
    theta = found.angles[0]
    assert 0.15 * theta == pytest.approx(-0.2 * 9.81 * 0.05 * np.cos(theta), abs=1e-12)


def test_weight_bends_the_finger_to_the_least_energy():
    chain = finger_with(6).segments
    rest, gravity = np.linspace(0.1, 0.4, 6), np.array([7.0, -3.0])
    stiffness = chain.stiffness[:, 1]

    def energy(angles):
        turned, point, total = 0.0, np.zeros(2), 0.0
        for i, angle in enumerate(angles):
            point = point + chain.offset[i, 2] * np.array([np.sin(turned), np.cos(turned)])
            turned += angle
            x, z = chain.body_center[i, 0], chain.body_center[i, 2]
            across = np.array([np.cos(turned), -np.sin(turned)])
            center = point + x * across + z * np.array([np.sin(turned), np.cos(turned)])
            total -= chain.mass[i] * gravity @ center
        return 1e3 * (total + 0.5 * np.sum(stiffness * (angles - rest) ** 2))

    least = minimize(energy, rest, tol=1e-14, options={"gtol": 1e-9})
    found = equilibrium(planar_finger(chain), linear_springs(stiffness, rest), gravity)
    assert found.angles == pytest.approx(least.x, abs=1e-6)


def test_stopped_bar_presses_with_its_moment_over_its_length():
    bar = PlanarFinger(np.array([0.05]), 0.05, np.array([0.0]), np.zeros((1, 2)))
    found = equilibrium(bar, linear_springs([0.02], [1.0]), stop=STRAIGHT)
    assert found.tip_force == pytest.approx(0.02 * 1.0 / 0.05)
    assert found.tip[0] == pytest.approx(0.0, abs=1e-12)


def test_stop_out_of_reach_does_nothing():
    bar = PlanarFinger(np.array([0.05]), 0.05, np.array([0.0]), np.zeros((1, 2)))
    assert equilibrium(bar, linear_springs([0.02], [0.5]), stop=Stop((-1, 0), -1.0)).tip_force == 0


def test_stopped_finger_does_no_work_when_the_stop_yields():
    """Virtual work: moving the stop by d changes the springs' energy by -force*d."""
    chain = finger_with(5)
    finger = planar_finger(chain.segments)
    stiffness, rest = chain.segments.stiffness[:, 1], chain.rest_rotation([31e3])[:, 1]

    def pressed(level):
        found = equilibrium(finger, linear_springs(stiffness, rest), stop=Stop((-1.0, 0.0), level))
        return found.tip_force, 0.5 * np.sum(stiffness * (found.angles - rest) ** 2)

    step = 1e-5
    force, _ = pressed(-0.01)
    work = (pressed(-0.01 + step)[1] - pressed(-0.01 - step)[1]) / (2 * step)
    assert force == pytest.approx(work, rel=1e-5)


def thesis_finger(wall=0.002):
    """Section 3.5.2: height, width and a quarter of the circumference fall as (1 - x/L)**(1/3)."""
    side = TaperedProfile(0.02, 0.09, 1.0, 3)
    around = TaperedProfile(0.08, 0.09, 1.0, 3)
    hull = ConstantProfile(wall)
    return Actuator("taper", 0.09, side, side, around, hull, hull, 67e3, 0.01, 80e3)


@pytest.mark.parametrize("pressure", [10e3, 30e3, 60e3])
def test_finger_of_linear_stiffness_stays_straight_when_its_tip_is_stopped(pressure):
    """A straight section carries h**2*z*p/2, which here falls linearly to the tip."""
    links = planar_finger(finger_with(9).segments)
    found = equilibrium(links, exact_springs(thesis_finger(), 9, pressure), stop=STRAIGHT)
    assert np.abs(found.angles).max() < 1e-9
    assert found.tip_force == pytest.approx(0.02**3 * pressure / 2 / 0.09)


def test_finger_by_the_rules_stays_straight_too():
    x = (np.arange(9) + 0.5) * 0.01
    stiffness = section.rule_stiffness(thesis_finger().circumference(x) / 4, 0.002, 67e3) / 0.01
    rest = 30e3 * section.rule_actuation_ratio(0.002, 67e3) * 0.01
    springs = linear_springs(stiffness, np.full(9, rest))
    found = equilibrium(planar_finger(finger_with(9).segments), springs, stop=STRAIGHT)
    assert np.abs(found.angles).max() < 1e-9
    assert found.tip_force == pytest.approx(0.02**3 * 30e3 / 4 / 0.09)


def test_exact_springs_rest_at_the_free_curvature():
    finger = load_actuator("P10.finger")
    links = planar_finger(finger_with(12).segments)
    found = equilibrium(links, exact_springs(finger, 12, 25e3))
    x = (np.arange(12) + 0.5) * 0.09 / 12
    assert found.angles == pytest.approx(finger.free_curvature(25e3, x) * 0.09 / 12, abs=1e-9)


def stopped_force(segments):
    chain = finger_with(segments)
    springs = linear_springs(chain.segments.stiffness[:, 1], chain.rest_rotation([31e3])[:, 1])
    return equilibrium(planar_finger(chain.segments), springs, stop=STRAIGHT).tip_force


def test_tip_force_hardly_depends_on_the_number_of_segments():
    forces = np.array([stopped_force(segments) for segments in (3, 5, 10, 20, 50)])
    assert np.abs(forces / forces[-1] - 1).max() < 3e-3


def test_tip_force_converges_at_second_order():
    coarse, middle, fine = (stopped_force(segments) for segments in (5, 10, 20))
    assert (coarse - middle) / (middle - fine) == pytest.approx(4.0, abs=0.5)


def test_chain_of_arcs_is_refused():
    palm = discretise(load_hand("rbo_hand_2").chain("palm"), 4, Model())
    with pytest.raises(ValueError, match="straight at rest"):
        planar_finger(palm.segments)
