"""A finger that is pressed on a plate: energy, friction cone, steps, another engine."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from softhand_common.numerics.rotations import to_rpy
from softhand_model.chain.chain import discretise
from softhand_model.chain.hulls import COLLISION_MARGIN, collision_hulls
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model
from softhand_model.motion.pressed_body import SKIN_NORMAL, PressedBody, press_path

SEGMENTS, PRESSURE, FRICTION = 6, 22e3, 0.3
TURN = Rotation.from_euler("xyz", (0.0, 0.5 * np.pi, 0.0))  # palm down
TIME = np.arange(0.0, 3.01, 0.05)
HAND = load_hand("single_finger")
(CHAIN,) = HAND.chains


def path(start=0.09, end=0.04, slide=0.02, step=0.02):
    """Down within a second, sideways in the third."""
    height = start + (end - start) * np.clip(TIME, 0.0, 1.0)
    place = np.stack([slide * np.clip(TIME - 1.5, 0.0, 1.0), 0.0 * TIME, height], axis=1)
    return press_path(TIME, place, np.tile(TURN.as_quat(), (len(TIME), 1)), step)


def body(segments=SEGMENTS):
    return PressedBody(HAND, {CHAIN.name: discretise(CHAIN, segments, load_model())}, 0.01)


def pressed(way, friction=FRICTION, pressure=PRESSURE, segments=SEGMENTS):
    pressures = np.full((1, len(TIME)), pressure)
    return body(segments).press([way], [TIME], [pressures], 0.0, friction)[0].wrench


def test_force_without_friction_is_that_of_the_least_energy():
    one, way = body(), path(slide=0.0)
    found = pressed(way, friction=1e-9)[-1]
    arrays, hulls = one.arrays, collision_hulls(CHAIN, SEGMENTS)
    stiffness = one.stiffness(1.0)[:, 1]
    rest = one.free_rotations(np.array([[PRESSURE]]), 1.0, np.array([293.15]))[0, :, 1]
    wrist, turn = way.place[-1], TURN.as_matrix()

    def laid(bends):
        """Depths in the plate, and heights of the centres of mass, at bends about y."""
        place, frame = wrist + turn @ arrays.place, turn @ arrays.frame
        depths, heights = [], []
        for joint, bend in enumerate(bends):
            place = place + frame @ arrays.offset[joint]
            about = Rotation.from_rotvec([0.0, bend, 0.0]).as_matrix()
            frame = frame @ arrays.rest[joint] @ about
            points = place + hulls[joint] @ frame.T
            depths.append(np.maximum(COLLISION_MARGIN - points[:, 2], 0.0))
            heights.append((place + frame @ arrays.center[joint])[2])
        return np.concatenate(depths), np.array(heights)

    def energy(bends):
        depths, heights = laid(bends)
        elastic = 0.5 * np.sum(stiffness * (bends - rest) ** 2)
        skin = 0.5 * SKIN_NORMAL * np.sum(depths**2)
        return 1e3 * (elastic + skin + STANDARD_GRAVITY * arrays.mass @ heights)

    least = minimize(energy, rest, method="BFGS", options={"gtol": 1e-7})
    force = SKIN_NORMAL * laid(least.x)[0].sum()
    assert force > 0.1
    assert found[2] == pytest.approx(force, rel=2e-3)
    assert np.hypot(*found[:2]) < 1e-4


def test_a_finger_that_slides_pulls_with_friction_times_its_force():
    way = path()
    inertia = body().arrays.mass.sum() * way.acceleration[way.kept]
    force = pressed(way)[:, :3] + inertia
    sliding = (TIME > 2.2) & (TIME < 2.5)
    assert force[sliding, 0] == pytest.approx(-FRICTION * force[sliding, 2], rel=1e-3)
    assert np.abs(force[sliding, 1]).max() < 1e-3 * force[sliding, 2].min()
    shear = np.hypot(force[:, 0], force[:, 1])
    assert (shear <= FRICTION * force[:, 2] * (1.0 + 1e-6) + 1e-9).all()


def test_the_wrench_hardly_depends_on_steps_and_tends_with_segments():
    coarse = pressed(path())
    size = np.abs(coarse[:, :3]).max()
    assert np.abs(coarse - pressed(path(step=0.005)))[:, :3].max() < 0.02 * size
    errors = [
        np.abs(pressed(path(), segments=n)[-1, 2] - pressed(path(), segments=24)[-1, 2])
        for n in (6, 12)
    ]
    assert errors[1] < 0.5 * errors[0]


def test_in_the_air_it_feels_but_the_lever_of_its_weight():
    one = body()
    found = pressed(path(start=0.4, end=0.4, slide=0.0))
    assert np.abs(found[:, :3]).max() < 1e-9
    gravity = STANDARD_GRAVITY * TURN.inv().apply([0.0, 0.0, -1.0])
    centers = []
    for pressure, pull in ((PRESSURE, gravity), (0.0, 0.0 * gravity)):
        shape = one.settle(np.array([[pressure]]), pull[None])
        at = shape.places[0] + np.einsum("nij,nj->ni", shape.frames[0], one.arrays.center)
        centers.append(one.arrays.mass @ at)
    moment = TURN.apply(np.cross(centers[0] - centers[1], gravity))
    assert found[0, 3:] == pytest.approx(moment, abs=1e-7)


def test_inertia_pulls_at_a_wrist_that_swings_in_the_air():
    rate, reach = 2.0, 0.02  # [rad/s], [m]
    place = np.stack([reach * np.sin(rate * TIME), 0.0 * TIME, 0.4 + 0.0 * TIME], axis=1)
    way = press_path(TIME, place, np.tile(TURN.as_quat(), (len(TIME), 1)), 0.02)
    mass = body().arrays.mass.sum()
    wanted = mass * reach * rate**2 * np.sin(rate * TIME)
    inside = slice(3, -3)  # a difference in time reaches no further
    force = pressed(way)[inside, 0]
    assert force == pytest.approx(wanted[inside], abs=0.01 * mass * reach * rate**2)


def test_a_run_whose_joint_does_not_come_to_rest_has_no_result_and_says_so():
    sudden = np.where(TIME < 1.0, 0.0, 35e3)[None]  # the only joint turns by 3 rad at once
    ways = [path(start=0.4, end=0.4, slide=0.0, step=step) for step in (0.05, 0.05, 0.005)]
    courses = [sudden, 0.0 * sudden, sudden]
    wild, calm, finer = body(1).press(ways, [TIME] * 3, courses, 0.0, FRICTION)
    assert wild.unsettled == f"joint 1 of {CHAIN.name} does not come to rest at 1 s"
    assert np.isnan(wild.wrench).all()
    for settled in (calm, finer):
        assert not settled.unsettled
        assert np.isfinite(settled.wrench).all()


def test_mujoco_feels_about_the_same():
    pytest.importorskip("mujoco")
    from pneuflex_sim.engines.mujoco.compliance import rigid_skin
    from pneuflex_sim.scene.scenes import load_scene
    from pneuflex_sim.simulation import Simulation, SimulationConfig
    from softhand_model.effects.load import Gravity
    from softhand_model.model_file import Model

    way = path(slide=0.0)
    scene = replace(
        load_scene("press"),
        wrist_position=tuple(way.place[0].tolist()),
        wrist_rpy=tuple(to_rpy(TURN.as_quat()).tolist()),
    )
    simulation = Simulation(
        SimulationConfig(
            "single_finger",
            scene=scene,
            model=Model(effects=(Gravity(mass_scale=1.0),)),
            segments=SEGMENTS,
            step=5e-4,
            engine="mujoco",
        )
    )
    rigid_skin(simulation.engine.model)
    friction = 0.1  # of the scene's plate
    for step in range(6000):
        height = np.interp(step * 5e-4 - 0.5, TIME, np.interp(TIME, [0.0, 1.0], [0.09, 0.04]))
        simulation.command_wrist([0.0, 0.0, height], TURN.as_quat())
        wanted = np.array([simulation.ambient + PRESSURE])
        rotations = simulation.bodies.rotations
        masses = simulation.air.masses(
            wanted, simulation.ambient, simulation.temperature, rotations
        )
        simulation.set_air_masses(masses)
        simulation.step()
    place, orientation = simulation.wrist_pose()
    lift = np.outer(np.interp(TIME, [0.0, 1.0], [0.05, 0.0]), [0.0, 0.0, 1.0])
    held = press_path(TIME, place + lift, np.tile(orientation, (len(TIME), 1)), 0.02)
    found = pressed(held, friction=friction)[-1]
    force, torque = simulation.wrist_wrench()
    assert force[2] > 0.1
    assert found[2] == pytest.approx(force[2], rel=0.05)
    assert found[4] == pytest.approx(torque[1], rel=0.05)
