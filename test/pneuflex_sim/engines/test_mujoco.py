"""The hand, object and scene in MuJoCo against closed forms and the static solver."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from grasp_strategies.in_process_scene import InProcessScene
from grasp_strategies.sequencer import Sequencer
from grasp_strategies.strategy import load_strategy
from pneuflex_sim.engines import MUJOCO
from pneuflex_sim.scene.friction import load_friction
from pneuflex_sim.scene.objects import load_object, load_objects
from pneuflex_sim.scene.scenes import SceneDescription, Table, load_scene
from pneuflex_sim.world import solver_settings
from thesis.chapter_3_and_5.planar import equilibrium, linear_springs, planar_finger

GRAVITY = 9.80665
SLOPE = load_friction().pair("wood", "polyolefin")
STEPS = [0.001, 0.002, 0.005, 0.01]


@pytest.fixture
def mujoco(simulate):
    """Make simulations of this engine."""
    return lambda **config: simulate(engine=MUJOCO, **config)


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("segments", [5, 15])
def test_a_level_finger_sags_as_the_static_solver_says(
    mujoco, hold_pressure, level_stand, step, segments
):
    simulation = mujoco(hand="single_finger", scene="stand", step=step, segments=segments)
    hold_pressure(simulation, [10e3], 4.0)
    model = simulation.bodies.layout.models["finger"]
    rest = model.rest_rotation([10e3])[:, 1]
    springs = linear_springs(model.segments.stiffness[:, 1], rest)
    balance = equilibrium(planar_finger(model.segments), springs, gravity=(GRAVITY, 0.0))
    expected = balance.angles.sum()
    assert abs(expected - rest.sum()) > 0.02  # the weight shows
    assert simulation.tip_angles()["finger"] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("step", [0.001, 0.01])
def test_the_thumbs_and_palms_joints_bend_as_their_rest_says(
    mujoco, hold_pressure, weightless, step
):
    simulation = mujoco(step=step, model=weightless, object="cylinder", object_offset=(0.0, 2.0))
    pressures = 20e3 * np.arange(1.0, 1.0 + len(simulation.channels))
    hold_pressure(simulation, pressures, 3.0)
    rest = simulation.air.rest_bend(step, pressures, simulation.bodies.rotations, 293.15)
    assert np.abs(rest).max() > 0.1
    assert simulation.bodies.rotations == pytest.approx(rest, abs=2e-3)


@pytest.mark.parametrize("step", STEPS)
def test_the_wrist_bears_what_is_held_and_not_the_hands_own_weight(mujoco, step):
    simulation = mujoco(step=step)
    for _ in range(round(2.0 / step)):
        simulation.step()
    free, about = (part.copy() for part in simulation.wrist_wrench())
    assert np.abs(free).max() < 0.02
    assert np.abs(about).max() < 0.02
    assert simulation.wrist_pose()[0] == pytest.approx(simulation.scene.wrist_position, abs=1e-4)


def test_the_table_bears_the_whole_limit_of_the_arms_force(mujoco, weightless):
    simulation = mujoco(step=0.002, model=weightless, object_offset=(0.0, 2.0))
    place, turn = (part.copy() for part in simulation.wrist_pose())
    simulation.command_wrist(place - [0.0, 0.0, 0.5], turn)
    for _ in range(2000):
        simulation.step()
    limit = simulation.config.wrist.force_limit
    assert np.linalg.norm(simulation.wrist_wrench()[0]) == pytest.approx(limit, rel=0.02)
    of_hand = [c for c in simulation.contacts() if "object" not in (c.first, c.second)]
    up = sum(c.force * abs(c.normal[2]) for c in of_hand if "table" in (c.first, c.second))
    assert up == pytest.approx(limit, rel=0.02)


@pytest.mark.parametrize("scale", [0.5, 1.0])
def test_an_object_falls_freely(mujoco, scale):
    simulation = mujoco(step=0.001, object="ball", object_offset=(0.0, 2.0, 0.5))
    simulation.place_object((0.0, 2.0, 0.5), scale)
    start = simulation.object_pose()[0][2]
    for _ in range(200):
        simulation.step()
    fallen = start - simulation.object_pose()[0][2]
    assert fallen == pytest.approx(0.5 * GRAVITY * 0.2 * 0.201, rel=1e-6)


@pytest.mark.parametrize("name", sorted(n for n, o in load_objects().items() if not o.compliance))
def test_every_object_rests_with_its_weight_on_the_table(mujoco, name):
    simulation = mujoco(step=0.002, object=name, object_offset=(0.0, 1.0), segments=2)
    forces = []
    for k in range(1500):
        simulation.step()
        if k >= 1000:
            forces.append(sum(contact.force for contact in simulation.object_contacts()))
    assert simulation.touching_object() == {"table"}
    weight = GRAVITY * simulation.object_mass
    assert np.mean(forces) == pytest.approx(weight, rel=0.02)


@pytest.mark.parametrize(("angle", "slides"), [(0.9, False), (1.1, True)])
def test_a_box_on_a_slope_slides_beyond_the_angle_of_friction(mujoco, angle, slides):
    simulation = mujoco(step=0.002, object="tape_dispenser", object_offset=(0.0, 1.0), segments=2)
    start = simulation.object_pose()[0]
    tilt = np.arctan(angle * SLOPE)
    mass = simulation.object_mass
    # gravity turned by the tilt, about either axis and between them
    for direction in (0.0, np.pi / 8, np.pi / 4):
        across = np.array([np.cos(direction), np.sin(direction), 0.0])
        simulation.reset()
        for _ in range(500):
            side = mass * GRAVITY * np.sin(tilt) * across
            lift = mass * GRAVITY * (1.0 - np.cos(tilt)) * np.array([0.0, 0.0, 1.0])
            simulation.push_object(side + lift)
            simulation.step()
        moved = np.linalg.norm((simulation.object_pose()[0] - start)[:2])
        expected = 0.5 * GRAVITY * (np.sin(tilt) - SLOPE * np.cos(tilt)) * 1.0**2
        if slides:
            assert moved == pytest.approx(expected, rel=0.1)
        else:
            assert moved < 0.002


def test_scaled_friction_scales_the_slope(mujoco):
    simulation = mujoco(step=0.002, object="tape_dispenser", object_offset=(0.0, 1.0), segments=2)
    simulation.place_object((0.0, 1.0), 1.0, friction_scale=0.5)
    start = simulation.object_pose()[0]
    for _ in range(500):
        simulation.push_object(np.array([0.75 * SLOPE * GRAVITY * simulation.object_mass, 0, 0]))
        simulation.step()
    moved = simulation.object_pose()[0][0] - start[0]
    assert moved == pytest.approx(0.5 * 0.25 * SLOPE * GRAVITY, rel=0.1)


def test_what_is_held_stays_and_falls_when_it_is_let_go(mujoco):
    simulation = mujoco(step=0.002, object="ball")
    simulation.hold_object(np.array([0.3, 0.0, 0.1]), np.array([0.0, 0.0, 0.0, 1.0]))
    start = simulation.object_pose()[0]
    for _ in range(1000):
        simulation.step()
    assert simulation.object_pose()[0] == pytest.approx(start, abs=1e-5)
    simulation.release_object()
    for _ in range(50):
        simulation.step()
    fallen = start[2] - simulation.object_pose()[0][2]
    assert fallen == pytest.approx(0.5 * GRAVITY * 0.1**2, rel=0.05)


def test_a_snapshot_brings_a_grasp_back_bit_for_bit(mujoco):
    simulation = mujoco(step=0.005)
    place, turn = (part.copy() for part in simulation.wrist_pose())
    simulation.command_wrist(place - [0.0, 0.0, 0.1], turn)
    for _ in range(100):
        simulation.step()
    saved, touching = simulation.save(), None
    ends = []
    for _ in range(2):
        simulation.restore(saved)
        touching = touching or simulation.touching_object()
        simulation.set_air_masses(np.full(len(simulation.channels), 1e-5))
        for _ in range(60):
            simulation.step()
        ends.append((*simulation.object_pose(), *simulation.wrist_wrench(), simulation.bodies.q))
        ends[-1] = np.concatenate([np.ravel(part) for part in ends[-1]])
    assert np.array_equal(*ends)


def test_gaps_and_boxes_are_those_of_the_bodies(mujoco):
    simulation = mujoco(object="ball", object_offset=(0.0, 0.0, 0.0))
    radius = 0.0325
    box = simulation.object_box()
    middle = simulation.object_pose()[0]
    assert box == pytest.approx(np.array([middle - radius, middle + radius]), abs=1e-9)
    gaps = simulation.object_gaps(1.0)
    lowest = simulation.hand_boxes()[:, 0, 2].min()
    assert set(gaps) <= {chain.name for chain in simulation.hand.chains} | {"palm_plate"}
    assert min(gaps.values()) >= lowest - box[1, 2]


@pytest.mark.parametrize(
    ("config", "word"),
    [
        ({"gui": True}, "gui"),
        ({"engine": "bullet"}, "engine"),
        ({"solver": solver_settings("stable")}, "solver"),
        ({"finger_contact": True, "step": 0.005}, "step"),
    ],
)
def test_what_it_cannot_do_is_refused_by_name(simulate, config, word):
    with pytest.raises(ValueError, match=f"^{word}: expected"):
        simulate(**{"engine": MUJOCO, **config})


def test_an_object_rolls_with_resistance_and_stops(mujoco):
    table = Table("wood", None, 2.0e-4)
    scene = dataclasses.replace(load_scene("table"), table=table)
    assert isinstance(scene, SceneDescription)
    simulation = mujoco(step=0.002, scene=scene, object="ball", segments=2)
    simulation.place_object((0.0, 1.0), 1.0)
    for _ in range(100):
        simulation.step()
    body = simulation.engine.object
    speed = 0.3
    data = simulation.engine.data
    data.qvel[body._speed] = speed
    data.qvel[body._speed + 3 : body._speed + 6] = (
        Rotation.from_quat(simulation.object_pose()[1]).inv().apply([0.0, speed / 0.0325, 0.0])
    )
    start = simulation.object_pose()[0][0]
    for _ in range(500):
        simulation.step()
    # a solid sphere that rolls: 7/5 m a = -m g * resistance / radius
    slowed = 5.0 / 7.0 * GRAVITY * 2.0e-4 / 0.0325
    moved = simulation.object_pose()[0][0] - start
    assert moved == pytest.approx(speed * 1.0 - 0.5 * slowed, rel=0.03)


@pytest.mark.parametrize("name", ["surface_constrained", "rbo_hand_1_surface"])
def test_a_hand_grasps(mujoco, name):
    strategy = load_strategy(name)
    tried, name = strategy.tried_with, strategy.objects[0] if strategy.objects else "cylinder"
    corner = load_object(name).corner_place  # where the strategy was tuned, if it tells no place
    simulation = mujoco(
        hand=strategy.hand,
        step=0.002,
        segments=tried.segments,
        model=tried.model or None,
        object=name,
        object_offset=tried.place or corner,
    )
    assert Sequencer(InProcessScene(simulation), strategy).run().gripped
