"""Blows on a finger against closed forms, and what is said of them."""

from dataclasses import replace

import numpy as np
import pytest

from softhand_model.hand.actuator import load_actuator
from softhand_model.hand.hand import load_hand
from softhand_model.motion.pressed_body import SKIN_NORMAL
from thesis.chapter_3_and_5.stand import hand_of
from thesis.chapter_6 import principles
from thesis.chapter_6.blow import Finger, finger_of, strike

MASS, SPEED = 0.06, 0.2


def prism(segments):
    """P5, whose section is the same everywhere."""
    return finger_of(hand_of(load_actuator("P5")), 1.0, segments)


def point(mass, stiffness=0.0):
    """A mass on a massless lever of 1 m."""
    return Finger(np.array([[mass]]), np.array([stiffness]), np.zeros(1), np.ones(1))


def test_the_small_run_gives_finite_figures_a_verdict_and_a_picture(check_small_run):
    check_small_run("principles")


def test_a_locked_prism_has_a_third_of_its_mass_at_its_tip():
    assert prism(30).locked_mass == pytest.approx(load_actuator("P5").mass / 3.0, rel=0.03)


def test_a_prism_yields_as_a_cantilever():
    actuator = load_actuator("P5")
    due = 3.0 * float(actuator.stiffness(0.0)) / actuator.length**3
    assert prism(30).tip_stiffness == pytest.approx(due, rel=0.04)


def test_joints_that_give_way_lower_the_apparent_mass():
    finger = finger_of(load_hand("single_finger"), 0.9, 10)
    assert finger.apparent_mass < finger.locked_mass
    locked = replace(finger, inertia=finger.inertia[:1, :1], levers=finger.levers[:1])
    assert locked.apparent_mass == pytest.approx(finger.locked_mass)


@pytest.mark.parametrize("mass", [0.01, 0.06, 0.3])
def test_a_free_mass_takes_what_two_elastic_balls_exchange(mass):
    blow = strike(point(mass), MASS, SPEED)
    assert blow.ball[-1] == pytest.approx(SPEED * (MASS - mass) / (MASS + mass), abs=1e-6)
    assert blow.place[-1] == pytest.approx(SPEED * 2.0 * MASS / (MASS + mass), rel=1e-5)
    assert blow.balance < 1e-6


def test_a_wall_and_a_finger_that_reacts_too_late_take_the_force_of_a_spring():
    wall = SPEED * np.sqrt(SKIN_NORMAL * MASS)
    assert strike(point(1e6), MASS, SPEED).force.max() == pytest.approx(wall, rel=1e-3)
    late = strike(point(0.001), MASS, SPEED, delay=1.0)
    assert late.force.max() == pytest.approx(wall, rel=1e-3)
    assert late.ball[-1] == pytest.approx(-SPEED, rel=1e-3)
    assert strike(point(0.001), MASS, SPEED).force.max() < 0.3 * wall


def test_a_delay_costs_no_energy_and_raises_the_force():
    finger = finger_of(load_hand("single_finger"), 0.9, 5)
    blows = [strike(finger, MASS, SPEED, delay) for delay in (0.0, 0.002, 0.004)]
    forces = [blow.force.max() for blow in blows]
    assert forces == sorted(forces) and forces[-1] > 2.0 * forces[0]
    assert max(blow.balance for blow in blows) < 1e-6


def test_a_rigid_finger_called_soft_misses_the_targets(small):
    results, report = small("principles")
    swapped = {**results, principles.SOFT: results[principles.RIGID]}
    judged = {f.what: f.met for f in principles.report(swapped, principles.Parameters()).findings}
    assert judged["small force: soft over rigid"] is False
    assert judged["harmless collision: energy in the skin over the ball's, soft"] is False
    assert len(report.judged) == 8


def test_a_ball_without_mass_is_refused():
    with pytest.raises(ValueError, match="mass: expected a number above 0, got 0"):
        principles.Parameters(mass=0.0)
