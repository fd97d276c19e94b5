"""What is read from a push on the finger, and what is said of it."""

import json

import numpy as np
import pytest

from pneuflex_sim.simulation import Simulation, SimulationConfig
from pneuflex_sim.urdf import joint_positions
from softhand_model.gas import AMBIENT_PRESSURE, GAS_CONSTANT, ROOM_TEMPERATURE
from thesis.equilibrium_point import verdict
from thesis.equilibrium_point.course import Course, volumes
from thesis.equilibrium_point.picture import draw
from thesis.equilibrium_point.session import HAND, SCENE, Push

PUSH = Push("mass", 10.0, 11.0, 13.0, 14.0, 16.0)
HEAT = GAS_CONSTANT * ROOM_TEMPERATURE


def course(mode="mass", openings=(), air=30e-6, let_out=0.0):
    """A push on an isothermal volume with `air` [kg] in it, from which `let_out` leaves."""
    time = np.arange(-0.5, 6.0, 0.002)
    press = np.interp(time, (0, 1, 3, 4), (0, 1, 1, 0))
    volume = 22e-6 - 2e-6 * press
    inside = air - let_out * (time > 0.5)
    push = Push(mode, PUSH.start, PUSH.pressed, PUSH.released, PUSH.free, PUSH.end)
    pressure = inside * HEAT / volume - AMBIENT_PRESSURE
    return Course(push, time, pressure, volume, inside, press, np.array(openings))


def test_the_volume_told_by_the_joints_is_that_of_the_simulator():
    simulation = Simulation(SimulationConfig(hand=HAND, scene=SCENE, step=0.005))
    try:
        simulation.set_air_masses([9e-6])
        for _ in range(200):
            simulation.step()
        told = volumes(joint_positions(simulation.bodies.q)[None, :])
        rest = volumes(np.zeros((1, 3 * len(simulation.bodies.q))))
        content = AMBIENT_PRESSURE * rest[0] + 9e-6 * HEAT
        assert told[0] == pytest.approx(content / simulation.pressures_abs[0], rel=1e-3)
        assert told[0] > 1.05 * rest[0]
    finally:
        simulation.close()


def test_closed_valves_leave_the_enclosed_air_as_it_was():
    seen = verdict.outcome(course())
    assert seen.pressure[1] > seen.pressure[0] + 1e4
    assert seen.pressure[2] == pytest.approx(seen.pressure[0], abs=1.0)
    assert abs(seen.enclosed_change) < 1e-12 and abs(seen.enclosed_left) < 1e-12


def test_air_let_out_under_the_push_is_missed_after_it():
    seen = verdict.outcome(course("pressure", (0.5,), let_out=2e-6))
    assert seen.openings == 1
    assert seen.enclosed_left == pytest.approx(-2e-6, rel=1e-6)


@pytest.mark.parametrize(
    ("openings", "fits"), [((0, 2, 1), True), ((1, 2, 1), False), ((0, 0, 1), False)]
)
def test_only_mass_control_may_leave_the_valves_closed(openings, fits, tmp_path):
    modes = zip(("mass", "pressure", "volume"), openings, strict=True)
    outcomes = [verdict.outcome(course(mode, np.linspace(0.2, 0.8, n))) for mode, n in modes]
    assert verdict.as_in_the_thesis(outcomes) is fits
    assert verdict.line(outcomes).startswith("as in" if fits else "NOT as in")
    verdict.write(tmp_path / "result.json", outcomes, seed=3)
    written = json.loads((tmp_path / "result.json").read_text())
    assert written["as_in_the_thesis"] is fits and written["seed"] == 3
    assert [push["openings"] for push in written["pushes"]] == list(openings)


def test_the_picture_is_drawn(tmp_path):
    draw([course(), course("pressure", (0.5, 3.5), let_out=1e-6)], tmp_path / "push.png")
    assert (tmp_path / "push.png").stat().st_size > 20_000
