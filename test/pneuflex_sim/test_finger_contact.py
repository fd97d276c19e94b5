"""Neighbouring fingers that curl into each other stop each other, if they are asked to."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.engines import ENGINES, MUJOCO, PYBULLET
from pneuflex_sim.hand.collision import SKIN_PATCH, SKIN_STIFFNESS, SKIN_TWIST, Touch
from pneuflex_sim.scene.friction import BodyFriction
from pneuflex_sim.world import World
from softhand_model.hand.hand import load_hand

SIDES = ("left", "right")
RADIUS, MASS = 0.02, 0.05  # of a ball [m], [kg]
INWARD = np.radians(25.0)  # of each finger about its length: they bend towards each other


def crossing_fingers():
    """Two P10 fingers side by side; both bend to the same side within 60 deg."""
    hand = load_hand("single_finger")
    finger = hand.chain("finger")
    chains = tuple(
        replace(
            finger,
            name=name,
            actuators={name: finger.actuators["finger"]},
            channels={name: "a"},
            mount=replace(
                finger.mount, position=(0.0, side * 0.02, 0.0), rpy=(0, 0, -side * INWARD)
            ),
        )
        for name, side in (("left", 1.0), ("right", -1.0))
    )
    return replace(hand, chains=chains, tips=("left", "right"))


def curled(simulate, hold_pressure, **config):
    simulation = simulate(hand=crossing_fingers(), scene="stand", **config)
    hold_pressure(simulation, [31e3], 2.5)
    return simulation


def overlap(simulation):
    """How deep [m] the fingers are in each other, whether they touch or not."""
    if simulation.config.engine == MUJOCO:
        return overlap_in_mujoco(simulation.engine)
    found = pybullet.getClosestPoints(
        *simulation.bodies.ids, 0.0, physicsClientId=simulation.engine.world.client
    )
    return max((-point[8] for point in found), default=0.0)


def overlap_in_mujoco(engine):
    model, margin = engine.model, engine.model.geom_margin
    geoms = {side: [k for k in range(model.ngeom) if side in model.geom(k).name] for side in SIDES}
    gaps = [
        mujoco.mj_geomDistance(model, engine.data, first, second, 0.05, None)
        - (margin[first] + margin[second])
        for first in geoms["left"]
        for second in geoms["right"]
    ]
    return max(0.0, -min(gaps))


def touching_force(simulation):
    """Sum of the normal forces [N] between the fingers."""
    return sum(c.force for c in simulation.contacts() if {c.first, c.second} == set(SIDES))


@pytest.mark.parametrize("engine", ENGINES)
def test_fingers_pass_through_each_other_by_default(simulate, hold_pressure, engine):
    simulation = curled(simulate, hold_pressure, engine=engine, step=0.004)
    left, right = (simulation.fingertips()[name][0] for name in SIDES)
    assert left[1] < right[1] - 0.01  # each came from the other side
    assert overlap(simulation) > 0.01


@pytest.mark.parametrize(
    ("engine", "step"),
    [(PYBULLET, 0.001), (PYBULLET, 0.002), (PYBULLET, 0.005), (MUJOCO, 0.001), (MUJOCO, 0.004)],
)
@pytest.mark.parametrize("segments", [5, 10])
def test_fingers_that_touch_stay_on_their_sides_and_come_to_rest(
    simulate, hold_pressure, engine, step, segments
):
    config = {"engine": engine, "step": step, "segments": segments, "finger_contact": True}
    simulation = curled(simulate, hold_pressure, **config)
    left, right = (simulation.fingertips()[name][0] for name in SIDES)
    assert left[1] > right[1] + 0.005
    assert overlap(simulation) < 5e-4
    assert np.abs(simulation.bodies.v).max() < 5e-3
    assert 0.1 < touching_force(simulation) < 1.0  # [N]


def test_both_engines_press_fingers_on_each_other_alike(simulate, hold_pressure):
    tips, forces = [], []
    for engine in ENGINES:
        config = {"engine": engine, "step": 0.002, "segments": 10, "finger_contact": True}
        simulation = curled(simulate, hold_pressure, **config)
        tips.append([simulation.fingertips()[side][0] for side in SIDES])
        forces.append(touching_force(simulation))
    assert np.ptp(tips, axis=0).max() < 2e-4
    assert np.ptp(forces) < 0.02 * max(forces)


@pytest.fixture
def on_a_finger():
    """A ball of 50 g at rest on a fixed one, with the skins of fingers."""
    world, touch = World(0.005), Touch(friction=0.8, neighbours=True)
    client = {"physicsClientId": world.client}
    pybullet.setGravity(0.0, 0.0, -9.81, **client)
    shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=RADIUS, **client)
    balls = [
        pybullet.createMultiBody(mass, shape, basePosition=(0.0, 0.0, height), **client)
        for mass, height in ((0.0, 0.0), (MASS, 2.0 * RADIUS))
    ]
    for ball in balls:
        pybullet.changeDynamics(
            ball, -1, lateralFriction=0.8, angularDamping=0.0, **touch.skin, **client
        )
    step(world, 400)
    yield world, balls[1]
    world.close()


def step(world, count):
    for _ in range(count):
        pybullet.stepSimulation(physicsClientId=world.client)


def test_two_skins_that_meet_yield_in_series(on_a_finger):
    world, ball = on_a_finger
    place, _ = pybullet.getBasePositionAndOrientation(ball, physicsClientId=world.client)
    sunk = 2.0 * RADIUS - np.linalg.norm(place)
    assert sunk == pytest.approx(MASS * 9.81 / (0.5 * SKIN_STIFFNESS), abs=2e-5)


@pytest.mark.parametrize("factor", [1.0, 0.25])
def test_friction_over_the_patch_stops_what_spins_on_a_skin(on_a_finger, factor):
    """PyBullet lets both skins resist; the moment goes with friction as sliding does."""
    world, ball = on_a_finger
    friction = BodyFriction(world.client)
    friction.scale(factor)
    pybullet.resetBaseVelocity(ball, angularVelocity=(0, 0, 50.0), physicsClientId=world.client)
    step(world, 10)
    _, spin = pybullet.getBaseVelocity(ball, physicsClientId=world.client)
    moment = 2.0 * factor * 0.8**2 * SKIN_TWIST * MASS * 9.81
    slower = moment / (0.4 * MASS * RADIUS**2) * 10 * world.step_size
    assert 50.0 - spin[2] == pytest.approx(slower, rel=0.02)


def test_the_skin_yields_as_much_as_rubber_does_by_hertz():
    """Two balls of rubber, 3 G and 8 mm, at 1 N: the slope of force over depth is that of two skins
    in series; and the patch that one of them makes with something rigid.
    """
    modulus = 3.0 * 67e3 / (1.0 - 0.5**2)
    depth = (0.75 / (0.5 * modulus * np.sqrt(0.004))) ** (2.0 / 3.0)
    assert 1.5 / depth == pytest.approx(0.5 * SKIN_STIFFNESS, rel=0.02)
    assert (0.75 * 0.008 / modulus) ** (1.0 / 3.0) == pytest.approx(SKIN_PATCH, rel=0.02)


def test_outcome_does_not_depend_on_the_step(simulate, hold_pressure):
    tips = [
        curled(simulate, hold_pressure, step=step, finger_contact=True).fingertips()["left"][0]
        for step in (0.001, 0.005)
    ]
    assert tips[0] == pytest.approx(tips[1], abs=1e-3)


@pytest.mark.parametrize(
    ("engine", "step"), [(PYBULLET, 0.001), (PYBULLET, 0.005), (MUJOCO, 0.001), (MUJOCO, 0.004)]
)
def test_touching_fingers_of_a_whole_hand_close_on_an_object_and_stay_finite(
    simulate, engine, step
):
    simulation = simulate(engine=engine, step=step, finger_contact=True)
    pose = np.array([-0.057, 0.0, 0.146]), np.array([0.0, 0.92388, 0.0, 0.38268])
    masses = np.array([7.1e-5, 2.4e-5, 5.3e-5, 4.3e-5])
    simulation.command_wrist(*pose)
    for _ in range(round(1.5 / step)):
        simulation.set_air_masses(masses * np.clip((simulation.time - 0.6) / 0.5, 0, 1))
        simulation.step()
    holding = {contact.first for contact in simulation.object_contacts()}
    assert holding
    assert np.abs(simulation.bodies.v).max() < 1.0
