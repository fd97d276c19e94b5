"""The hand in MuJoCo is the hand of the simulator: against the static solver, against the simulator
itself in free air, and in what its contacts have for friction.
"""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from bench.sim import mujoco_hand
from bench.sim.mujoco_hand import Settings, in_mujoco
from pneuflex_sim.scene.friction import load_friction
from pneuflex_sim.scene.scenes import load_scene
from pneuflex_sim.simulation import Simulation, SimulationConfig
from thesis.chapter_3_and_5.planar import equilibrium, linear_springs, planar_finger

CLOSED = np.array([7.1e-5, 2.4e-5, 5.3e-5, 4.3e-5])  # [kg], as the strategy closes the hand


def fill(simulation, masses, duration):
    """Fill the channels in half the duration [s] and wait."""
    steps = round(duration / simulation.step_size)
    for k in range(steps):
        simulation.set_air_masses(masses * min(1.0, 2.0 * k / steps))
        simulation.step()


@pytest.mark.parametrize("step", [0.001, 0.005])
@pytest.mark.parametrize("integrator", ["discrete", "implicitfast"])
def test_a_level_finger_sags_as_the_static_solver_says(integrator, step):
    level = replace(load_scene("stand"), wrist_rpy=(0.0, np.pi / 2, 0.0))
    config = SimulationConfig(hand="single_finger", scene=level, step=step)
    simulation = in_mujoco(config, Settings(integrator))
    fill(simulation, np.array([6e-6]), 3.0)
    model = simulation.bodies.layout.models["finger"]
    rest = model.rest_rotation(simulation.pressures())[:, 1]
    springs = linear_springs(model.segments.stiffness[:, 1], rest)
    expected = equilibrium(planar_finger(model.segments), springs, gravity=(9.80665, 0.0))
    assert expected.angles.sum() > rest.sum() + 0.02  # the weight shows
    assert simulation.tip_angles()["finger"] == pytest.approx(expected.angles.sum(), rel=1e-6)


def test_the_hand_closes_in_free_air_as_in_the_simulator():
    config = SimulationConfig(scene="stand", step=0.005, engine="pybullet")
    ours, other = Simulation(config), in_mujoco(config)
    try:
        for simulation in (ours, other):
            fill(simulation, CLOSED, 3.0)
        np.testing.assert_allclose(other.pressures(), ours.pressures(), rtol=1e-4)
        theirs = other.fingertips()
        for name, (place, _) in ours.fingertips().items():
            assert np.linalg.norm(theirs[name][0] - place) < 1e-4
            assert other.tip_angles()[name] == pytest.approx(ours.tip_angles()[name], rel=1e-3)
    finally:
        ours.close()


def test_bodies_weigh_and_rub_as_in_the_simulator():
    simulation = in_mujoco(mujoco_hand.configuration(0, 0.005))
    model, data, friction = simulation.engine.model, simulation.engine.data, load_friction()
    masses = [model.body(name).mass[0] for name in simulation.bodies.layout.names]
    np.testing.assert_allclose(masses, simulation.bodies.layout.mass)
    for name in ("index_3", "thumb_4", "palm_plate"):  # each onto the object
        pair = model.geom(name).id, model.geom("object_0").id
        assert _friction_of(model, data, pair) == friction.pair("rubber", "cardboard")
    pair = model.geom("table").id, model.geom("object_0").id
    assert _friction_of(model, data, pair) == friction.pair("wood", "cardboard")


def _friction_of(model, data, pair):
    """Coefficient of the contact of two geoms, after the object was put where they touch."""
    start = model.joint("object").qposadr[0]
    before = data.qpos.copy()
    if model.geom("table").id not in pair:
        data.qpos[start : start + 3] = data.geom_xpos[pair[0]]
    mujoco.mj_forward(model, data)
    found = [
        contact.friction[0]
        for contact in data.contact
        if {contact.geom1, contact.geom2} == set(pair)
    ]
    data.qpos[:] = before
    mujoco.mj_forward(model, data)
    return found[0]


def test_the_wrist_reaches_its_goal_and_carries_the_hand_as_the_simulators():
    config = SimulationConfig(step=0.005, object_offset=(1.0, 0.0), engine="pybullet")
    ours, other = Simulation(config), in_mujoco(config)
    goal = np.array([0.03, -0.02, 0.30]), np.array([0.0, np.sin(1.3), 0.0, np.cos(1.3)])
    try:
        for simulation in (ours, other):
            simulation.command_wrist(*goal)
            fill(simulation, 0.0 * CLOSED, 2.0)
        for mine, its in zip(ours.wrist_pose(), other.wrist_pose(), strict=True):
            np.testing.assert_allclose(its, mine, atol=2e-3)
    finally:
        ours.close()


def test_mujoco_holds_the_object_and_is_timed():
    run = mujoco_hand.grasp("MuJoCo, discrete, elliptic", 0, 0.01)
    assert run.result.gripped and run.result.lift_height > 0.1
    assert run.points > 5
    assert len(run.times.whole) == pytest.approx(run.result.duration / 0.01, abs=1)
    assert 0.5 < run.times.share() < 1.0


def grasps(factor, gripped):
    """One grasp of a real-time factor at 1 ms, as the bench sees it."""

    class Times:
        def factor(self, step):
            return factor

    class Result:
        def __init__(self):
            self.gripped = gripped

    return [mujoco_hand.Grasp(Times(), 1, Result())]


def test_the_fastest_mujoco_that_holds_is_compared():
    engines = list(mujoco_hand.MUJOCO)
    runs = {mujoco_hand.OURS: grasps(2.0, True)} | {e: grasps(4.0, True) for e in engines}
    runs[engines[0]] = grasps(100.0, False)
    runs[engines[1]] = grasps(5.0, True)
    row = mujoco_hand._compared(runs, 0.001)[0]
    assert (row["value"], row["met"]) == (0.4, True)
    runs[mujoco_hand.OURS] = grasps(2.0, False)
    assert mujoco_hand._compared(runs, 0.001) == []
