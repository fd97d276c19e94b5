"""Commands of a phase beside masses and straight ways: pressures, turns about a point, waits."""

import math

import numpy as np
import pytest
from mock_scene import PRESSURE_OF_AIR, MockScene

from grasp_strategies.pose import Pose, angle_between
from grasp_strategies.sequencer import Sequencer
from grasp_strategies.strategy import load_strategy
from softhand_common.numerics.rotations import from_rpy

STEP = 0.01
HEAD = """
format: softhand-strategy/1
name: test
description: some phases
hand: rbo_hand_2
phases:
"""
HOLD = "  - name: hold\n    duration: 0.1\n"


@pytest.fixture
def run(write_strategy):
    """Run phases, then a short hold, on a scene; returns when each phase began [s] and the reason
    of the end.
    """

    def run(scene, phases):
        begins = {}
        path = write_strategy(text=HEAD + phases + HOLD)
        result = Sequencer(
            scene,
            load_strategy(path),
            control_step=STEP,
            on_phase=lambda name: begins.setdefault(name, scene.time),
        ).run()
        return begins, result.reason

    return run


def test_a_pressure_rises_in_a_straight_line_and_is_then_left_alone(run):
    scene = MockScene()
    run(scene, "  - name: inflate\n    pressure: {b: 60.0e+3}\n    air_ramp: 0.5\n")
    times, pressures = (np.array(part) for part in zip(*scene.pressure_commands, strict=True))
    assert pressures[:, 1] == pytest.approx(np.minimum(60e3 * times / 0.5, 60e3))
    assert times[-1] == pytest.approx(0.5)
    assert np.isnan(pressures[:, [0, 2, 3]]).all()
    assert scene.air_commands == []


def test_a_channel_that_changes_from_mass_to_pressure_sets_out_from_what_is_measured(run):
    scene = MockScene()
    phases = """
  - name: fill
    air_mass: {a: 2.0e-5, b: 1.0e-5}
  - name: squeeze
    pressure: {a: 90.0e+3}
    air_ramp: 0.2
  - name: empty
    air_mass: {a: 0}
    air_ramp: 0.2
"""
    begins, _ = run(scene, phases)
    squeezed = [value[0] for _, value in scene.pressure_commands]
    assert squeezed[0] == pytest.approx(2e-5 * PRESSURE_OF_AIR)
    assert squeezed[-1] == pytest.approx(90e3)
    emptied = [masses for time, masses in scene.air_commands if time >= begins["empty"] - 1e-9]
    # of the ramp from 60 to 90 kPa in 20 steps, 19 have been measured
    assert emptied[0][0] == pytest.approx(88.5e3 / PRESSURE_OF_AIR)
    assert emptied[-1].tolist() == [0.0, 1e-5, 0.0, 0.0]


@pytest.mark.parametrize(
    ("command", "until"),
    [
        ("air_mass: {a: 1.0e-5}", "air_mass_error: {below: 4.0e-6}"),
        ("pressure: {a: 30.0e+3}", "pressure_error: {below: 12.0e+3}"),
        ("pressure: {a: 30.0e+3}", "pressure: {above: 1.0e+3}"),
    ],
)
def test_a_condition_on_the_air_waits_for_the_end_of_the_ramp(run, command, until):
    scene = MockScene()
    phase = f"""
  - name: fill
    {command}
    air_ramp: 0.5
    until: {{{until}}}
    time_out: 3.0
"""
    begins, _ = run(scene, phase)
    assert begins["hold"] == pytest.approx(0.5, abs=1.1 * STEP)
    assert scene.air_goal[0] == pytest.approx(1e-5)  # the goal itself, not the last but one


def phase_poses(scene, begin):
    """Commanded poses of the wrist in a phase that begins at a time, where the one before ends."""
    return [Pose(*pose) for time, *pose in scene.wrist_commands if time >= begin - 1e-9][1:]


def test_a_turn_about_a_pivot_leaves_the_pivot_where_it_is(run):
    scene, pivot = MockScene(), np.array([-0.005, 0.01, 0.1])
    phase = """
  - name: start
    wrist: {frame: environment, position: [0.1, 0.2, 0.3], rpy: [0.2, 0.5, -0.3]}
    duration: 0.1
  - name: turn
    wrist: {frame: wrist, pivot: [-0.005, 0.01, 0.1], position: [0, 0, 0], rpy: [0, 0.7, 0]}
    duration: 0.5
"""
    begins, _ = run(scene, phase)
    turning = phase_poses(scene, begins["turn"])
    places = np.array([pose.place(pivot) for pose in turning])
    np.testing.assert_allclose(places, np.broadcast_to(places[0], places.shape), atol=1e-12)
    turned = angle_between(turning[0].orientation, turning[-1].orientation)
    assert turned == pytest.approx(0.7)
    # the wrist itself goes along an arc about the pivot's axis, half way at half the time
    assert angle_between(turning[0].orientation, turning[25].orientation) == pytest.approx(0.35)
    radius = math.hypot(0.005, 0.1)
    chord = np.linalg.norm(turning[25].position - turning[0].position)
    assert chord == pytest.approx(2 * radius * math.sin(0.35 / 2))


def test_a_position_with_a_pivot_says_where_the_pivot_goes(run):
    scene, pivot = MockScene(), np.array([0.0, 0.0, 0.1])
    phase = """
  - name: go
    wrist: {frame: environment, pivot: [0, 0, 0.1], position: [0.1, 0.2, 0.3], rpy: [1, 0.5, 0]}
    duration: 0.2
  - name: further
    wrist: {frame: wrist_level, pivot: [0, 0, 0.1], position: [0.05, 0, 0], rpy: [0, 0, 0]}
    duration: 0.2
"""
    begins, _ = run(scene, phase)
    there = phase_poses(scene, begins["further"])[0]
    assert there.place(pivot) == pytest.approx([0.1, 0.2, 0.3])
    assert angle_between(there.orientation, from_rpy((1.0, 0.5, 0.0))) == pytest.approx(0, abs=1e-7)
    assert scene.wrist.place(pivot) == pytest.approx([0.15, 0.2, 0.3])


def test_a_phase_may_wait_until_named_bodies_press_on_the_object(run):
    scene = MockScene()
    scene.on_step = lambda: (
        setattr(scene, "also_touching", frozenset({"index", "thumb"}))
        if scene.time > 0.3
        else setattr(scene, "also_touching", frozenset({"index"}))
    )
    phase = """
  - name: close
    until: {touching: [index, thumb]}
    time_out: 1.0
"""
    begins, _ = run(scene, phase)
    assert begins["hold"] == pytest.approx(0.31)


def test_a_touch_that_never_comes_is_named(run):
    _, reason = run(
        MockScene(), "  - name: close\n    until: {touching: [index]}\n    time_out: 0.2\n"
    )
    assert reason == "phase close: expected touching index within 0.2 s, got touching table"


def test_contact_force_counts_from_what_the_wrist_felt_as_the_phase_began(run):
    scene = MockScene(touch_height=0.402)  # presses with 2 N at the start
    phase = """
  - name: down
    wrist: {frame: wrist_level, position: [0, 0, -0.01]}
    duration: 1.0
    until: {contact_force: {above: 3.0}}
    time_out: 2.0
"""
    run(scene, phase)
    assert 0.402 - scene.wrist.position[2] == pytest.approx(0.005, abs=3e-4)
