"""The same strategy over ROS is the same run each time, whatever else the machine does, and whether
the driver is in the simulator's process or in one of its own.
"""

from dataclasses import replace

import pytest

from bench.robust.same_run import busy, run_once
from softhand_bringup.processes.suite import SuiteOptions

# down beside the cylinder and into it, by air mass and by pressure
STRATEGY = """
format: softhand-strategy/1
name: short
description: touches, closes and presses, with all that a strategy commands
hand: rbo_hand_2
success: {lift_height: 0.1, hold_time: 1.0, hold_phase: press}
phases:
  - name: approach
    wrist: {frame: object, position: [-0.026, -0.049, 0.150], rpy: [0, 2.356, 0.6]}
    speed: 1.0
    air_mass: {a: 0, b: 0, c: 0, d: 0}
  - name: touch
    wrist: {frame: wrist_level, position: [0, 0, -0.05]}
    speed: 0.2
    until: {contact_force: {above: 1.5}}
    time_out: 3.0
    on_time_out: error
  - name: close
    air_mass: {a: 1.5e-5, b: 1.0e-5}
    air_ramp: 0.3
  - name: press
    pressure: {c: 12.0e+3, d: 25.0e+3}
    until: {pressure_error: {below: 1.5e+3}}
    time_out: 4.0
    on_time_out: error
"""


@pytest.mark.timeout(240)
def test_runs_are_the_same_bit_for_bit_on_a_busy_machine_and_in_one_process(tmp_path):
    strategy = tmp_path / "short.yaml"
    strategy.write_text(STRATEGY)
    every = {"driver": "topic", "state_rate": 0.0}
    options = SuiteOptions(strategy=str(strategy), await_commander=True, **every)
    first = run_once(options)
    with busy(2):
        second = run_once(options)
    with busy(4):
        composed = run_once(replace(options, driver="composed", state_rate=100.0))
    # it has moved the object, and pressure commands were obeyed: the phase `press` has ended
    assert max(abs(first.places[-1] - first.places[0])) > 1e-3
    assert first.answer == "none: table touched the object in the hold"
    for other in (second, composed):
        assert first.answer == other.answer
        assert first.begin == other.begin
        assert first.distance(other) == 0.0
        assert first.commands_alike(other) == 100.0
        assert len(other.states) > 200
        assert first.states_alike(other) == 100.0
