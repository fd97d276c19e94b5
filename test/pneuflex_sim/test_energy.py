"""A finger let go loses energy at every step size, and all of it in the end."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pneuflex_sim.hand import layout
from softhand_model.dynamics.chain import inertial_torque, not_placed, place_links
from softhand_model.hand.joint_stiffness import SpringModel
from softhand_model.model_file import Model


def energy(simulation):
    """Kinetic and elastic energy [J] of a weightless hand without pressure, whose links move
    without the inertia that is given back to them.
    """
    bodies, hand = simulation.bodies, simulation.bodies.layout
    links, placed = hand.links(simulation.step_size), not_placed(len(hand.mass))
    links = links._replace(inertia=links.inertia - links.given)
    momentum = np.empty_like(bodies.v)
    place_links(bodies.q, links, placed)
    inertial_torque(bodies.v, links, placed, momentum)
    elastic = 0.5 * np.sum(hand.stiffness * bodies.rotations**2)
    if hand.stretching.any():
        elastic += np.sum(hand.stiffness[:, 1] * beyond_linear(bodies.rotations, hand.stretching))
    return 0.5 * np.sum(bodies.v * momentum) + elastic


def beyond_linear(rotations, stretching):
    """What springs of eq. 3.24 store beyond linear ones, over the stiffness: integral of q(u)."""
    bend = rotations[:, 1]
    stretch = 1 + stretching * bend
    return (stretch**2 + stretch**-2 - 2) / (4 * stretching**2) - bend**2 / 2


def let_go(simulation):
    """Bend every joint and let go."""
    bent = Rotation.from_rotvec([0.05, 0.25, 0.02])
    start = (Rotation.from_quat(simulation.bodies.layout.rest) * bent).as_quat()
    simulation.bodies.reset(simulation.wrist, start)


def test_without_damping_energy_is_conserved_to_first_order_in_the_step(
    simulate, hold_pressure, weightless, monkeypatch
):
    monkeypatch.setattr("softhand_model.effects.hand.DAMPING_TIME", 0.0)
    monkeypatch.setattr(layout, "ADDED_INERTIA", 0.0)
    lost = []
    for step in (2e-4, 1e-4):
        simulation = simulate(hand="single_finger", scene="stand", step=step, model=weightless)
        let_go(simulation)
        before = energy(simulation)
        hold_pressure(simulation, [0.0], 0.02)
        lost.append(1 - energy(simulation) / before)
    assert 0 < lost[1] < 0.35
    assert lost[1] < 0.65 * lost[0]


@pytest.mark.parametrize("step", [0.001, 0.002, 0.005, 0.01])
@pytest.mark.parametrize(
    "springs", [SpringModel(), SpringModel("curvature", "section", "section")], ids=["rule", "own"]
)
def test_a_finger_let_go_only_loses_energy(simulate, hold_pressure, springs, step):
    model = Model(springs=springs)
    simulation = simulate(hand="single_finger", scene="stand", step=step, model=model)
    let_go(simulation)
    levels = [energy(simulation)]
    for _ in range(max(round(3.0 / step), 600)):  # motion is slower at large steps
        hold_pressure(simulation, [0.0], step)
        levels.append(energy(simulation))
    assert levels[0] > 5e-3
    assert np.diff(levels).max() < 2e-4 * levels[0]
    assert levels[-1] < 1e-6 * levels[0]


def test_a_joint_let_go_swings_as_a_damped_oscillator_of_ten_milliseconds(
    simulate, hold_pressure, weightless
):
    """I*e'' + D*e' + K*e = 0 with D = 10 ms * K, solved in closed form."""
    step, start = 1e-4, 0.2
    simulation = simulate(
        hand="single_finger", scene="stand", step=step, segments=1, model=weightless
    )
    bodies, hand = simulation.bodies, simulation.bodies.layout
    bodies.reset(simulation.wrist, Rotation.from_rotvec([0.0, start, 0.0]).as_quat()[None])
    arm = hand.center[0]
    inertia = hand.inertia(0.0)[0, 1] + hand.mass[0] * (arm[0] ** 2 + arm[2] ** 2)
    stiffness = hand.stiffness[0, 1]
    decay = 0.010 * stiffness / (2 * inertia)
    swing = np.sqrt(stiffness / inertia - decay**2 + 0j)
    for _ in range(4):
        hold_pressure(simulation, [0.0], 0.010)
        t = simulation.time
        shape = np.cos(swing * t) + decay * np.sin(swing * t) / swing
        expected = start * float((np.exp(-decay * t) * shape).real)
        assert bodies.rotations[0, 1] == pytest.approx(expected, abs=0.02 * start)
    assert abs(expected) < 0.7 * start
