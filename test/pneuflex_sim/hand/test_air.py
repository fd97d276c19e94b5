"""Volumes, rest shape and gas stiffness of a hand against its chains and differences."""

import numpy as np
import pytest

from pneuflex_sim.hand.air import act_on_joints
from softhand_model.dynamics.joint_springs import Actuation

PRESSURES = np.array([21e3, 35e3, 12e3, 61e3])


@pytest.fixture
def coupling(simulate):
    return simulate(step=0.01).air


def test_rest_shape_of_the_hand_is_that_of_its_chains(coupling):
    rotations = np.zeros_like(coupling.layout.offset)
    bend = coupling.rest_bend(0.001, PRESSURES, rotations, 293.15)
    for chain in coupling.layout.description.chains:
        channels = [coupling.layout.description.channel_of(name) for name in chain.actuators]
        own = coupling.layout.models[chain.name].rest_rotation(PRESSURES[channels])
        np.testing.assert_allclose(bend[coupling.layout.chain_joints[chain.name]], own, rtol=1e-12)


def test_suction_and_high_pressure_stay_finite_and_monotone(coupling):
    rotations = np.zeros_like(coupling.layout.offset)
    bends = [
        coupling.rest_bend(0.001, np.full(4, p), rotations, 293.15)[:, 1].sum()
        for p in (-5e3, 0.0, 50e3, 500e3, 5e6)
    ]
    assert bends[0] == bends[1] == 0
    assert np.all(np.diff(bends[1:]) > 0)


def test_gas_stiffness_is_the_torque_per_common_bend_at_constant_mass(coupling):
    """Bend all joints of a channel alike, compress its air isothermally, difference the torque."""
    layout, small = coupling.layout, 1e-5
    joints = np.arange(len(layout.mass))
    index = joints[layout.chain_joints["index"]][1:]  # channel b feeds the index alone
    rotations = np.zeros_like(layout.offset)
    volumes, ambient = coupling.volumes(rotations), 101.3e3
    actuation = Actuation(np.zeros_like(rotations), np.zeros_like(rotations))
    drop = (PRESSURES + ambient) / volumes * coupling.total_gain
    act_on_joints(PRESSURES, drop, False, coupling.tables, layout.stiffness, actuation)
    stiffness = actuation.gas
    rotations[index, 1] += small
    raised = (PRESSURES + ambient) * volumes / coupling.volumes(rotations) - ambient
    rest = [coupling.rest_bend(0.001, p, rotations, 293.15)[:, 1] for p in (PRESSURES, raised)]
    torque = -layout.stiffness[:, 1] * (rest[1] - rest[0]) / small
    np.testing.assert_allclose(stiffness[index, 1], torque[index], rtol=1e-3)
    assert (stiffness[index, 1] > 0.3 * layout.stiffness[index, 1]).all()


def test_chambers_bent_the_wrong_way_keep_a_fifth_of_their_air(coupling):
    rotations = np.zeros_like(coupling.layout.offset)
    rotations[:, 1] = -3.0
    volumes = coupling.volumes(rotations)
    np.testing.assert_allclose(volumes, 0.2 * coupling.rest_volumes, rtol=1e-12)


def test_imposed_masses_and_pressures_meet_the_gas_law(coupling):
    rotations = np.zeros_like(coupling.layout.offset)
    rotations[:, 1] = 0.2
    masses, ambient = np.array([3e-5, 1e-5, 2e-5, 0.0]), 101.3e3
    pressures, volumes = coupling.enclosed_air(masses, ambient, 293.15, rotations)
    content = pressures * volumes / (287.05 * 293.15)
    at_rest = ambient * coupling.rest_volumes / (287.05 * 293.15)
    np.testing.assert_allclose(content - at_rest, masses, atol=1e-15)
    assert (volumes > coupling.rest_volumes).all()
