"""Neighbouring fingers that curl into each other stop each other, if they are asked to."""

from dataclasses import replace

import numpy as np
import pybullet
import pytest

from pneuflex_sim.hand.collision import Touch
from softhand_model.hand.hand import load_hand

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
    found = pybullet.getClosestPoints(
        *simulation.bodies.ids, 0.0, physicsClientId=simulation.world.client
    )
    return max((-point[8] for point in found), default=0.0)


def test_fingers_pass_through_each_other_by_default(simulate, hold_pressure):
    simulation = curled(simulate, hold_pressure, step=0.005)
    left, right = (simulation.fingertips()[name][0] for name in ("left", "right"))
    assert left[1] < right[1] - 0.01  # each came from the other side
    assert overlap(simulation) > 0.01


@pytest.mark.parametrize("step", [0.001, 0.002, 0.005])
@pytest.mark.parametrize("segments", [5, 10])
def test_fingers_that_touch_stay_on_their_sides_and_come_to_rest(
    simulate, hold_pressure, step, segments
):
    simulation = curled(simulate, hold_pressure, step=step, segments=segments, finger_contact=True)
    left, right = (simulation.fingertips()[name][0] for name in ("left", "right"))
    assert left[1] > right[1] + 0.005
    assert overlap(simulation) < 5e-4
    assert np.abs(simulation.bodies.v).max() < 5e-3
    points = pybullet.getContactPoints(
        *simulation.bodies.ids, physicsClientId=simulation.world.client
    )
    assert 0.1 < sum(point[9] for point in points) < 1.0  # [N]


def test_two_skins_that_meet_yield_in_series():
    """A ball that rests on another one sinks in by its weight over half of a skin's stiffness."""
    client = pybullet.connect(pybullet.DIRECT)
    try:
        pybullet.setGravity(0.0, 0.0, -9.81, physicsClientId=client)
        pybullet.setTimeStep(0.005, physicsClientId=client)
        ball = pybullet.createCollisionShape(
            pybullet.GEOM_SPHERE, radius=0.02, physicsClientId=client
        )
        under, upon = (
            pybullet.createMultiBody(
                mass, ball, basePosition=(0.0, 0.0, height), physicsClientId=client
            )
            for mass, height in ((0.0, 0.0), (0.05, 0.04))
        )
        for body in (under, upon):
            pybullet.changeDynamics(body, -1, **Touch(neighbours=True).skin, physicsClientId=client)
        for _ in range(400):
            pybullet.stepSimulation(physicsClientId=client)
        (x, y, z), _ = pybullet.getBasePositionAndOrientation(upon, physicsClientId=client)
    finally:
        pybullet.disconnect(client)
    assert 0.04 - np.linalg.norm([x, y, z]) == pytest.approx(0.05 * 9.81 / 750.0, abs=2e-5)


def test_the_skin_yields_as_much_as_rubber_does_by_hertz():
    """Two balls of rubber, 3 G and 8 mm, at 1 N: as far as two skins in series."""
    modulus = 3.0 * 67e3 / (2.0 * (1.0 - 0.5**2))
    depth = (0.75 / (modulus * np.sqrt(0.004))) ** (2.0 / 3.0)
    assert 2.0 / Touch(neighbours=True).skin["contactStiffness"] == pytest.approx(depth, rel=0.4)


def test_outcome_does_not_depend_on_the_step(simulate, hold_pressure):
    tips = [
        curled(simulate, hold_pressure, step=step, finger_contact=True).fingertips()["left"][0]
        for step in (0.001, 0.005)
    ]
    assert tips[0] == pytest.approx(tips[1], abs=1e-3)


@pytest.mark.parametrize("step", [0.001, 0.005])
def test_touching_fingers_of_a_whole_hand_close_on_an_object_and_stay_finite(simulate, step):
    simulation = simulate(step=step, finger_contact=True)
    pose = np.array([-0.057, 0.0, 0.146]), np.array([0.0, 0.92388, 0.0, 0.38268])
    masses = np.array([7.1e-5, 2.4e-5, 5.3e-5, 4.3e-5])
    simulation.command_wrist(*pose)
    for _ in range(round(1.5 / step)):
        simulation.set_air_masses(masses * np.clip((simulation.time - 0.6) / 0.5, 0, 1))
        simulation.step()
    holding = {contact.first for contact in simulation.object_contacts()}
    assert holding
    assert np.abs(simulation.bodies.v).max() < 1.0
