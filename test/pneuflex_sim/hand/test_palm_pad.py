"""The palm sheet in the simulator: how far it sinks, what the wrist feels, snapshots."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.hand.wrist import WristParameters
from pneuflex_sim.scene.scenes import load_scene

STIFF = WristParameters(1e9, 1e7, 1e6, 1e5, 1e3, 10.0)
MASS, HALF_HEIGHT = 0.5, 0.014  # [kg], [m] of the block


@pytest.fixture
def block_on_the_sheet(simulate):
    """RBO Hand 1 with its palm upwards and a block of 0.5 kg on the crown of its sheet."""

    def make(step):
        scene = replace(
            load_scene("stand"),
            has_object=True,
            rigid_wrist=False,
            wrist_rpy=(0.0, -np.pi / 2, 0.0),
        )
        simulation = simulate(
            hand="rbo_hand_1",
            scene=scene,
            object="tape_dispenser",
            object_mass_scale=MASS / 0.030,
            step=step,
            wrist=STIFF,
        )
        sheet = simulation.hand.sheet
        crown = np.array(sheet.position) + [sheet.rise, 0.0, 0.0]
        # the wrist's x points up, its z along -x of the world
        place = np.array(scene.wrist_position) + [-crown[2], 0.0, crown[0] + HALF_HEIGHT]
        pybullet.resetBasePositionAndOrientation(
            simulation.engine.object_id,
            place.tolist(),
            [0, 0, 0, 1],
            physicsClientId=simulation.engine.world.client,
        )
        return simulation, place

    return make


@pytest.mark.parametrize("step", [0.001, 0.002, 0.005])
def test_half_a_kilogram_sinks_by_its_weight_over_the_stiffness(block_on_the_sheet, step):
    simulation, place = block_on_the_sheet(step)
    for _ in range(round(2.0 / step)):  # at 1 ms the block rattles for 1.75 s
        simulation.step()
    weight = MASS * 9.80665
    sunk = weight / simulation.hand.sheet.stiffness()
    assert simulation.bodies.pad.spring.state[0] == pytest.approx(sunk, rel=2e-3)
    assert simulation.object_pose()[0][2] - place[2] == pytest.approx(-sunk, abs=1e-3)
    assert simulation.wrist_wrench()[0][2] == pytest.approx(-weight, rel=5e-3)
    assert {contact.first for contact in simulation.object_contacts()} == {"palm_plate"}


def test_reset_and_snapshots_include_the_sheet(block_on_the_sheet):
    simulation, _ = block_on_the_sheet(0.005)
    for _ in range(40):
        simulation.step()
    saved, ends = simulation.save(), []
    for _ in range(2):
        simulation.restore(saved)
        for _ in range(40):
            simulation.step()
        ends.append(np.append(simulation.object_pose()[0], simulation.bodies.pad.spring.state))
    np.testing.assert_array_equal(ends[0], ends[1])
    assert simulation.bodies.pad.spring.state[0] > 1e-3
    simulation.reset()
    assert simulation.bodies.pad.spring.state.tolist() == [0.0, 0.0]


@pytest.mark.parametrize("step", [0.002, 0.005])
@pytest.mark.parametrize(("pitch", "lowest"), [(0.7854, "plate"), (1.5708, "sheet")])
def test_table_and_palm_bear_on_each_other_as_hard_as_the_arm_pushes(simulate, step, pitch, lowest):
    """The plate's edge, and the crown of the sheet, are driven 15 mm into the table at 1 kN/m."""
    simulation = simulate(hand="rbo_hand_1", object_offset=(0.6, 0.0), step=step)
    orientation = Rotation.from_euler("y", pitch).as_quat()
    for height in np.linspace(0.12, -0.015, round(1.5 / step)):
        simulation.command_wrist(np.array([0.0, 0.0, height]), orientation)
        simulation.step()
    for _ in range(round(1.0 / step)):
        simulation.step()
    sunk, force = simulation.bodies.pad.spring.state[0], simulation.wrist_wrench()[0][2]
    borne = sum(c.force for c in simulation.contacts() if c.first == "palm_plate")
    at = simulation.wrist_pose()[0][2]
    assert force == pytest.approx(min(20.0, 1000.0 * (at + 0.015)), rel=0.1)
    if lowest == "plate":
        plate = simulation.hand.plate
        corner = np.array([plate.position[0] + plate.size[0] / 2, 0.0, 0.0])
        assert at + Rotation.from_quat(orientation).apply(corner)[2] == pytest.approx(0, abs=2e-3)
        assert borne == pytest.approx(force, rel=0.05)
    else:
        assert sunk == pytest.approx(borne / simulation.hand.sheet.stiffness(), rel=0.02)
        assert borne > 0.5 * force  # fingers that lie on the table bear the rest
