"""The march to the tip against one with scipy's rotations and closed forms, and against beams."""

import numpy as np
import pytest
from scipy.optimize import root
from scipy.spatial.transform import Rotation

from softhand_model.chain.chain import discretise
from softhand_model.equilibrium.chain_march import (
    CHANGES,
    POSITION_CHANGE,
    SPIN,
    march,
    straight_links,
)
from softhand_model.equilibrium.joint_springs import JointSprings
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import Model

JOINTS = 4
CHAIN = discretise(load_hand("single_finger").chain("finger"), JOINTS, Model()).segments
REST = np.array([0.5, 0.1, -0.3, 0.4])
WRENCH = np.array([0.05, -0.04, 0.1, 6e-3, -9e-3, 4e-3])
GRAVITY = np.array([3.0, 4.0, -8.0])
KINDS = {
    "isotropic": {},
    "sideways": {"sideways": np.tile([1.6, 0.7], (JOINTS, 1))},
    "coupled": {"coupling": np.array([0.3])},
    "slack": {"factor": lambda bend, rest, points: np.where(bend < rest, 0.5, 1.0)},
}


def marched(kind, wrench, gravity, change=None):
    springs = JointSprings(CHAIN.stiffness[:, 1:2], REST[:, None], np.arange(1), **KINDS[kind])
    room = np.empty(CHANGES) if change is None else change
    return march(
        straight_links(CHAIN),
        springs.arrays(),
        gravity[:, None],
        True,
        0,
        wrench,
        room,
        change is not None,
    )


def turned_by(kind, stiffness, moment):
    """Rotation vector e with K*e = J(e)^T m, J^T in closed form."""
    lateral, twist = (1.6, 0.7) if kind == "sideways" else (1.0, 1.0)
    coupling = 0.3 if kind == "coupled" else 0.0

    def missing(turn):
        angle = np.linalg.norm(turn)
        axis = turn / angle
        sine = np.sin(angle) / angle
        pulled = sine * moment + (1 - sine) * (axis @ moment) * axis
        pulled -= (1 - np.cos(angle)) / angle * np.cross(axis, moment)
        below = 0.5 if kind == "slack" and turn[1] < 0 else 1.0
        elastic = np.array(
            [
                lateral * turn[0] + coupling * turn[2],
                below * turn[1],
                twist * turn[2] + coupling * turn[0],
            ]
        )
        return elastic - pulled / stiffness

    return root(missing, moment / stiffness, tol=1e-13).x


def walked(kind, wrench, gravity):
    force, moment, place, turn = wrench[:3], wrench[3:], np.zeros(3), Rotation.identity()
    for joint in range(JOINTS):
        place = place + turn.apply(CHAIN.offset[joint])
        rest = turn * Rotation.from_rotvec([0.0, REST[joint], 0.0])
        local = rest.inv().apply(moment - np.cross(place, force))
        turn = rest * Rotation.from_rotvec(turned_by(kind, CHAIN.stiffness[joint, 1], local))
        weight = CHAIN.mass[joint] * gravity
        moment = moment - np.cross(place + turn.apply(CHAIN.body_center[joint]), weight)
        force = force - weight
    return place + turn.apply(CHAIN.tip_offset), turn.as_matrix(), force


@pytest.mark.parametrize("kind", KINDS)
def test_the_tip_comes_to_where_joint_after_joint_leads(kind):
    found, expected = marched(kind, WRENCH, GRAVITY), walked(kind, WRENCH, GRAVITY)
    assert np.abs(expected[1] - np.eye(3)).max() > 0.3
    for part, wanted in zip(found, expected, strict=True):
        assert np.array(part) == pytest.approx(np.array(wanted), abs=1e-9)


def test_its_derivatives_are_those_of_differences():
    change = np.empty(CHANGES)
    marched("isotropic", WRENCH, GRAVITY, change)
    for by, unit in enumerate(np.eye(6)):
        step = 1e-5 * unit
        more, less = (marched("isotropic", WRENCH + s * step, GRAVITY) for s in (1, -1))
        shift = np.subtract(more[0], less[0]) / 2e-5
        spin = Rotation.from_matrix(np.array(more[1]) @ np.transpose(less[1])).as_rotvec() / 2e-5
        assert change[POSITION_CHANGE, by] == pytest.approx(shift, rel=1e-6, abs=1e-7)
        assert change[SPIN, by] == pytest.approx(spin, rel=1e-6, abs=1e-5)
