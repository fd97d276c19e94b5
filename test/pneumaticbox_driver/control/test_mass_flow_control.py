"""Control of the mass flow on the bench: the rate on the mean, and nothing caught up after it."""

import numpy as np
import pytest
from bottle_rig import BottleRig

from pneumaticbox_driver.box.commands import TrajectoryPoint

MG = 1e-6
FINGER = {"volume": 60e-6, "compliance": 0.8}


def flowing(*flows, **options):
    rig = BottleRig(channels=len(flows), mode="mass_flow", **{**FINGER, **options}).started()
    ask(rig, *flows)
    return rig


def ask(rig, *flows):
    rig.box.command(rig.names, [TrajectoryPoint(0.0, velocities=flows)], 0.0, rig.box.time)


@pytest.mark.parametrize("flow", [5 * MG, 12 * MG])
def test_the_true_mass_grows_and_falls_at_the_wanted_rate(flow):
    rig = flowing(flow, flow, volume=0.2e-3)
    rig.run(1.0, 4e-3)
    before, start = rig.mass.copy(), rig.plant.time
    rig.run(5.0, 4e-3)
    risen = (rig.mass - before) / (rig.plant.time - start)
    np.testing.assert_allclose(risen, flow, rtol=0.04, atol=rig.smallest_pulses().max() / 5.0)
    ask(rig, -flow, -flow)
    rig.run(0.5, 4e-3)
    before, start = rig.mass.copy(), rig.plant.time
    rig.run(3.0, 4e-3)
    fallen = (before - rig.mass) / (rig.plant.time - start)
    np.testing.assert_allclose(fallen, flow, rtol=0.04, atol=rig.smallest_pulses().max() / 3.0)


def test_a_flow_of_zero_holds_the_mass_without_a_pulse():
    rig = flowing(8 * MG, 8 * MG)
    rig.run(2.0, 4e-3)
    ask(rig, 0.0, 0.0)
    rig.run(0.3, 4e-3)
    rig.openings[:] = 0
    mass = rig.mass.copy()
    rig.run(3.0, 4e-3)
    assert not rig.openings.any()
    np.testing.assert_allclose(rig.mass, mass, atol=0.01 * MG)


def test_a_flow_beyond_the_valve_is_not_caught_up_afterwards():
    rig = flowing(80 * MG, 4 * MG, volume=0.5e-3, compliance=0.0)
    rig.run(2.0, 4e-3)
    ask(rig, 0.0, 0.0)
    rig.run(0.1, 4e-3)
    mass = rig.mass[0]
    rig.run(3.0, 4e-3)
    assert rig.mass[0] - mass < 3.5 * rig.smallest_pulses()[0]


def test_a_flow_outwards_ends_in_an_empty_channel_with_closed_valves():
    rig = flowing(8 * MG, 8 * MG)
    rig.run(2.0, 4e-3)
    ask(rig, -8 * MG, 8 * MG)
    rig.run(5.0, 4e-3)
    assert rig.mass[0] == pytest.approx(0.0, abs=0.05 * MG)
    assert rig.box.zeroing.empty[0] and rig.box.valves[0] == 0


def test_few_pulses_make_a_slow_flow():
    rig = flowing(1 * MG, 1 * MG)
    rig.run(10.0, 4e-3)
    assert (rig.openings <= 22).all()
    np.testing.assert_allclose(rig.mass, 10 * MG, rtol=0.2)
