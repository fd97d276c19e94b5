"""The compliant wrist against closed forms."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pneuflex_sim.hand.wrist import Wrist, WristParameters, advance_wrist

UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0])


def new_wrist(**parameters):
    return Wrist(WristParameters(**parameters), np.zeros(3), UPRIGHT.copy())


def advance(wrist, step, times):
    for _ in range(times):
        advance_wrist(step, wrist.arm, wrist.state)


def test_step_response_converges_to_the_critically_damped_closed_form():
    target, duration, errors = 0.01, 0.1, []
    for step in (1e-3, 5e-4):
        wrist = new_wrist()
        wrist.command([target, 0, 0], UPRIGHT)
        advance(wrist, step, round(duration / step))
        decay = np.sqrt(wrist.parameters.stiffness / wrist.parameters.mass) * duration
        errors.append(abs(wrist.position[0] - target * (1 - (1 + decay) * np.exp(-decay))))
    assert errors[0] < 0.02 * target
    assert errors[1] < 0.6 * errors[0]


def test_a_load_below_the_limit_deflects_the_wrist_by_load_over_stiffness():
    wrist = new_wrist()
    wrist.force[:] = [0, 0, 15.0]
    advance(wrist, 1e-3, 2000)
    assert wrist.position[2] == pytest.approx(15.0 / wrist.parameters.stiffness, rel=1e-6)


def test_a_load_above_the_limit_carries_the_wrist_away_with_what_is_left():
    wrist = new_wrist(force_limit=20.0)
    wrist.force[:] = [0, 26.0, 0]
    advance(wrist, 1e-3, 3000)
    speed = wrist.velocity[1]
    advance(wrist, 1e-3, 1)
    acceleration = (wrist.velocity[1] - speed) / 1e-3
    assert acceleration == pytest.approx((26.0 - 20.0) / wrist.parameters.mass, rel=1e-3)


def test_orientation_reaches_the_target_the_short_way():
    wrist = new_wrist()
    target = Rotation.from_euler("xyz", [0.4, -1.2, 2.0])
    wrist.command(np.zeros(3), -target.as_quat())
    advance(wrist, 1e-3, 3000)
    assert (Rotation.from_quat(wrist.orientation).inv() * target).magnitude() < 1e-6


@pytest.mark.parametrize(
    ("position", "orientation", "named"),
    [
        ([0, 0, np.nan], UPRIGHT, "position"),
        ([0, 0], UPRIGHT, "position"),
        ([0, 0, 0], [0, 0, 0, 0.5], "orientation"),
    ],
)
def test_an_unusable_target_is_refused_and_the_last_one_stands(position, orientation, named):
    wrist = new_wrist()
    with pytest.raises(ValueError, match=named):
        wrist.command(position, orientation)
    np.testing.assert_array_equal(wrist.state.target_position, np.zeros(3))


@pytest.mark.parametrize("place", [(0, 0, 2.1), (-1e308, 0, 0), (0, np.inf, 0)])
def test_a_target_outside_of_the_workspace_is_refused(place):
    wrist = new_wrist()
    with pytest.raises(ValueError, match="position: expected"):
        wrist.command(place, UPRIGHT)
    wrist.command((2.0, -2.0, 2.0), UPRIGHT)


def test_parameters_must_be_positive():
    with pytest.raises(ValueError, match="force_limit: expected a positive number, got 0"):
        WristParameters(force_limit=0)
