"""The whole hand: determinism, snapshots, fast pressure steps, loads, names and refusals."""

import warnings

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.engines import ENGINES, PYBULLET, pybullet_engine
from pneuflex_sim.hand import bodies as hand_bodies
from pneuflex_sim.hand.collision import SKIN_TWIST
from pneuflex_sim.simulation import Simulation, SimulationConfig
from pneuflex_sim.world import Diverged
from softhand_model.effects import effect_classes
from softhand_model.model_file import Model

POSE = np.array([-0.057, 0.0, 0.146]), np.array([0.0, 0.92388, 0.0, 0.38268])
LARGEST_FRICTION = 0.6  # of rubber with the cylinder's cardboard [-]
MASSES = np.array([7.1e-5, 2.4e-5, 5.3e-5, 4.3e-5])


def close_on_object(simulation, duration=1.2):
    """Go down to the object and close the hand on it within 0.5 s."""
    simulation.command_wrist(*POSE)
    for _ in range(round(duration / simulation.step_size)):
        simulation.set_air_masses(MASSES * np.clip((simulation.time - 0.6) / 0.5, 0, 1))
        simulation.step()


def fingerprint(simulation):
    return np.concatenate(
        [simulation.bodies.q.ravel(), *simulation.object_pose(), simulation.read_sensors()]
    )


def test_two_worlds_in_one_process_run_alike_bit_for_bit(simulate):
    first, second = simulate(step=0.005), simulate(step=0.005)
    for simulation in (first, second):
        close_on_object(simulation)
    np.testing.assert_array_equal(fingerprint(first), fingerprint(second))


def test_a_reset_world_repeats_itself_bit_for_bit(simulate):
    simulation = simulate(step=0.005)
    close_on_object(simulation)
    before = fingerprint(simulation)
    simulation.reset()
    assert simulation.time == 0
    close_on_object(simulation)
    np.testing.assert_array_equal(fingerprint(simulation), before)


def test_reset_lets_the_air_out(simulate):
    simulation = simulate(step=0.002)
    for _ in range(300):
        simulation.step([1, 1, 1, 1])
    assert simulation.pressures().min() > 5e3
    simulation.reset()
    for _ in range(50):
        simulation.step([0, 0, 0, 0])
    fresh = simulate(step=0.002)
    for _ in range(50):
        fresh.step([0, 0, 0, 0])
    np.testing.assert_allclose(fingerprint(simulation), fingerprint(fresh), atol=1e-5)


def test_a_restored_snapshot_repeats_the_run_bit_for_bit(simulate):
    simulation = simulate(step=0.005)
    close_on_object(simulation, 0.9)
    saved, ends = simulation.save(), []
    for _ in range(2):
        simulation.restore(saved)
        close_on_object(simulation, 0.5)
        ends.append(fingerprint(simulation))
    np.testing.assert_array_equal(ends[0], ends[1])


def test_states_of_snapshots_that_nobody_holds_are_freed(simulate):
    simulation, ids = simulate(hand="single_finger", scene="stand", step=0.002), set()
    for _ in range(300):
        ids.add(simulation.save()["engine"][0]._id)
    assert len(ids) == 1  # PyBullet gives a freed id again


@pytest.mark.parametrize("step", [0.001, 0.002, 0.005, 0.01])
def test_fast_pressure_steps_stay_finite(simulate, hold_pressure, step):
    simulation = simulate(hand="single_finger", scene="stand", step=step)
    draw = np.random.default_rng(8)
    for _ in range(12):
        ramp, level = draw.uniform(0.005, 0.1), draw.uniform(0, 60e3)
        hold_pressure(simulation, [level], 0.15, ramp)
    hold_pressure(simulation, [0.0], 3.0)
    assert abs(simulation.bodies.v).max() < 0.05
    assert abs(simulation.tip_angles()["finger"]) < 0.02


