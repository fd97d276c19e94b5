"""The spring that holds an object out to the hand: stiffness, weight, fading, snapshots."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pneuflex_sim.scene.object_spring import SPRING_STIFFNESS, SPRING_TURN_STIFFNESS, ObjectSpring
from pneuflex_sim.simulation import Simulation, SimulationConfig

PLACE, TURN = np.array([0.3, 0.05, 0.1]), Rotation.from_rotvec([0.4, -0.3, 0.2]).as_quat()


def held(name, step=0.005, **config):
    config |= {"object": name, "scene": "held", "step": step, "segments": 1}
    simulation = Simulation(SimulationConfig(**config))
    simulation.hold_object(PLACE, TURN)
    return simulation


def run(simulation, duration):
    for _ in range(round(duration / simulation.step_size)):
        simulation.step()


def off(simulation):
    """How far [m] and by what rotation vector [rad] the object is from where it is held."""
    wrist, turn = simulation.wrist_pose()
    position, orientation = simulation.object_pose()
    goal = Rotation.from_quat(turn) * Rotation.from_quat(TURN)
    place = wrist + Rotation.from_quat(turn).apply(PLACE)
    return position - place, (Rotation.from_quat(orientation) * goal.inv()).as_rotvec()


@pytest.mark.parametrize("name", ["pen", "bead", "ball_79", "scissors", "circular_plate"])
@pytest.mark.parametrize("step", [0.002, 0.01])
def test_light_and_heavy_objects_are_held_in_place_against_their_weight(name, step):
    simulation = held(name, step)
    run(simulation, 0.5)
    way, turn = off(simulation)
    assert np.abs(way).max() < 1e-4 and np.abs(turn).max() < 1e-3
    simulation.close()


@pytest.mark.parametrize("name", ["pen", "marker", "bead", "ball_79", "scissors"])
def test_so_they_are_in_mujoco(name):
    """At the usual step; the lighter the object, the sooner it left when its holder did not act."""
    pytest.importorskip("mujoco")
    simulation = held(name, 0.002, engine="mujoco")
    run(simulation, 0.5)
    way, turn = off(simulation)
    assert np.abs(way).max() < 1e-4 and np.abs(turn).max() < 1e-3
    simulation.place_object((0.0, 0.0), 1.3)
    simulation.hold_object(PLACE, TURN)
    run(simulation, 0.5)
    way, turn = off(simulation)
    assert np.abs(way).max() < 1e-4 and np.abs(turn).max() < 1e-3
    simulation.close()


def test_the_object_gives_way_to_forces_and_torques_as_the_spring_is_stiff():
    simulation = held("pen")
    body = simulation._body
    for _ in range(200):
        body.push(np.array([1.0, 0.0, -2.0]), np.array([0.0, 0.1, 0.0]))
        simulation.step()
    way, turn = off(simulation)
    assert way == pytest.approx(np.array([1.0, 0.0, -2.0]) / SPRING_STIFFNESS, abs=1e-4)
    assert turn == pytest.approx(np.array([0.0, 0.1, 0.0]) / SPRING_TURN_STIFFNESS, abs=2e-3)
    simulation.close()


def test_it_goes_with_the_wrist():
    simulation = held("ball_40")
    position, orientation = simulation.wrist_pose()
    turned = Rotation.from_rotvec([0.0, 0.5, 0.0]) * Rotation.from_quat(orientation)
    simulation.command_wrist(position + [0.05, 0.0, 0.0], turned.as_quat())
    run(simulation, 1.5)
    way, turn = off(simulation)
    assert np.abs(way).max() < 1e-3 and np.abs(turn).max() < 5e-3
    simulation.close()


def test_it_fades_and_then_the_object_falls_freely():
    simulation = held("ball_40")
    run(simulation, 0.2)
    simulation.release_object(0.4)
    run(simulation, 0.2)
    assert -0.01 < off(simulation)[0][2] < -1e-4
    run(simulation, 0.3)
    before = simulation._body.velocity()[0]
    run(simulation, 0.1)
    fell = simulation._body.velocity()[0] - before
    assert fell == pytest.approx([0.0, 0.0, -0.981], abs=0.01)
    simulation.close()


def test_strength_falls_in_a_straight_line():
    spring = ObjectSpring((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    assert spring.strength(1e9) == 1.0
    fading = spring.fading(2.0, 0.5)
    shares = [fading.strength(now) for now in (1.9, 2.0, 2.125, 2.25, 2.5, 9.0)]
    assert shares == pytest.approx([1.0, 1.0, 0.75, 0.5, 0.0, 0.0])
    assert spring.fading(2.0, 0.0).strength(2.0) == 0.0


def test_a_snapshot_brings_the_spring_back_bit_for_bit():
    simulation = held("pen")
    run(simulation, 0.1)
    simulation.release_object(0.3)
    run(simulation, 0.1)
    saved, found = simulation.save(), []
    for _ in range(2):
        run(simulation, 0.3)
        found.append(np.concatenate(simulation.object_pose()))
        simulation.restore(saved)
    assert (found[0] == found[1]).all()
    simulation.reset()
    run(simulation, 0.2)
    assert simulation.object_pose()[0][2] < 0.0
    simulation.close()


@pytest.mark.parametrize(
    ("place", "turn"),
    [([0, 0], [0, 0, 0, 1]), ([0, 0, np.nan], [0, 0, 0, 1]), ([0, 0, 0], [0, 0, 0, 0])],
)
def test_a_pose_that_is_none_is_refused(place, turn):
    simulation = held("bead")
    with pytest.raises(ValueError, match="held object: expected"):
        simulation.hold_object(place, turn)
    simulation.close()


def test_a_sheet_and_a_scene_without_object_are_refused():
    for given in ({"object": "tissue", "scene": "held"}, {"scene": "stand"}):
        simulation = Simulation(SimulationConfig(segments=1, **given))
        with pytest.raises(ValueError, match=r"held object|object"):
            simulation.hold_object(PLACE, TURN)
        simulation.close()
