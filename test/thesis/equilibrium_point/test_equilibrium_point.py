"""What is read from a push on the finger, and what is said of it."""

import numpy as np
import pytest

from pneuflex_sim.simulation import Simulation, SimulationConfig
from pneuflex_sim.urdf import joint_positions
from softhand_model.gas import AMBIENT_PRESSURE, GAS_CONSTANT, ROOM_TEMPERATURE
from thesis import frame
from thesis.equilibrium_point import equilibrium_point
from thesis.equilibrium_point.equilibrium_point import as_results, enclosed_changes, looks
from thesis.equilibrium_point.recording import HAND, Push, Recording, volumes
from thesis.equilibrium_point.session import SCENE

PUSH = Push("mass", 10.0, 11.0, 13.0, 14.0, 16.0)
HEAT = GAS_CONSTANT * ROOM_TEMPERATURE


def recording(mode="mass", openings=(), air=30e-6, let_out=0.0):
    """A push on an isothermal volume with `air` [kg] in it, from which `let_out` leaves."""
    time = np.arange(-0.5, 6.0, 0.002)
    press = np.interp(time, (0, 1, 3, 4), (0, 1, 1, 0))
    volume = 22e-6 - 2e-6 * press
    inside = air - let_out * (time > 0.5)
    push = Push(mode, PUSH.start, PUSH.pressed, PUSH.released, PUSH.free, PUSH.end)
    pressure = inside * HEAT / volume - AMBIENT_PRESSURE
    return Recording(push, time, pressure, volume, inside, press, np.array(openings))


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
    seen = recording()
    before, pressed, after = looks(seen, seen.pressure)
    assert pressed > before + 1e4
    assert after == pytest.approx(before, abs=1.0)
    assert np.abs(enclosed_changes(seen)).max() < 1e-12


def test_air_let_out_under_the_push_is_missed_after_it():
    seen = recording("pressure", (0.5,), let_out=2e-6)
    assert enclosed_changes(seen)[1] == pytest.approx(-2e-6, rel=1e-6)


def pushed(*openings):
    modes = zip(("mass", "pressure", "volume"), openings, strict=True)
    return as_results([recording(mode, np.linspace(0.2, 0.8, n)) for mode, n in modes])


@pytest.mark.parametrize(
    ("openings", "fits"), [((0, 2, 1), True), ((1, 2, 1), False), ((0, 0, 1), False)]
)
def test_only_mass_control_may_leave_the_valves_closed(openings, fits):
    report = equilibrium_point.report(pushed(*openings), equilibrium_point.Parameters())
    assert all(report.judged) is fits
    assert report.verdict.startswith("holds (3 of 3" if fits else "falls short (2 of 3")
    assert [report[f"{mode} control: valve openings"] for mode in equilibrium_point.MODES] == list(
        openings
    )


def test_pushes_that_were_kept_are_told_and_drawn_as_before(tmp_path):
    results, given = pushed(0, 2, 1), equilibrium_point.Parameters(seed=3)
    report = equilibrium_point.report(results, given)
    frame.write_result(tmp_path, equilibrium_point, given, results, report)
    again, read = frame.read_result(tmp_path, equilibrium_point)
    assert again == given and equilibrium_point.report(read, again) == report
    frame.save_figure(equilibrium_point, read, report, tmp_path / "push.png")
    assert (tmp_path / "push.png").stat().st_size > 20_000
