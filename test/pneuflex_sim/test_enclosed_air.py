"""Air behind closed valves (3.4.2): a push on one finger is felt by all of its channel."""

from dataclasses import replace

import pytest
from scipy.optimize import brentq

from pneuflex_sim.bullet import pybullet
from softhand_model.hand.hand import load_hand
from softhand_model.hand.joint_stiffness import SpringModel
from softhand_model.hand.section import elastic_term, free_stretch
from softhand_model.model_file import Model

PUSH = -0.004  # [N m] about y on the last link of the finger `pushed`
HEAT = 287.05 * 293.15


def two_fingers():
    """Two P10 fingers on one channel, far from each other."""
    hand = load_hand("single_finger")
    finger = hand.chain("finger")
    chains = tuple(
        replace(
            finger,
            name=name,
            actuators={name: finger.actuators["finger"]},
            channels={name: "a"},
            mount=replace(finger.mount, position=(0.0, y, 0.0)),
        )
        for name, y in (("pushed", 0.1), ("other", -0.1))
    )
    return replace(hand, chains=chains, tips=("pushed", "other"))


def push(simulation, share):
    pybullet.applyExternalTorque(
        simulation.bodies.ids[0],
        len(simulation.bodies.layout.mass) // 2 - 1,
        [0, share * PUSH, 0],
        pybullet.LINK_FRAME,
        physicsClientId=simulation.engine.world.client,
    )


def expected_angles(simulation, mass, moment):
    """Angles of both fingers and pressure where springs, push and p_abs*V = m*R*T agree."""
    layout = simulation.bodies.layout
    dead = 2.0 * simulation.plant.parameters.choke.dead_volume  # behind inlet and outlet valve
    at_rest = simulation.air.rest_volumes[0] + dead

    def bends(name, pressure, load):
        model = layout.models[name]
        rest, k = model.rest_rotation([pressure])[:, 1], model.segments.stiffness[:, 1]
        gain = model.segments.stretching
        if not gain.any():
            return rest + load / k
        return (free_stretch(elastic_term(1 + gain * rest) + 2 * gain * load / k) - 1) / gain

    def excess(pressure):
        volume = at_rest + sum(
            layout.models[name].volume_gain[0] @ bends(name, pressure, load)
            for name, load in (("pushed", moment), ("other", 0.0))
        )
        return (pressure + simulation.ambient) * volume - mass * HEAT

    pressure = brentq(excess, 0.0, 200e3)
    angles = [bends("pushed", pressure, moment).sum(), bends("other", pressure, 0.0).sum()]
    return angles, pressure


@pytest.mark.parametrize("step", [0.001, 0.005])
@pytest.mark.parametrize("bending", ["rule", "curvature"])
def test_a_pushed_finger_bends_the_other_of_its_channel_as_the_gas_law_says(
    simulate, step, bending
):
    model = Model(springs=SpringModel(bending=bending))
    simulation = simulate(hand=two_fingers(), scene="stand", step=step, model=model)
    while simulation.pressures()[0] < 25e3:
        simulation.step([1])
    for _ in range(round(1.0 / step)):
        simulation.step([0])
    mass, seen = simulation.plant.mass[0], []
    for moment in (0.0, PUSH):
        for k in range(round(2.0 / step)):
            push(simulation, min(1.0, k * step / 0.3) * moment / PUSH)
            simulation.step([0])
        assert simulation.plant.mass[0] == pytest.approx(mass, rel=1e-12)
        angles, pressure = expected_angles(simulation, mass, moment)
        found = simulation.tip_angles()
        assert [found["pushed"], found["other"]] == pytest.approx(angles, rel=1e-3)
        assert simulation.pressures()[0] == pytest.approx(pressure, rel=1e-3)
        seen.append(found)
    assert seen[1]["pushed"] < seen[0]["pushed"] - 0.05
    assert seen[1]["other"] > seen[0]["other"] + 0.02
