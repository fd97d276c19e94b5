"""Effects that only motion shows, in the simulator with both engines."""

from dataclasses import replace

import numpy as np
import pytest

from pneuflex_sim.scene.scenes import load_scene
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_model.effects.hand_motion import ChannelLag, JointDamping
from softhand_model.model_file import Model

STEP, LAG = 0.001, 0.03  # [s]


def simulated(engine, *effects):
    scene = replace(load_scene("stand"), wrist_rpy=(0.0, 0.0, 0.0))
    return Simulation(
        SimulationConfig("single_finger", scene=scene, model=Model(effects=effects), step=STEP,
                         engine=engine)
    )  # fmt: skip


def bends(simulation, pressures):
    """Bend [rad] of the finger after each step at gauge pressures (steps,) [Pa]."""
    found = []
    for pressure in pressures:
        rotations = simulation.bodies.rotations
        wanted = np.array([simulation.ambient + pressure])
        masses = simulation.air.masses(
            wanted, simulation.ambient, simulation.temperature, rotations
        )
        simulation.set_air_masses(masses)
        simulation.step()
        found.append(simulation.tip_angles()["finger"])
    return np.array(found)


@pytest.mark.parametrize("engine", ["pybullet", "mujoco"])
def test_actuators_of_a_lagging_channel_follow_its_pressure_late(engine):
    pytest.importorskip(engine)
    steps = np.arange(1, 121)
    given = np.full(len(steps), 15e3)
    late = 15e3 * (1.0 - np.exp(-steps * STEP / LAG))
    lagging = bends(simulated(engine, ChannelLag.at(channel="a")(time_constant=LAG)), given)
    expected, at_once = (bends(simulated(engine), course) for course in (late, given))
    assert np.abs(lagging - expected).max() < 0.01 * np.abs(lagging - at_once).max()


@pytest.mark.parametrize("engine", ["pybullet", "mujoco"])
def test_damped_joints_swing_less(engine):
    pytest.importorskip(engine)
    course = np.full(300, 12e3)
    over = {}
    for time in (0.001, 0.01, 0.04):
        bend = bends(simulated(engine, JointDamping(time=time)), course)
        over[time] = bend.max() / bend[-1] - 1.0
    assert over[0.001] > 1.5 * over[0.01]
    assert over[0.01] > over[0.04]


def test_a_snapshot_holds_the_lagging_pressure():
    simulation = simulated("pybullet", ChannelLag.at(channel="a")(time_constant=LAG))
    bends(simulation, np.full(20, 15e3))
    saved = simulation.save()
    first = bends(simulation, np.full(10, 15e3))
    simulation.restore(saved)
    assert np.array_equal(bends(simulation, np.full(10, 15e3)), first)
    simulation.close()
