"""Springs of the model file in the simulated finger, against solvers that know no time step."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from pneuflex_sim.bullet import pybullet
from softhand_model.chain.chain import discretise
from softhand_model.effects import effect_classes
from softhand_model.hand.actuator import load_actuator
from softhand_model.hand.hand import load_hand
from softhand_model.hand.joint_stiffness import SpringModel, rubber_stress
from softhand_model.model_file import Model
from thesis.chapter_3_and_5.planar import (
    equilibrium,
    exact_springs,
    planar_finger,
)

STEPS = [0.001, 0.002, 0.005, 0.01]
RUBBER = SpringModel(bending="curvature")
GRAVITY = (effect_classes()["gravity"](mass_scale=1.0),)


def rubber_springs(stiffness, rest, stretching):
    """Springs of eq. 3.24 for the static solver: the pressure's moment, that of the rubber at rest,
    grows with the load.
    """
    moment, per_angle = rubber_stress(1.0 + stretching * rest)[0], stiffness / (2.0 * stretching)
    return lambda angles, share: (
        per_angle * (share * moment - rubber_stress(1.0 + stretching * angles)[0])
    )


def of_constant_section():
    """A finger whose section is square and the same everywhere, as 3.24 has it."""
    hand = load_hand("single_finger")
    actuator = replace(load_actuator("P5"), length=0.06, shear_modulus=20e3)
    chain = replace(hand.chain("finger"), actuators={"finger": actuator})
    return replace(hand, chains=(chain,)), actuator


@pytest.mark.parametrize("step", STEPS)
def test_a_level_finger_of_rubber_sags_as_the_moments_of_the_section_say(
    simulate, hold_pressure, level_stand, step
):
    hand, actuator = of_constant_section()
    model = Model(effects=GRAVITY, springs=RUBBER)
    simulation = simulate(hand=hand, scene="stand", step=step, model=model)
    hold_pressure(simulation, [15e3], 6.0)
    chain = simulation.bodies.layout.models["finger"].segments
    exact = exact_springs(actuator, 5, 15e3)
    sagged = equilibrium(planar_finger(chain), exact, gravity=(9.80665, 0.0)).angles.sum()
    weightless = equilibrium(planar_finger(chain), exact).angles.sum()
    assert abs(sagged - weightless) > 0.02
    assert simulation.tip_angles()["finger"] == pytest.approx(sagged, rel=1e-3)


@pytest.mark.parametrize("step", STEPS)
def test_a_tapered_finger_of_rubber_sags_as_the_static_solver_says(
    simulate, hold_pressure, level_stand, step
):
    model = Model(effects=GRAVITY, springs=RUBBER)
    simulation = simulate(hand="single_finger", scene="stand", step=step, model=model)
    hold_pressure(simulation, [10e3], 6.0)
    chain = simulation.bodies.layout.models["finger"]
    rest = chain.rest_rotation([10e3])[:, 1]
    springs = rubber_springs(chain.segments.stiffness[:, 1], rest, chain.segments.stretching)
    finger = planar_finger(chain.segments)
    expected = equilibrium(finger, springs, gravity=(9.80665, 0.0)).angles.sum()
    assert simulation.tip_angles()["finger"] == pytest.approx(expected, rel=1e-3)


def test_rubber_carries_the_work_of_the_air_and_linear_springs_do_not():
    """Torque of a pressure on a joint held anywhere: p*dV/dbend (virtual work), h**2*z*p/2."""
    hand, _ = of_constant_section()
    pressure, bend = 12e3, np.linspace(-0.1, 0.5, 5)
    chain = discretise(hand.chain("finger"), 5, Model(springs=RUBBER))
    rest = chain.rest_rotation([pressure])[:, 1]
    size = (chain.segments.stiffness[:, 1], chain.segments.stretching)
    filled, empty = (rubber_springs(size[0], angle, size[1]) for angle in (rest, 0.0 * rest))
    gained = filled(bend, 1.0) - empty(bend, 1.0)
    assert gained == pytest.approx(pressure * chain.volume_gain[0], rel=1e-7)
    assert np.abs(size[0] * rest / gained - 1.0).min() > 0.1


class LoadedChain:
    """A weightless chain under a force at its tip, by least energy."""

    def __init__(self, chain, rest, force):
        self.chain, self.rest, self.force = chain, rest, force

    def tip(self, rotations):
        place, turn = np.zeros(3), Rotation.identity()
        for offset, rest, rotation in zip(
            self.chain.offset, self.rest, rotations.reshape(-1, 3), strict=True
        ):
            place = place + turn.apply(offset)
            turn = turn * Rotation.from_rotvec([0, rest, 0]) * Rotation.from_rotvec(rotation)
        return place + turn.apply(self.chain.tip_offset), turn

    def energy(self, rotations):
        elastic = 0.5 * np.sum(self.chain.stiffness * rotations.reshape(-1, 3) ** 2)
        return 1e3 * (elastic - self.force @ self.tip(rotations)[0])

    def shape(self):
        start = np.zeros(3 * len(self.rest))
        return self.tip(minimize(self.energy, start, method="BFGS", options={"gtol": 1e-7}).x)


@pytest.mark.parametrize("step", STEPS)
def test_a_finger_softer_sideways_and_in_twist_yields_to_the_least_energy(
    simulate, hold_pressure, step
):
    springs = SpringModel(lateral=0.5, twist="section")
    simulation = simulate(
        hand="single_finger", scene="stand", step=step, model=Model(springs=springs)
    )
    bodies, force = simulation.bodies, np.array([0.02, 0.12, 0.0])
    chain = bodies.layout.models["finger"]
    tip = len(bodies.layout.mass) - 1
    client = simulation.engine.world.client

    def push(_):
        at = simulation.fingertips()["finger"][0] + simulation.scene.wrist_position
        share = min(1.0, simulation.time / 0.5)
        pybullet.applyExternalForce(
            bodies.ids[0], tip, share * force, at, pybullet.WORLD_FRAME, physicsClientId=client
        )
        simulation._volumes = simulation.air.volumes(bodies.rotations)
        simulation.pressures_abs = simulation.ambient + np.array([share * 20e3])

    simulation._update_air = push
    for _ in range(round(6.0 / step)):
        simulation.step()
    rest = chain.rest_rotation([20e3])[:, 1]
    oracle = LoadedChain(chain.segments, rest, force)
    place, turn = oracle.shape()
    found, quaternion = simulation.fingertips()["finger"]
    free = oracle.tip(np.zeros(3 * len(rest)))[0]
    assert np.linalg.norm(place - free) > 0.02
    assert found == pytest.approx(place, abs=5e-5)
    assert (turn.inv() * Rotation.from_quat(quaternion)).magnitude() < 2e-3


@pytest.mark.parametrize("step", [0.002, 0.01])
def test_a_soft_hand_that_is_rammed_into_the_table_stays_finite(simulate, step):
    model = Model(effects=GRAVITY, springs=SpringModel("curvature", "section", "section"))
    simulation = simulate(hand="rbo_hand_1", step=step, model=model)
    simulation.command_wrist(np.array([-0.057, 0.0, 0.146]), np.array([0.0, 0.92388, 0.0, 0.38268]))
    for _ in range(round(1.0 / step)):
        simulation.step()
    assert simulation.contacts()
    assert np.abs(simulation.bodies.v).max() < 50.0
