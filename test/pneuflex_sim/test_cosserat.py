"""The finger of the simulator, and its static chains, against rods without segments."""

import cosserat
import numpy as np
import pytest
from cosserat import Rod, rod_of
from scipy.spatial.transform import Rotation

from softhand_model.hand.actuator import load_actuator
from thesis.chapter_3_and_5.planar import equilibrium, linear_springs, planar_finger
from thesis.chapter_3_and_5.stand import FingerStand
from thesis.chapter_3_and_5.static_finger import blocked_finger, chain_of

FINGER = load_actuator("P10.finger")
LEVEL = (9.80665, 0.0)  # gravity [m/s2] on a finger that lies level and bends downwards
GAP = 0.015  # [m] to the plane that blocks the tip


def uniform(stiffness, curvature, mass=0.0):
    return Rod(
        0.1,
        lambda x: np.full_like(x, stiffness),
        lambda x: np.full_like(x, curvature),
        lambda x: np.full_like(x, mass),
    )


def static(segments, pressure, gravity=(0.0, 0.0)):
    """The static chain, free, as the simulator has it."""
    model = chain_of(FINGER, segments)
    rest = model.rest_rotation([pressure])[:, 1]
    springs = linear_springs(model.segments.stiffness[:, 1], rest)
    return equilibrium(planar_finger(model.segments), springs, gravity)


def distance(one, other):
    """Distance over the length of the finger."""
    return np.linalg.norm(np.subtract(one, other)) / FINGER.length


# ---------------------------------------------------------------- the rod against closed forms
def test_free_rod_bends_to_an_arc():
    found = cosserat.free(uniform(2e-3, 15.0))
    assert found.tip_angle == pytest.approx(1.5, rel=2e-5)  # the stub at the tip is straight
    assert found.tip == pytest.approx([(1 - np.cos(1.5)) / 15, np.sin(1.5) / 15], abs=1e-6)


def test_stiff_rod_sags_as_a_beam():
    found = cosserat.free(uniform(2.0, 0.0, mass=0.1), LEVEL)
    assert found.tip_angle == pytest.approx(0.1 * 9.80665 * 0.1**3 / 6 / 2.0, rel=1e-4)
    assert found.tip[0] == pytest.approx(0.1 * 9.80665 * 0.1**4 / 8 / 2.0, rel=1e-4)


def test_blocked_rod_presses_as_a_propped_beam():
    found = cosserat.blocked(uniform(2.0, 0.01), 0.0)
    assert found.tip_force == pytest.approx(1.5 * 2.0 * 0.01 / 0.1, rel=1e-4)


def test_held_arc_resists_a_small_motion_of_its_tip_as_the_compliance_of_an_arc_says():
    """u = int (m + r x F) x r ds/B and phi = int (m + r x F) ds/B, r from section to tip."""
    bend, stiffness = 15.0, 2.0
    s, weight = (0.05 * part for part in np.polynomial.legendre.leggauss(40))
    s = s + 0.05
    arm = arc(bend, 0.1) - np.array([arc(bend, one) for one in s])
    compliance = np.zeros((6, 6))
    for column, load in enumerate(np.eye(6)):
        moment = load[3:] + np.cross(arm, load[:3])
        shift = weight @ np.cross(moment, arm)
        compliance[:, column] = np.concatenate([shift, weight @ moment]) / stiffness
    motion = 1e-4 * np.array([0.02, 0.03, -0.01, 0.3, -0.2, 0.4])
    load = np.linalg.solve(compliance, motion)
    turn = Rotation.from_rotvec(motion[3:]) * Rotation.from_rotvec([0.0, bend * 0.1, 0.0])
    found = cosserat.held(uniform(stiffness, bend), 0.1, [(arc(bend, 0.1) + motion[:3], turn)])
    assert found.force == pytest.approx(load[:3], rel=1e-3)
    torque = load[3:] + np.cross(arc(bend, 0.1), load[:3])
    assert found.torque == pytest.approx(torque, rel=1e-3)


def arc(bend, s):
    """Place at s on a circle of curvature `bend`."""
    return np.array([(1.0 - np.cos(bend * s)) / bend, 0.0, np.sin(bend * s) / bend])


# ---------------------------------------------------------------- chains against the rod
def test_level_finger_of_ten_segments_sags_as_the_rod():
    rod, chain = cosserat.free(rod_of(FINGER, 10e3), LEVEL), static(10, 10e3, LEVEL)
    light = cosserat.free(rod_of(FINGER, 10e3))
    assert distance(rod.tip, light.tip) > 0.02  # the weight shows
    assert chain.angles.sum() == pytest.approx(rod.tip_angle, rel=1e-3)
    assert distance(chain.tip, rod.tip) < 1e-3


def test_blocked_chain_comes_to_the_rod_at_second_order():
    rod = cosserat.blocked(rod_of(FINGER, 40e3), GAP)
    errors = [
        distance(blocked_finger(FINGER, segments, 40e3, GAP).tip, rod.tip)
        for segments in (5, 10, 20)
    ]
    assert np.divide(errors[:-1], errors[1:]) == pytest.approx([4.0, 4.0], abs=0.7)
    assert errors[1] < 1e-3


@pytest.mark.parametrize(("pressure", "limit"), [(42e3, 0.01), (65e3, 0.01), (76e3, 0.017)])
def test_free_tip_of_ten_segments_is_near_that_of_fifty(pressure, limit):
    """One percent holds to 66 kPa; 42 and 76 kPa are the largest on either side of a full turn, at
    56 kPa, where all tips come together.
    """
    assert 0.5 * limit < distance(static(10, pressure).tip, static(50, pressure).tip) < limit


def test_blocked_tip_of_ten_segments_is_where_that_of_fifty_is():
    coarse, fine = (blocked_finger(FINGER, segments, 60e3, GAP) for segments in (10, 50))
    assert distance(coarse.tip, fine.tip) < 0.01


# ---------------------------------------------------------------- the simulator against both
@pytest.mark.parametrize("pressure", [20e3, 42e3])
def test_simulated_finger_of_ten_segments_bends_freely_as_the_rod(pressure):
    with FingerStand(FINGER, 10) as stand:
        stand.settle(pressure)
        angle, tip = stand.bends().sum(), stand.line()[-1, [0, 2]]
    rod = cosserat.free(rod_of(FINGER, pressure))
    assert angle == pytest.approx(rod.tip_angle, rel=1e-4)
    assert distance(tip, rod.tip) < 0.01
    assert distance(tip, static(10, pressure).tip) < 1e-4


@pytest.mark.parametrize("pressure", [20e3, 60e3])
def test_simulated_finger_of_ten_segments_pushes_as_the_rod(pressure):
    with FingerStand(FINGER, 10) as stand:
        block = stand.block(GAP, 0.07)
        stand.settle(pressure)
        force, tip = stand.touch(block).force, stand.line()[-1, [0, 2]]
    rod = cosserat.blocked(rod_of(FINGER, pressure), GAP)
    chain = blocked_finger(FINGER, 10, pressure, GAP)
    assert force == pytest.approx(rod.tip_force, rel=0.01)
    assert force == pytest.approx(chain.tip_force, rel=1e-3)
    assert distance(tip, rod.tip) < 0.01
    assert distance(tip, chain.tip) < 1e-3
