"""The simulated finger at rest against solvers that know no time step."""

import pytest
from scipy.optimize import brentq

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.hand.collision import ENVIRONMENT_GROUP
from thesis.chapter_3_and_5.planar import Stop, equilibrium, linear_springs, planar_finger

STEPS = [0.001, 0.002, 0.005, 0.01]


def rest_angles(simulation, pressure):
    model = simulation.bodies.layout.models["finger"]
    return model.rest_rotation([pressure])[:, 1]


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("segments", [5, 15])
def test_a_level_finger_sags_as_the_static_solver_says(
    simulate, hold_pressure, level_stand, step, segments
):
    simulation = simulate(hand="single_finger", scene="stand", step=step, segments=segments)
    hold_pressure(simulation, [10e3], 12.0)  # slow at 10 ms with 15 segments
    chain = simulation.bodies.layout.models["finger"].segments
    springs = linear_springs(chain.stiffness[:, 1], rest_angles(simulation, 10e3))
    expected = equilibrium(planar_finger(chain), springs, gravity=(9.80665, 0.0)).angles.sum()
    weightless = rest_angles(simulation, 10e3).sum()
    assert abs(expected - weightless) > 0.02  # the weight shows
    assert simulation.tip_angles()["finger"] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("step", STEPS)
def test_a_blocked_tip_pushes_as_hard_as_the_static_solver_says(
    simulate, hold_pressure, weightless, step
):
    simulation = simulate(
        hand="single_finger", scene="stand", step=step, model=weightless, collision="boxes"
    )
    client, gap = simulation.engine.world.client, 0.010
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=[0.05, 0.2, 0.2], physicsClientId=client
    )
    plate = pybullet.createMultiBody(0, shape, -1, [gap + 0.05, 0, 0.4], physicsClientId=client)
    pybullet.setCollisionFilterGroupMask(plate, -1, ENVIRONMENT_GROUP, -1, physicsClientId=client)
    pybullet.changeDynamics(plate, -1, lateralFriction=0, physicsClientId=client)
    hold_pressure(simulation, [20e3], 4.0)
    force = sum(point[9] for point in pybullet.getContactPoints(plate, physicsClientId=client))
    chain = simulation.bodies.layout.models["finger"].segments
    springs = linear_springs(chain.stiffness[:, 1], rest_angles(simulation, 20e3))
    expected = equilibrium(planar_finger(chain), springs, stop=Stop((-1.0, 0.0), -gap))
    assert expected.tip_force > 0.2
    assert force == pytest.approx(expected.tip_force, rel=1e-3)
    angle = simulation.tip_angles()["finger"]
    assert angle == pytest.approx(expected.angles.sum(), abs=5e-4)  # 0.01 mm at the plate


def closed_form_bend(simulation, mass, moment):
    """Angle and pressure where springs, moment and p_abs*V = m*R*T agree, by root finding in p."""
    model = simulation.bodies.layout.models["finger"]
    stiffness = model.segments.stiffness[:, 1]
    rest_volume, gain = simulation.air.rest_volumes[0], model.volume_gain[0]
    content = simulation.ambient * rest_volume + mass * 287.05 * 293.15

    def angles(pressure):
        return model.rest_rotation([pressure])[:, 1] + moment / stiffness

    def excess(pressure):
        return (pressure + simulation.ambient) * (rest_volume + gain @ angles(pressure)) - content

    pressure = brentq(excess, 0.0, 200e3)
    return angles(pressure).sum(), pressure


@pytest.mark.parametrize("step", STEPS)
def test_closed_valves_keep_the_mass_while_a_push_moves_pressure_and_volume(
    simulate, mass_for_pressure, weightless, step
):
    simulation = simulate(hand="single_finger", scene="stand", step=step, model=weightless)
    mass = mass_for_pressure(simulation, [31e3])
    tip = len(simulation.bodies.layout.mass) - 1
    angles, pressures = [], []
    for moment in (0.0, -0.004):
        for k in range(round(3.0 / step)):
            simulation.set_air_masses(mass * min(1.0, (simulation.steps + 1) * step / 0.3))
            share = min(1.0, k * step / 0.3)
            pybullet.applyExternalTorque(
                simulation.bodies.ids[0],
                tip,
                [0, share * moment, 0],
                pybullet.LINK_FRAME,
                physicsClientId=simulation.engine.world.client,
            )
            simulation.step()
        angle, pressure = closed_form_bend(simulation, mass[0], moment)
        assert simulation.tip_angles()["finger"] == pytest.approx(angle, rel=1e-3)
        assert simulation.pressures()[0] == pytest.approx(pressure, rel=1e-3)
        assert simulation.air_masses()[0] == pytest.approx(mass[0], rel=1e-6)
        angles.append(angle)
        pressures.append(pressure)
    soft = 0.004 / (angles[0] - angles[1])
    model = simulation.bodies.layout.models["finger"]
    vented = 1 / (1 / model.segments.stiffness[:, 1]).sum()
    assert soft > 1.3 * vented  # enclosed air stiffens the finger
    assert pressures[1] > pressures[0] + 1e3  # and the push raised its pressure
