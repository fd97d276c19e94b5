"""The benchmark of the simulator: groups, what counts as missed, where borders lie, its scene."""

import json
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest

from bench.row import stated
from bench.sim import __main__ as bench_sim
from bench.sim import border, engines, friction, motion, step_parts, thesis_table
from bench.sim.__main__ import groups
from bench.sim.timing import StepTimes, timed_steps
from grasp_strategies.judging.judge import GraspResult
from pneuflex_sim.bullet import pybullet
from pneuflex_sim.simulation.config import SimulationConfig
from pneuflex_sim.simulation.simulation import Simulation


def test_every_module_with_rows_is_a_group():
    assert {"thesis_table", "trials", "random_trials", "border"} <= set(groups())
    assert not {"timing", "convergence"} & set(groups())


def test_the_load_that_moves_is_found_by_halving_within_its_tolerance():
    assert friction.threshold(lambda load: load > 0.321, 1.0) == pytest.approx(0.321, abs=2e-3)


def test_a_simulation_with_the_pyramid_is_uneven_and_one_made_after_it_is_not():
    with friction.pyramid():
        uneven = friction.unevenness()[1]
    assert uneven > friction.UNEVEN > friction.EVEN > friction.unevenness()[1]


def test_the_outcome_changes_between_neighbours():
    errors = np.array([-0.02, -0.01, 0.0, 0.01, 0.02])
    found = border.changes(errors, np.array([False, True, True, True, False]))
    assert found == [(-0.02, -0.01), (0.01, 0.02)]


def test_a_lone_failure_is_no_border_and_the_border_is_where_half_of_the_tries_succeed():
    errors = border.tries(-0.01, 0.01)
    success = errors[:, 0] > 0.0
    success[30] = False  # at 5 mm
    assert border.borders(errors, success) == pytest.approx([0.0], abs=border.SPACING)


def test_a_hole_that_closes_has_moved_half_its_width_and_one_that_opens_its_whole_distance():
    errors = np.arange(-10.0, 20.5, 0.5)
    whole, hole = (errors > 0) * 1.0, ((errors > 0) & ((errors < 8) | (errors > 12))) * 1.0
    closes = border.moved(errors, hole, whole, np.array([0.0, 8.0, 12.0]))
    assert closes == pytest.approx(2.0)
    assert border.moved(errors, whole, hole, np.array([0.0])) == pytest.approx(12.0)
    assert border.moved(errors, whole, whole, np.array([0.0])) == 0.0


def test_borders_that_move_with_the_step_are_found_and_judged(monkeypatch):
    place = {0.001: 0.0123, 0.002: 0.0143, 0.005: 0.0163}  # [m]
    monkeypatch.setattr(border, "gripped", lambda error, step: error[0] < place[step])
    found = {row["name"]: row for row in json.loads(json.dumps(border.rows(small=True)))}
    name = "outcome of a grasp, {} ms against 1 ms: {}"
    at_1_ms = found["border 0 of success, 1 ms: error of the seen place"]
    assert at_1_ms["value"] == pytest.approx(12.3, abs=0.5)
    for step, way in (("2", 2.0), ("5", 4.0)):
        moves = found[name.format(step, "border moves")]
        assert moves["value"] == pytest.approx(way, abs=0.75)
        assert moves["met"] == (way < 3.0)
    assert found[name.format("2", "agree beyond 3 mm")]["value"] == 100.0
    assert found[name.format("5", "agree beyond 3 mm")]["value"] < 100.0


def test_an_object_that_lies_where_it_is_seen_is_gripped_and_one_far_beside_is_not():
    assert border.gripped(np.zeros(2), 0.005)
    assert not border.gripped(np.array([-0.08, 0.0]), 0.005)


def test_a_pair_that_first_touches_deep_inside_is_missed_and_one_that_sinks_in_is_not(monkeypatch):
    near, sinks, deep = (2, 0.0004), (0, -0.004), (1, -0.003)
    depths = iter([[(0, -0.0005), near], [sinks, deep], [deep, (2, -0.0035)]])
    engine = SimpleNamespace(world=SimpleNamespace(client=0))
    hand = SimpleNamespace(bodies=SimpleNamespace(ids=[7]), engine=engine)

    def points(physicsClientId):
        return [(0, 7, 1, link, -1, 0, 0, 0, depth) for link, depth in next(depths)]

    monkeypatch.setattr(pybullet, "getContactPoints", points)
    touches = thesis_table.Touches()
    for _ in range(3):
        touches.look(hand)
    assert (touches.begun, touches.missed) == (3, 2)
    assert touches.points == [1, 2, 2]


def test_a_grasp_that_diverged_has_no_speed_and_no_contacts():
    ended = GraspResult.not_begun("the simulation diverged: the object is at nan")
    touches, times = thesis_table.Touches(), StepTimes([0.01], [0.005])
    cell = thesis_table._cell("fast", 5, 0.05, thesis_table.Run(times, touches, ended), 1.92)
    assert [row["name"].split(": ")[1] for row in cell] == ["diverged"]


def test_rows_of_an_earlier_run_stay_in_the_file_and_are_not_printed(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(bench_sim, "OUT", tmp_path)
    for group, name in (("step_parts", "points"), ("trials", "per hour")):
        module = SimpleNamespace(rows=lambda small, name=name: [stated(name, 3.0, "")])
        monkeypatch.setitem(sys.modules, f"bench.sim.{group}", module)
        assert bench_sim.main(["--rows", group]) == 0
        printed = capsys.readouterr().out
        assert name in printed
    assert "points" not in printed
    rows = json.loads((tmp_path / "bench-sim.json").read_text())["rows"]
    assert {row["name"] for row in rows} == {"points", "per hour"}
    assert all("measured" in row for row in rows)


def test_time_inside_is_a_part_of_the_whole_and_the_clock_is_put_back():
    simulation, before = Simulation(SimulationConfig(step=0.01)), pybullet.stepSimulation
    try:
        with timed_steps(lambda _: time.sleep(0)) as times:
            for _ in range(5):
                simulation.step()
    finally:
        simulation.close()
    assert len(times.whole) == len(times.inside) == 5
    assert all(0 < a < b for a, b in zip(times.inside, times.whole, strict=True))
    assert pybullet.stepSimulation is before
    assert times.factor(0.01) == pytest.approx(0.05 / sum(times.whole))


def test_parts_of_a_step_are_of_a_held_object_and_motors_that_are_off_cost_little():
    found = {
        row["name"].removeprefix("step: "): row["value"] for row in step_parts.rows(small=True)
    }
    assert found["object held at the end"] == 1
    assert found["engine, object held"] > found["engine, nothing touched but the table"] > 0
    chain = "chain of 10 spherical joints, motors {}"
    assert found[chain.format("off")] < found[chain.format("on")]


@pytest.mark.parametrize("step", [0.001, 0.01])
def test_a_damped_swing_has_its_natural_frequency_by_the_recurrence_and_by_its_spectrum(step):
    turning, damping = 2 * np.pi * 6.0, 0.3
    decay, ringing = damping * turning, turning * np.sqrt(1 - damping**2)
    times = np.arange(0.0, 1.0, step)
    shares = np.exp(-decay * times) * (
        np.cos(ringing * times) + decay / ringing * np.sin(ringing * times)
    )
    speeds = -(turning**2) / ringing * np.exp(-decay * times) * np.sin(ringing * times)
    assert motion.recurrent_frequency(shares, step) == pytest.approx(6.0, rel=1e-6)
    assert engines.spectral_frequency(speeds, step) == pytest.approx(6.0, rel=0.05)