@pytest.mark.parametrize("step", [0.002, 0.005])
def test_thumb_and_fingers_that_clash_in_free_air_come_to_rest(simulate, mass_for_pressure, step):
    simulation = simulate(step=step)
    for duration, pressure in ((0.05, 100e3), (0.3, 100e3), (0.05, 0.0), (2.5, 0.0)):
        masses = mass_for_pressure(simulation, np.full(4, pressure))
        begin, start = simulation.time, simulation.air_masses()
        while simulation.time < begin + duration:
            share = min(1.0, (simulation.time - begin) / 0.05)
            simulation.set_air_masses(start + share * (masses - start))
            simulation.step()
    assert abs(simulation.bodies.v).max() < 0.3
    assert max(abs(angle) for angle in simulation.tip_angles().values()) < 0.15


def test_a_run_that_is_no_number_stops_with_an_error_that_names_the_joint(simulate):
    simulation = simulate(hand="single_finger", scene="stand", step=0.002)
    simulation.bodies.layout.stiffness[3] = np.nan
    with pytest.raises(Diverged, match="diverged: joint finger_"):
        simulation.step()


def test_a_run_that_diverged_begins_anew_after_a_reset_as_if_nothing_had_been(simulate):
    diverged, other = simulate(step=0.002), simulate(step=0.002)
    diverged.wrist.state.target_position[0] = 1e308
    with pytest.raises(Diverged):
        diverged.step()
    for simulation in (diverged, other):
        simulation.reset()
        for _ in range(100):
            simulation.step(np.array([1, 0, 1, 0]))
    np.testing.assert_array_equal(diverged.bodies.q, other.bodies.q)
    np.testing.assert_array_equal(diverged.object_pose()[0], other.object_pose()[0])


def test_an_object_that_was_no_number_lies_on_the_table_again_after_a_reset(simulate):
    simulation = simulate(step=0.002)
    client, nowhere = simulation.engine.world.client, [float("nan")] * 3
    pybullet.resetBaseVelocity(
        simulation.engine.object_id, nowhere, nowhere, physicsClientId=client
    )
    simulation.step()
    with pytest.raises(Diverged):
        simulation.object_pose()
    simulation.reset()
    for _ in range(200):
        simulation.step()
    assert simulation.object_pose()[0][2] == pytest.approx(0.0325, abs=1e-3)


def test_a_joint_may_be_too_fast_for_a_tenth_of_a_second(simulate, monkeypatch):
    simulation = simulate(hand="single_finger", scene="stand", step=0.002)
    monkeypatch.setattr(hand_bodies, "SPEED_LIMIT", 0.0)
    with pytest.raises(Diverged, match="diverged: joint finger_.* for 10[0-9] ms"):
        for _ in range(100):
            simulation.step()
    assert simulation.time == pytest.approx(0.1, abs=0.005)


def test_the_wrist_carries_the_object_but_not_the_hand(simulate):
    simulation = simulate(step=0.002)
    for _ in range(500):
        simulation.step()
    np.testing.assert_allclose(simulation.wrist_wrench()[0], 0, atol=0.02)
    simulation.reset()
    close_on_object(simulation, 1.6)
    place, turn = simulation.wrist_pose()
    simulation.command_wrist(place + [0, 0, 0.1], turn)
    for _ in range(1500):
        simulation.step()
    assert "table" not in {contact.first for contact in simulation.object_contacts()}
    weight = simulation.object_mass * 9.80665
    np.testing.assert_allclose(simulation.wrist_wrench()[0], [0, 0, -weight], atol=0.03 * weight)


