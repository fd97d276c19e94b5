"""A moved rest stands for changed springs: checked by the moments that it gives."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from softhand_model.chain.chain import discretise, moved_rest
from softhand_model.effects import effect_classes
from softhand_model.hand.hand import load_hand
from softhand_model.hand.joint_stiffness import SpringModel
from softhand_model.model_file import Model

REST = np.array([[0.0, 0.5, 0.0], [0.1, 0.3, -0.1]])
ACTUAL = np.array([[0.2, 0.4, -0.1], [0.0, 0.6, 0.3]])


def away(rest, actual):
    return (Rotation.from_rotvec(rest).inv() * Rotation.from_rotvec(actual)).as_rotvec()


def test_coupled_springs_pull_sideways_when_twisted():
    factor = np.array([[1.0, 0.5, 1.0], [0.9, 0.9, 0.9]])
    coupling = np.array([[0.4, 0.4], [-0.3, -0.6]])
    pull = away(moved_rest(REST, ACTUAL, factor, coupling), ACTUAL)
    free = away(REST, ACTUAL)
    expected = factor * free
    expected[:, 0] += coupling[:, 0] * free[:, 2]
    expected[:, 2] += coupling[:, 1] * free[:, 0]
    assert pull == pytest.approx(expected, rel=1e-9)


def test_scaled_springs_about_one_axis_are_the_same_with_and_without_coupling():
    planar, bent = np.array([[0.0, 0.5, 0.0]]), np.array([[0.0, 0.8, 0.0]])
    factor = np.array([[1.0, 0.3, 1.0]])
    alone = moved_rest(planar, bent, factor, np.zeros((1, 2)))
    assert away(alone, bent)[0, 1] == pytest.approx(0.3 * 0.3)
    assert moved_rest(planar, bent, factor, np.full((1, 2), 1e-12)) == pytest.approx(
        alone, abs=1e-9
    )


def test_strut_is_left_alone():
    hand = load_hand("rbo_hand_2")
    chain = next(chain for chain in hand.chains if chain.strut is not None)
    coupled = effect_classes()["bend_twist_coupling"](k45=0.5)
    model = discretise(chain, 5, Model(effects=(coupled,)))
    actual = np.tile([0.1, 0.2, 0.05], (6, 1))
    moved = model.step(1e-3, [30e3] * len(chain.actuators), actual)
    free = discretise(chain, 5, Model()).rest_rotation([30e3] * len(chain.actuators))
    assert moved[0] == pytest.approx(free[0], abs=1e-9)
    assert np.abs(moved[1:] - free[1:]).max() > 0.01


def test_coupling_is_the_same_both_ways_where_twist_is_soft():
    """Off-diagonal k45*B in both rows, whatever the stiffness about x and z."""
    chain = load_hand("single_finger").chain("finger")
    coupled = effect_classes()["bend_twist_coupling"](k45=0.1)
    springs = SpringModel(lateral=0.8, twist="section")
    model = discretise(chain, 4, Model(effects=(coupled,), springs=springs))
    stiffness, small = model.segments.stiffness, 1e-4
    for axis, other in ((0, 2), (2, 0)):
        actual = np.zeros((4, 3))
        actual[:, axis] = small
        pull = stiffness * (actual - model.step(1e-3, [0.0], actual))
        assert pull[:, other] == pytest.approx(0.1 * stiffness[:, 1] * small, rel=1e-3)
        assert pull[:, axis] == pytest.approx(stiffness[:, axis] * small, rel=1e-3)