def test_every_joint_of_a_grasp_is_in_balance(simulate):
    """Spring torque = moment of the contact forces and weights beyond the joint, at every joint.
    The engine does not tell the moments by which patches resist twisting: there must be some along
    the normals, none larger than a patch has, that explain what is left at all joints of a chain.
    """
    simulation = simulate(step=0.002)
    close_on_object(simulation, 6.0)
    bodies, layout = simulation.bodies, simulation.bodies.layout
    for body, base in zip(layout.bodies, bodies.ids, strict=True):
        links = range(body.joints.stop - body.joints.start)
        state = pybullet.getLinkStates(
            base,
            list(links),
            computeForwardKinematics=1,
            physicsClientId=simulation.engine.world.client,
        )
        moment, patches = np.zeros((len(links), 3)), []
        for link in links:
            weight = np.array([0, 0, -9.80665 * layout.mass[body.joints][link]])
            contacts = list(contact_forces(simulation, base, link))
            forces = [(np.array(state[link][0]), weight), *(found[:2] for found in contacts)]
            for point, force in forces:
                for joint in range(link + 1):
                    moment[joint] += np.cross(point - np.array(state[joint][4]), force)
            for _, _, normal, pressing in contacts:
                column = np.zeros((len(links), 3))
                column[: link + 1] = normal
                patches.append((column.ravel(), LARGEST_FRICTION * SKIN_TWIST * pressing))
        turns = [np.array(pybullet.getMatrixFromQuaternion(s[5])).reshape(3, 3) for s in state]
        torques = [turn @ own for turn, own in zip(turns, bodies.torque[body.joints], strict=True)]
        left = -(moment + torques).ravel()
        if patches:
            columns, ends = zip(*patches, strict=True)
            ends = np.array(ends) + 1e-9
            left = lsq_linear(np.array(columns).T, left, (-ends, ends)).fun
        np.testing.assert_allclose(left, 0.0, atol=1e-3)


def contact_forces(simulation, base, link):
    """Contacts of one link: point, force with normal and both friction directions, normal, and
    normal force.
    """
    points = pybullet.getContactPoints(
        bodyA=base, linkIndexA=link, physicsClientId=simulation.engine.world.client
    )
    for point in points:
        vectors = (np.array(point[7]), np.array(point[11]), np.array(point[13]))
        force = point[9] * vectors[0] + point[10] * vectors[1] + point[12] * vectors[2]
        yield np.array(point[5]), force, vectors[0], point[9]


@pytest.mark.parametrize(
    ("config", "named"),
    [
        ({"hand": "claw"}, "rbo_hand_1, rbo_hand_1_split, rbo_hand_2, single_finger"),
        ({"object": "brick"}, "object: expected one of cylinder"),
        ({"scene": "moon"}, "scene: expected one of table, stand"),
        ({"step": 0.06}, "step: expected 0.0001 to 0.05 s, got 0.06"),
        ({"object_offset": (float("nan"), 0.0)}, "object_offset: expected two or three finite"),
        ({"object_offset": (0.3,)}, "object_offset: expected two or three finite"),
        ({"segments": 0}, "segments: expected 1 or more, got 0"),
        ({"segments": 16}, "at most 30 joints in one body"),
        (
            {"model": Model(effects=(effect_classes()["clock_offset"](offset=0.1, drift=0.0),))},
            "model: effects: clock_offset: it parts two clocks of a recording",
        ),
    ],
)
def test_what_cannot_be_used_is_refused_with_what_is_there(config, named):
    with pytest.raises(ValueError, match=named):
        Simulation(SimulationConfig(**config))


@pytest.mark.parametrize("engine", ENGINES)
def test_an_object_put_back_where_it_lay_rests_as_in_a_new_simulation(engine):
    simulation = Simulation(SimulationConfig(step=0.002, engine=engine))
    start = simulation.save()

    def poses():
        simulation.restore(start)
        simulation.place_object((0.001, 0.003), 1.1)
        found = []
        for _ in range(50):
            simulation.step()
            found.append(np.concatenate(simulation.object_pose()))
        return np.array(found)

    first = poses()
    assert np.array_equal(poses(), first) and np.array_equal(poses(), first)
    simulation.close()


def test_a_step_at_which_a_hand_is_too_slow_is_told_once_and_not_for_a_finger_on_a_stand(simulate):
    pybullet_engine._warn_of_slow_motion.cache_clear()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulate(engine=PYBULLET, step=0.002)
        simulate(engine=PYBULLET, hand="single_finger", scene="stand", step=0.005)
        with pytest.raises(RuntimeWarning, match=r"step: expected at most 2 ms.*got 5 ms"):
            simulate(engine=PYBULLET, step=0.005)
    with pytest.warns(RuntimeWarning, match="step") as told:
        for _ in range(2):
            simulate(engine=PYBULLET, step=0.005)
    assert len(told) == 1
